"""Maps as DXF: CAD programs find every feature on its layer, in metres, with dimensions that measure it."""

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyogrio
import pytest
from ezdxf._options import options
from ezdxf.document import Drawing
from ezdxf.entities import Dimension
from ezdxf.filemanagement import readfile

from echoplan.errors import MissingExtraError
from echoplan.io import write_dxf
from echoplan.model import FeatureMap, Quality, Verdict
from helpers import maps
from helpers.drawings import STATIONS, gapped_map


def written(tmp_path: Path, found: FeatureMap) -> Drawing:
    """A map, written and read back."""
    write_dxf(tmp_path / "map.dxf", found)
    return readfile(tmp_path / "map.dxf")


def room() -> FeatureMap:
    """An L-shaped room with a corner and two columns, one of them without a radius."""
    walls = [maps.wall(start, end) for start, end in maps.ROOM.walls_xy]
    columns = maps.cylinder([3.5, 0.6], 0.1), maps.cylinder([1.0, 1.0], 0.0)
    return maps.drawn(*walls, maps.corner([0.0, 0.0]), *columns, poses=STATIONS)


def dimensions(drawing: Drawing) -> list[Dimension]:
    """The dimensions of a drawing."""
    return [each for each in drawing.modelspace().query("DIMENSION") if isinstance(each, Dimension)]


def test_every_feature_is_on_its_layer(tmp_path: Path) -> None:
    drawing = written(tmp_path, room())
    counts = Counter((each.dxftype(), each.dxf.layer) for each in drawing.modelspace())
    assert counts == {
        ("LINE", "WALLS"): 6,
        ("POINT", "CORNERS"): 1,
        ("CIRCLE", "CYLINDERS"): 1,
        ("POINT", "CYLINDERS"): 1,
        ("DIMENSION", "DIMENSIONS"): 6,
    }


def test_a_drawing_is_in_metres_and_without_faults(tmp_path: Path) -> None:
    drawing = written(tmp_path, room())
    assert (drawing.header["$INSUNITS"], drawing.header["$MEASUREMENT"]) == (6, 1)
    audit = drawing.audit()
    assert (audit.errors, audit.fixes) == ([], [])


def test_gdal_reads_the_faces_where_they_are(tmp_path: Path) -> None:
    write_dxf(tmp_path / "map.dxf", room())
    meta, _, _, columns = pyogrio.raw.read(tmp_path / "map.dxf", where="Layer = 'WALLS'")
    assert len(columns[meta["fields"].tolist().index("Layer")]) == 6
    info = pyogrio.read_bounds(tmp_path / "map.dxf", where="Layer = 'WALLS'")[1]
    assert [info[:2].min(axis=1).tolist(), info[2:].max(axis=1).tolist()] == [[0.0, 0.0], [5.0, 3.0]]


def test_dimensions_measure_the_walls_outside_the_room(tmp_path: Path) -> None:
    drawn = dimensions(written(tmp_path, room()))
    assert sorted(round(float(each.get_measurement()), 3) for each in drawn) == [1.5, 1.5, 2.0, 3.0, 3.0, 5.0]
    lines = np.array([each.dxf.defpoint.vec2 for each in drawn])
    # The dimension line of the floor runs below it, and that of the left wall to the left of it.
    assert lines[:, 1].min() < -0.1
    assert lines[:, 0].min() < -0.1


def test_text_is_read_from_below_or_from_the_right_whichever_way_a_wall_runs(tmp_path: Path) -> None:
    angles = [np.radians(degrees) for degrees in (0, 30, 89.9, 90.1, 170, 180, 210, 269.9, 270.1, 330)]
    for angle in angles:
        far = [4.0 * np.cos(angle), 4.0 * np.sin(angle)]
        (only,) = dimensions(written(tmp_path, maps.drawn(maps.wall([0.0, 0.0], far))))
        assert -80.1 <= (float(only.dxf.angle) + 180.0) % 360.0 - 180.0 <= 100.1


def test_short_walls_have_no_dimension(tmp_path: Path) -> None:
    found = maps.drawn(maps.wall([0.0, 0.0], [10.0, 0.0]), maps.wall([3.0, 1.0], [3.1, 1.0]))
    assert [each.get_measurement() for each in dimensions(written(tmp_path, found))] == [pytest.approx(10.0)]


def test_inferred_ends_are_dashed_and_stretches_that_were_not_observed_are_no_walls(tmp_path: Path) -> None:
    space = written(tmp_path, gapped_map()).modelspace()
    pieces = {
        (round(line.dxf.start.x, 9), round(line.dxf.end.x, 9)): line.dxf.linetype
        for line in space.query("LINE[layer=='WALLS']")
    }
    assert pieces == {
        (0.0, 1.0): "BYLAYER",
        (1.9, 3.0): "BYLAYER",
        (3.25, 4.0): "BYLAYER",
        (4.5, 5.5): "BYLAYER",
        (5.5, 6.0): "DASHED",
    }
    (stretch,) = space.query("LINE[layer=='UNOBSERVED']")
    assert (stretch.dxf.start.x, stretch.dxf.end.x) == (4.0, 4.5)
    assert len(space.query("LINE[layer=='OPENINGS']")) == 2


def test_a_wall_inferred_over_more_than_its_length_is_dashed_all_along(tmp_path: Path) -> None:
    wall = replace(maps.wall([0.0, 0.0], [1.0, 0.0]), inferred=np.array([0.9, 0.9]))
    lines = list(written(tmp_path, maps.drawn(wall)).modelspace().query("LINE"))
    assert {line.dxf.linetype for line in lines} == {"DASHED"}
    assert sum((line.dxf.end - line.dxf.start).magnitude for line in lines) == pytest.approx(1.0)


def test_a_map_that_is_not_good_says_so(tmp_path: Path) -> None:
    for verdict, notes in (
        (Verdict.GOOD, []),
        (Verdict.DOUBTFUL, ["echoplan: doubtful map"]),
        (Verdict.FAILED, ["echoplan: failed map"]),
    ):
        space = written(tmp_path, replace(room(), quality=Quality(verdict=verdict))).modelspace()
        assert [each.dxf.text for each in space.query("TEXT[layer=='NOTES']")] == notes


def test_an_empty_map_is_an_empty_drawing(tmp_path: Path) -> None:
    drawing = written(tmp_path, FeatureMap(method="rcd"))
    assert list(drawing.modelspace()) == []
    assert not drawing.audit().errors


def test_the_same_map_gives_the_same_bytes_and_dates_of_other_drawings_stay(tmp_path: Path) -> None:
    for name in ("one.dxf", "other.dxf"):
        write_dxf(tmp_path / name, room())
    assert (tmp_path / "one.dxf").read_bytes() == (tmp_path / "other.dxf").read_bytes()
    assert not options.write_fixed_meta_data_for_testing


def test_the_order_of_the_classes_does_not_depend_on_hashes(tmp_path: Path) -> None:
    drawing = written(tmp_path, room())
    used = drawing.entitydb.dxf_types_in_use()
    listed = [name for name, _ in drawing.classes.classes if name in used]
    assert len(listed) > 1
    assert listed == sorted(listed)


def test_without_ezdxf_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ezdxf.filemanagement", None)
    with pytest.raises(MissingExtraError, match=r"pip install ezdxf \(extra 'cad'\)"):
        write_dxf(tmp_path / "map.dxf", room())
    assert not list(tmp_path.iterdir())

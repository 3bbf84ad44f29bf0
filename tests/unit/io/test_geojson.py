"""Maps as GeoJSON: GDAL reads every feature, where it is, and that it lies in local metres."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyogrio
import pytest
import shapely
from numpy.typing import NDArray

from echoplan.io import read_map, write_geojson
from echoplan.io.geojson import LOCAL_METRES
from echoplan.model import Changes, FeatureMap, Quality, Verdict
from helpers import maps
from helpers.drawings import gapped_map

GOLDEN = Path(__file__).parents[2] / "golden" / "formats" / "map-openings.json"


@pytest.fixture
def gapped(tmp_path: Path) -> Path:
    """A floor with gaps, a corner and a column of 0.5 m beside it, written."""
    features = maps.drawn(maps.corner([0.0, 0.0]), maps.cylinder([1.0, -2.0], 0.5), maps.cylinder([3.0, 1.0], 0.0))
    found = replace(gapped_map(), corners=features.corners, cylinders=features.cylinders)
    write_geojson(tmp_path / "map.geojson", found)
    return tmp_path / "map.geojson"


def features_of(path: Path) -> dict[str, dict[str, Any]]:
    """Features by their id."""
    return {each["id"]: each for each in json.loads(path.read_text(encoding="utf-8"))["features"]}


def table_of(path: Path) -> tuple[dict[str, Any], NDArray[Any]]:
    """Columns and shapes as GDAL reads them."""
    meta, _, geometries, columns = pyogrio.raw.read(path)
    return dict(zip(meta["fields"].tolist(), columns, strict=True)), shapely.from_wkb(geometries)


def test_gdal_counts_every_feature_in_its_extent(gapped: Path) -> None:
    columns, shapes = table_of(gapped)
    kinds, counts = np.unique(columns["kind"], return_counts=True)
    assert dict(zip(kinds.tolist(), counts.tolist(), strict=True)) == {
        "wall": 4,
        "opening": 2,
        "unobserved": 1,
        "corner": 1,
        "cylinder": 2,
        "path": 1,
    }
    info = pyogrio.read_info(gapped, force_feature_count=True, force_total_bounds=True)
    assert info["features"] == 11
    assert sorted(columns["id"]) == sorted(features_of(gapped))
    assert info["total_bounds"] == pytest.approx((0.0, -2.5, 6.0, 1.0))
    lengths = {kind: shapely.length(shapes[columns["kind"] == kind]).tolist() for kind in ("wall", "opening")}
    assert lengths == {kind: columns["length"][columns["kind"] == kind].tolist() for kind in lengths}


def test_gdal_knows_that_coordinates_are_local_metres_and_not_degrees(gapped: Path) -> None:
    crs = pyogrio.read_info(gapped)["crs"]
    assert crs.startswith('LOCAL_CS["local metres"')
    assert 'UNIT["metre",1]' in crs


def test_a_wall_has_its_numbers_as_properties(gapped: Path) -> None:
    wall = features_of(gapped)["wall-3"]
    assert wall["geometry"] == {"type": "LineString", "coordinates": [[4.5, 0.0], [6.0, 0.0]]}
    properties = wall["properties"]
    assert (properties["kind"], properties["number"], properties["length"]) == ("wall", 3, 1.5)
    assert (properties["sigma_start"], properties["sigma_end"]) == (0.01, None)
    assert (properties["inferred_start"], properties["inferred_end"]) == (0.0, 0.5)
    # 10 mm of offset, and 10 mrad about a foot that is 5.25 m away.
    assert properties["sigma"] == pytest.approx(0.01 * np.hypot(1.0, 5.25))
    assert (properties["probability"], properties["pings"], properties["stations"]) == (1.0, 0, 0)


def test_an_opening_says_whether_the_robot_drove_through_and_beside_which_walls_it_is(gapped: Path) -> None:
    opening = features_of(gapped)["opening-0"]["properties"]
    assert opening == {
        "kind": "opening",
        "number": 0,
        "length": pytest.approx(0.9),
        "sigma": 0.02,
        "passed": True,
        "walls": [0, 1],
    }


def test_a_cylinder_is_a_polygon_with_its_radius_and_a_point_without_one(gapped: Path) -> None:
    written = features_of(gapped)
    column = shapely.from_geojson(json.dumps(written["cylinder-0"]["geometry"]))
    assert written["cylinder-0"]["properties"]["radius"] == 0.5
    assert shapely.is_ccw(shapely.get_exterior_ring(column))
    assert shapely.area(column) == pytest.approx(np.pi * 0.25, rel=2e-3)
    assert shapely.hausdorff_distance(column, shapely.Point(1.0, -2.0).buffer(0.5, quad_segs=64)) < 0.002 * 0.5
    assert written["cylinder-1"]["geometry"] == {"type": "Point", "coordinates": [3.0, 1.0]}


def test_the_path_is_a_line_or_the_point_where_the_robot_stood_or_is_left_out(tmp_path: Path) -> None:
    paths = []
    for poses in ([], [[1.0, 2.0, 0.3]], [[1.0, 2.0, 0.0], [1.0, 2.0, 1.0]], [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]]):
        write_geojson(tmp_path / "map.geojson", maps.drawn(poses=poses))
        paths.append(features_of(tmp_path / "map.geojson").get("path-0"))
    assert paths[0] is None
    assert [each["geometry"]["type"] for each in paths if each] == ["Point", "Point", "LineString"]
    assert [each["properties"]["length"] for each in paths if each] == [0.0, 0.0, 5.0]


def test_each_recording_has_a_path_of_its_own(tmp_path: Path) -> None:
    poses = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [9.0, 9.0, 0.0]]
    write_geojson(tmp_path / "map.geojson", replace(maps.drawn(poses=poses), changes=(Changes(first_sweep=2),)))
    written = features_of(tmp_path / "map.geojson")
    assert written["path-0"]["geometry"]["coordinates"] == [[0.0, 0.0], [3.0, 4.0]]
    assert written["path-1"]["geometry"]["coordinates"] == [9.0, 9.0]


def test_a_file_says_how_far_its_map_can_be_trusted(tmp_path: Path) -> None:
    quality = Quality(verdict=Verdict.FAILED, reasons=("Nothing was detected.",), next_step="Check the wiring.")
    write_geojson(tmp_path / "map.geojson", FeatureMap(method="joint", quality=quality))
    document = json.loads((tmp_path / "map.geojson").read_text())
    assert document["crs"] == {"type": "name", "properties": {"name": LOCAL_METRES}}
    assert document["echoplan"] == {
        "frame": "map",
        "unit": "m",
        "method": "joint",
        "quality": {
            "verdict": "failed",
            "reasons": ["Nothing was detected."],
            "next_step": "Check the wiring.",
        },
    }
    assert document["features"] == []


def test_the_same_map_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "other"):
        write_geojson(tmp_path / name, read_map(GOLDEN))
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()

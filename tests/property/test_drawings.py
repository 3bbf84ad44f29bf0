"""Laws of what is written for other programs: any map is written, and they find in it what the map holds."""

from itertools import combinations

import pyogrio
import pytest
from ezdxf.filemanagement import readfile
from hypothesis import given
from hypothesis import settings as hypothesis_settings

from echoplan.io import write_dxf, write_geojson
from echoplan.model import FeatureMap
from echoplan.viewer import Plan, floor_plan_pdf
from echoplan.viewer.floor_layout import floor_layout
from helpers.any_map import maps


@hypothesis_settings(max_examples=60, deadline=None)
@given(found=maps())
def test_gdal_reads_every_feature_of_any_map_from_geojson(
    found: FeatureMap, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.geojson"
    write_geojson(path, found)
    features = (*found.walls, *found.openings, *found.unobserved, *found.corners, *found.cylinders)
    assert pyogrio.read_info(path, force_feature_count=True)["features"] == len(features) + bool(len(found.poses))


@hypothesis_settings(max_examples=30, deadline=None)
@given(found=maps())
def test_any_map_is_a_drawing_without_faults(found: FeatureMap, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "any.dxf"
    write_dxf(path, found)
    drawing = readfile(path)
    assert not drawing.audit().errors
    # A wall of which both ends are inferred has up to three pieces.
    assert len(found.walls) <= len(drawing.modelspace().query("LINE[layer=='WALLS']")) <= 3 * len(found.walls)
    assert len(drawing.modelspace().query("*[layer=='CYLINDERS']")) == len(found.cylinders)


@hypothesis_settings(max_examples=10, deadline=None)
@given(found=maps())
def test_any_map_is_a_floor_plan_without_overlapping_dimensions_and_labels(found: FeatureMap) -> None:
    assert floor_plan_pdf(Plan(feature_map=found), name=found.method).startswith(b"%PDF")
    layout = floor_layout(found, foot=32.0)
    assert not any(one.intersects(other) for one, other in combinations(layout.footprints, 2))

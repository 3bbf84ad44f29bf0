from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.model import Corner, CornerKind, FeatureMap
from echoplan.viewer.marks import (
    corner_marks,
    cylinder_marks,
    detection_marks,
    echo_marks,
    gap_marks,
    station_marks,
    truth_marks,
    wall_marks,
)
from echoplan.viewer.plan import Plan
from echoplan.viewer.sheet import Sheet
from helpers.drawings import STATIONS, full_plan, gapped_map, group_of, marked, placed, stroke, strokes, the
from helpers.maps import NOWHERE, ROOM, corner, cylinder, drawn, wall
from helpers.scenes import observed_circle, observed_wall

# Four metres by three at 1 : 25, a metre is 40 mm: the origin lies at (10, 130) on paper.
SHEET = Sheet(bounds_xy=np.array([[0.0, 0.0], [4.0, 3.0]]))
NOTHING = Plan(feature_map=FeatureMap(method="none"))
# Roots of the quantiles 0.95 of chi-squared with one and with two degrees of freedom.
BAND, ELLIPSE = 1.959964, 2.447747


def paper(x: float, y: float) -> FloatArray:
    """Where a point of the map lies on the sheet [mm], worked out by hand."""
    return np.array([10 + 40 * x, 130 - 40 * y])


def plan(*features: object, poses: object = ()) -> Plan:
    return Plan(feature_map=drawn(*features, poses=poses))  # type: ignore[arg-type]


def test_the_sheet_of_these_tests_is_to_scale() -> None:
    np.testing.assert_allclose(SHEET.paper([1.0, 2.0]), paper(1.0, 2.0))


def test_a_map_of_nothing_has_no_marks() -> None:
    assert wall_marks(NOTHING, SHEET) == corner_marks(NOTHING, SHEET) == cylinder_marks(NOTHING, SHEET) == []
    assert detection_marks(NOTHING, SHEET) == []
    assert [each.attrib["d"] for each in echo_marks(NOTHING, SHEET)] == [""]
    assert [each.attrib["d"] for each in station_marks(NOTHING, SHEET)] == [""]
    assert [each.attrib["d"] for each in truth_marks(NOWHERE, SHEET)] == [""]


def test_the_face_of_a_wall_runs_from_its_start_to_its_end_to_scale() -> None:
    (made,) = wall_marks(plan(wall([0.5, 1.0], [3.0, 2.25])), SHEET)
    np.testing.assert_allclose(stroke(the(made, "face")), [paper(0.5, 1.0), paper(3.0, 2.25)])


def test_the_body_of_a_wall_lies_behind_its_face() -> None:
    one = plan(wall([0.0, 0.0], [4.0, 0.0]), poses=[[2.0, 1.0, 0.0]])
    body = stroke(the(wall_marks(one, SHEET), "body"))
    back = -one.thickness
    np.testing.assert_allclose(body, [paper(0, 0), paper(4, 0), paper(4, back), paper(0, back)], atol=1e-4)
    assert the(wall_marks(one, SHEET), "body").attrib["d"].endswith("Z")


@pytest.mark.parametrize("end", [[3.0, 1.0], [1.0, 3.0], [0.0, 2.0], [2.5, 0.0]])
def test_the_band_of_a_wall_lies_along_its_face(end: list[float]) -> None:
    one = wall([1.0, 1.0], end)
    group = group_of(wall_marks(plan(one), SHEET), "band")
    place, turn = placed(group)
    np.testing.assert_allclose(place, paper(1.0, 1.0))
    reached = place + 40 * one.length * np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    np.testing.assert_allclose(reached, paper(*end), atol=1e-3)


def test_the_band_of_a_wall_is_as_wide_as_it_is_unsure() -> None:
    one = wall([0.0, 1.0], [4.0, 1.0], covariance=np.diag([0.0, 0.01**2]))
    outline = stroke(the(wall_marks(plan(one), SHEET), "band"))
    np.testing.assert_allclose(np.abs(outline[:, 1]), 40 * BAND * 0.01, atol=1e-4)
    assert outline[:, 0].min() == 0.0
    assert outline[:, 0].max() == 160.0


def test_the_band_goes_along_one_side_and_back_along_the_other() -> None:
    outline = stroke(the(wall_marks(plan(wall([0.0, 1.0], [4.0, 1.0])), SHEET), "band"))
    half = len(outline) // 2
    np.testing.assert_array_equal(outline[half:], outline[:half][::-1] * [1.0, -1.0])


def test_a_convex_corner_differs_from_a_concave_one() -> None:
    edge = Corner(position_xy=np.array([1.0, 2.0]), kind=CornerKind.CONVEX, covariance=np.eye(2))
    first, second = corner_marks(plan(corner([0.0, 0.0]), edge), SHEET)
    assert the(first, "mark").attrib["class"] == "mark concave"
    assert the(second, "mark").attrib["class"] == "mark convex"


def test_the_mark_of_a_corner_lies_on_it_with_its_centre_of_gravity() -> None:
    (made,) = corner_marks(plan(corner([1.0, 2.0])), SHEET)
    place, _ = placed(group_of(made, "fixed"))
    np.testing.assert_allclose(place, paper(1.0, 2.0))
    np.testing.assert_allclose(stroke(the(made, "mark")).mean(axis=0), [0.0, 0.0], atol=1e-9)


def test_the_ellipse_of_a_corner_has_half_axes_to_scale() -> None:
    one = Corner(position_xy=np.array([1.0, 2.0]), kind=CornerKind.CONCAVE, covariance=np.diag([4e-4, 1e-4]))
    (made,) = corner_marks(plan(one), SHEET)
    ellipse = the(made, "ellipse")
    assert float(ellipse.attrib["rx"]) == pytest.approx(40 * ELLIPSE * 0.02, abs=1e-4)
    assert float(ellipse.attrib["ry"]) == pytest.approx(40 * ELLIPSE * 0.01, abs=1e-4)
    np.testing.assert_allclose(placed(group_of(made, "ellipse"))[0], paper(1.0, 2.0))


def test_an_ellipse_turns_against_the_clock_on_paper_too() -> None:
    # Long along y = x: on paper, where y points down, that is a turn of -45 degrees.
    leaning = replace(corner([1.0, 1.0]), covariance=np.array([[2e-4, 1e-4], [1e-4, 2e-4]]))
    _, turn = placed(group_of(corner_marks(plan(leaning), SHEET), "ellipse"))
    assert turn % 180 == pytest.approx(135)


def test_corners_and_cylinders_keep_their_own_ellipses() -> None:
    one = plan(corner([0.0, 0.0], sigma=0.03), cylinder([2.0, 1.0], 0.25, sigma=0.01))
    (at_corner,) = corner_marks(one, SHEET)
    (at_cylinder,) = cylinder_marks(one, SHEET)
    assert float(the(at_corner, "ellipse").attrib["rx"]) == pytest.approx(40 * ELLIPSE * 0.03, abs=1e-4)
    assert float(the(at_cylinder, "ellipse").attrib["rx"]) == pytest.approx(40 * ELLIPSE * 0.01, abs=1e-4)
    np.testing.assert_allclose(placed(group_of(at_cylinder, "ellipse"))[0], paper(2.0, 1.0))


def test_a_cylinder_is_a_circle_of_its_radius_to_scale() -> None:
    (made,) = cylinder_marks(plan(cylinder([2.0, 1.0], 0.25)), SHEET)
    body = the(made, "body").attrib
    assert [float(body[name]) for name in ("cx", "cy", "r")] == [*paper(2.0, 1.0), 10.0]
    np.testing.assert_allclose(placed(group_of(made, "fixed"))[0], paper(2.0, 1.0))
    assert len(marked(made, "axis")) == 1


@pytest.mark.parametrize("marks", [wall_marks, corner_marks, cylinder_marks])
def test_every_feature_can_be_found_reached_by_the_keyboard_and_read_out(marks: object) -> None:
    made = marks(full_plan(), SHEET)  # type: ignore[operator]
    kind = made[0].attrib["id"].split("-")[0]
    assert [each.attrib["id"] for each in made] == [f"{kind}-{number}" for number in range(len(made))]
    for each in made:
        assert each.attrib["class"] == f"feature {kind}"
        assert each.attrib["tabindex"] == "0"
        assert each.attrib["role"] == "img"
        # The first child names the group; a title anywhere else would be passed over.
        assert each[0].tag == "title"
        assert (each[0].text or "").startswith(each.attrib["id"].replace("-", " ") + "\n")


def test_the_title_of_a_feature_has_its_numbers_and_units() -> None:
    (made,) = wall_marks(plan(wall([0.0, 0.0], [2.5, 0.0])), SHEET)
    lines = (made[0].text or "").splitlines()
    assert lines[0] == "wall 0"
    assert "length: 2.500 m" in lines


def test_marks_of_one_size_at_every_scale_have_a_margin_for_fingers() -> None:
    made = [*corner_marks(full_plan(), SHEET), *cylinder_marks(full_plan(), SHEET), *station_marks(full_plan(), SHEET)]
    fixed = marked(made, "fixed")
    assert len(fixed) == 2 + 1 + 3
    for each in fixed:
        assert float(the(each, "reach").attrib["r"]) >= 3.0


def test_the_way_of_the_robot_goes_through_its_stations_in_their_order() -> None:
    way, *_ = station_marks(plan(poses=STATIONS), SHEET)
    assert way.attrib["class"] == "way"
    np.testing.assert_allclose(stroke(way), [paper(x, y) for x, y, _ in STATIONS])


def test_stations_have_their_letters_and_sweeps() -> None:
    found = replace(drawn(poses=STATIONS), sweeps=np.array([2, 5, 8]))
    _, *made = station_marks(Plan(feature_map=found), SHEET)
    assert [the(each, "label").text for each in made] == ["A", "B", "C"]
    assert [each.attrib["data-sweep"] for each in made] == ["2", "5", "8"]
    assert [each.attrib["id"] for each in made] == ["station-2", "station-5", "station-8"]
    for each, (x, y, _) in zip(made, STATIONS, strict=True):
        np.testing.assert_allclose(placed(group_of(each, "fixed"))[0], paper(x, y))


def test_corrected_stations_have_their_ellipses_and_trusted_ones_none() -> None:
    known = replace(drawn(poses=STATIONS), pose_covariances=np.tile(np.diag([4e-4, 1e-4, 1e-4]), (3, 1, 1)))
    _, *made = station_marks(Plan(feature_map=known), SHEET)
    radii = [float(the(each, "ellipse").attrib["rx"]) for each in made]
    assert radii == pytest.approx([SHEET.millimetres * 0.02 * np.sqrt(5.991)] * 3, rel=1e-2)
    _, *trusted = station_marks(plan(poses=STATIONS), SHEET)
    assert not [each for station in trusted for each in station.iter() if each.attrib.get("class") == "ellipse"]


def test_one_station_is_a_way_of_one_point() -> None:
    way, only = station_marks(plan(poses=[[1.0, 1.0, 0.0]]), SHEET)
    np.testing.assert_allclose(strokes(way), [[paper(1.0, 1.0)]])
    assert only.attrib["id"] == "station-0"


def test_of_a_thousand_stations_all_are_drawn_and_a_few_named() -> None:
    poses = np.column_stack([np.linspace(0, 4, 1000), np.ones(1000), np.zeros(1000)])
    way, *made = station_marks(plan(poses=poses), SHEET)
    assert len(stroke(way)) == len(made) == 1000
    assert sum(bool(the(each, "label").text) for each in made) == 9


def test_a_beam_goes_from_the_hub_to_what_it_detected() -> None:
    detection = observed_wall((0.0, 3.0), (1.0, 1.5), sweep=4)
    (made,) = detection_marks(replace(NOTHING, detections=(detection,)), SHEET)
    beam, face = strokes(made)
    np.testing.assert_allclose(beam, [paper(1.0, 1.5), paper(3.0, 1.5)])
    # A stroke of 2.4 mm along the face, whatever the scale.
    np.testing.assert_allclose(sorted(face.tolist()), paper(3.0, 1.5) + np.array([[0.0, -1.2], [0.0, 1.2]]))
    assert made.attrib["data-sweep"] == "4"


def test_beams_have_the_colour_of_what_they_detected() -> None:
    detections = (
        observed_wall((0.0, 3.0), (1.0, 1.0)),
        observed_circle((2.0, 1.0, 0.1), (1.0, 1.0)),
        observed_circle((0.0, 0.0, 0.0), (1.0, 1.0), degrees=(1.0, 0.0, 0.0)),
    )
    made = detection_marks(replace(NOTHING, detections=detections), SHEET)
    assert [each.attrib["class"] for each in made] == ["beam wall", "beam cylinder", "beam corner"]


def test_echoes_are_points_of_one_path() -> None:
    (made,) = echo_marks(replace(NOTHING, echoes_xy=np.array([[0.0, 0.0], [1.0, 0.5]])), SHEET)
    assert made.attrib == {"class": "dots", "d": "M10 130h0M50 110h0"}


@pytest.mark.parametrize(("count", "drawn_of_them"), [(20_000, 20_000), (20_001, 10_001), (50_000, 16_667)])
def test_of_very_many_echoes_some_are_drawn_from_first_to_last(count: int, drawn_of_them: int) -> None:
    echoes = np.column_stack([np.linspace(0.0, 4.0, count), np.zeros(count)])
    (made,) = echo_marks(replace(NOTHING, echoes_xy=echoes), SHEET)
    dots = made.attrib["d"].split("M")[1:]
    assert len(dots) == drawn_of_them
    assert dots[0] == "10 130h0"
    assert float(dots[-1].split()[0]) > 169.97


def test_the_true_room_is_drawn_as_it_is() -> None:
    walls, *circles = truth_marks(ROOM, SHEET)
    assert walls.attrib["class"] == "true"
    expected = [[paper(*point) for point in face] for face in ROOM.walls_xy]
    np.testing.assert_allclose(strokes(walls), expected)
    assert [each.attrib["class"] for each in circles] == ["true", "true"]
    found = [[float(each.attrib[name]) for name in ("cx", "cy", "r")] for each in circles]
    np.testing.assert_allclose(found, [[*paper(3.5, 0.6), 4.0], [*paper(1.0, 2.2), 2.0]])


def test_the_face_of_a_wall_is_drawn_apart_where_it_was_inferred() -> None:
    observed, inferred = marked(wall_marks(Plan(feature_map=gapped_map()), SHEET)[-1], "face")
    assert (observed.attrib["class"], inferred.attrib["class"]) == ("face", "face inferred")
    np.testing.assert_allclose(stroke(observed), [paper(4.5, 0.0), paper(5.5, 0.0)])
    np.testing.assert_allclose(stroke(inferred), [paper(5.5, 0.0), paper(6.0, 0.0)])


def test_gaps_are_drawn_between_their_ends_and_named_as_in_the_file() -> None:
    hidden, door, slit = gap_marks(Plan(feature_map=gapped_map()), SHEET)
    assert [each.attrib["id"] for each in (hidden, door, slit)] == ["unobserved-stretch-0", "opening-0", "opening-1"]
    np.testing.assert_allclose(stroke(the(hidden, "stretch")), [paper(4.0, 0.0), paper(4.5, 0.0)])
    np.testing.assert_allclose(stroke(the(door, "threshold")), [paper(1.0, 0.0), paper(1.9, 0.0)])
    assert [jamb[:, 0].tolist() for jamb in strokes(the(door, "jamb"))] == [[50.0, 50.0], [86.0, 86.0]]


def test_the_width_is_written_where_there_is_room_and_the_robot_drove_through() -> None:
    found = gapped_map()
    _, door, slit = gap_marks(Plan(feature_map=found), SHEET)
    assert the(door, "width").text == "0.90 m"
    assert marked(slit, "width") == []
    # At 1 : 100 an opening of 0.9 m is 9 mm wide, less than its label.
    small = Sheet(bounds_xy=np.array([[0.0, 0.0], [16.0, 12.0]]))
    assert marked(gap_marks(Plan(feature_map=found), small), "width") == []
    _, seen, _ = gap_marks(
        Plan(feature_map=replace(found, openings=(replace(found.openings[0], passed=False),) * 2)), SHEET
    )
    assert marked(seen, "width") == []

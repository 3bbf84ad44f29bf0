from dataclasses import replace

import numpy as np
import pytest

from echoplan.model import ClassProbabilities, Corner, CornerKind, Cylinder, FeatureMap, Wall
from echoplan.viewer.facts import (
    Facts,
    corner_facts,
    cylinder_facts,
    opening_facts,
    station_facts,
    unobserved_facts,
    wall_facts,
)
from echoplan.viewer.wording import SIGMA
from helpers.drawings import gapped_map
from helpers.maps import corner, cylinder, drawn, wall

WALL = Wall(
    normal_angle=np.pi / 2,
    offset=2.0,
    endpoints_xy=np.array([[1.0, 2.0], [4.5, 2.0]]),
    covariance=np.diag([np.radians(0.25) ** 2, 0.004**2]),
    class_probabilities=ClassProbabilities(wall=0.87, cylinder=0.12, corner=0.01),
    pings=412,
    stations=6,
)
CORNER = Corner(
    position_xy=np.array([-0.25, 3.1234]),
    kind=CornerKind.CONVEX,
    covariance=np.diag([0.002**2, 0.004**2]),
    pings=1,
    stations=1,
)
CYLINDER = Cylinder(
    center_xy=np.array([3.2, 1.0]),
    radius=0.1,
    covariance=np.diag([0.004**2, 0.002**2, 0.0015**2]),
    pings=30,
    stations=4,
)


def table(facts: Facts) -> dict[str, str]:
    """Facts by name; no name occurs twice."""
    assert len(dict(facts.items)) == len(facts.items)
    return dict(facts.items)


def of_wall(one: Wall) -> dict[str, str]:
    return table(wall_facts([one])[0])


def of_corner(one: Corner) -> dict[str, str]:
    return table(corner_facts([one])[0])


def of_cylinder(one: Cylinder) -> dict[str, str]:
    return table(cylinder_facts([one])[0])


def test_facts_name_what_they_describe() -> None:
    facts = Facts(title="wall 12", items=(("length", "1.000 m"), ("stations", "2")))
    assert facts.kind == "wall"
    assert facts.key == "wall-12"
    assert facts.text == "wall 12\nlength: 1.000 m\nstations: 2"


def test_nothing_found_has_no_facts() -> None:
    assert wall_facts([]) == corner_facts([]) == cylinder_facts([]) == []
    assert station_facts(FeatureMap(method="none")) == []


def test_features_are_numbered_from_nought_each_kind_for_itself() -> None:
    assert [each.title for each in wall_facts([WALL, WALL])] == ["wall 0", "wall 1"]
    assert [each.key for each in corner_facts([CORNER])] == ["corner-0"]
    assert [each.key for each in cylinder_facts([CYLINDER, CYLINDER])] == ["cylinder-0", "cylinder-1"]


def test_a_wall_is_described_from_end_to_end() -> None:
    facts = of_wall(WALL)
    assert facts["from"] == "(1.000, 2.000) m"
    assert facts["to"] == "(4.500, 2.000) m"
    assert facts["length"] == "3.500 m"


def test_the_line_of_a_wall_is_described_with_its_deviations() -> None:
    facts = of_wall(WALL)
    assert facts["normal"] == f"90.0°, {SIGMA} 0.25°"
    assert facts["offset"] == f"2.000 m, {SIGMA} 4.0 mm"


def test_the_uncertainty_of_a_wall_is_described_across_its_middle() -> None:
    # The middle is 2.75 m along the line from the foot of the origin, where 0.25 degrees are 12 mm.
    assert of_wall(WALL)[f"{SIGMA} across, in its middle"] == "12.6 mm"


def test_a_wall_is_described_with_its_detections_and_its_class_probability() -> None:
    facts = of_wall(WALL)
    assert facts["class"] == "wall 87 %, corner 1 %, cylinder 12 %"
    assert facts["detected by"] == "412 pings from 6 stations"


def test_one_ping_from_one_station_is_singular() -> None:
    assert of_corner(CORNER)["detected by"] == "1 ping from 1 station"


@pytest.mark.parametrize("facts", [wall_facts([wall([0, 0], [1, 0])]), corner_facts([corner([0.0, 0.0])])])
def test_what_was_only_inferred_was_detected_by_no_ping(facts: list[Facts]) -> None:
    assert table(facts[0])["detected by"] == "no ping of its own"


def test_a_corner_is_described_with_its_position_and_kind() -> None:
    assert of_corner(CORNER)["at"] == "(-0.250, 3.123) m"
    assert of_corner(CORNER)["kind"] == "convex"
    assert of_corner(replace(CORNER, kind=CornerKind.CONCAVE))["kind"] == "concave"


def test_the_deviations_of_a_corner_come_in_the_order_of_the_axes() -> None:
    assert of_corner(CORNER)[f"{SIGMA} in x, y"] == "2.0 mm, 4.0 mm"


def test_the_ellipse_of_a_corner_is_described_by_its_half_axes_the_long_one_first() -> None:
    text = of_corner(CORNER)["95 % ellipse"]
    assert text.startswith("± 9.8 by 4.9 mm, long axis at ")
    assert text.endswith(("at 90°", "at -90°"))


@pytest.mark.parametrize(("together", "direction"), [(9e-6, "45°"), (-9e-6, "-45°"), (0.0, "0°")])
def test_the_direction_of_the_long_axis_is_given_within_half_a_turn(together: float, direction: str) -> None:
    wide = 1e-5 if together else 2e-5
    facts = of_corner(replace(CORNER, covariance=np.array([[wide, together], [together, 1e-5]])))
    assert facts["95 % ellipse"].endswith(f"long axis at {direction}")


def test_a_cylinder_is_described_with_its_radius_and_its_uncertainty() -> None:
    facts = of_cylinder(CYLINDER)
    assert facts["centre"] == "(3.200, 1.000) m"
    assert facts["radius"] == f"0.100 m, {SIGMA} 1.5 mm"
    assert facts[f"{SIGMA} in x, y"] == "4.0 mm, 2.0 mm"
    assert facts["95 % ellipse"] == "± 9.8 by 4.9 mm, long axis at 0°"
    assert facts["detected by"] == "30 pings from 4 stations"


def test_what_is_sure_of_itself_has_an_ellipse_of_no_size() -> None:
    assert of_corner(corner([0.0, 0.0], sigma=0.0))["95 % ellipse"].startswith("± 0.0 by 0.0 mm")
    assert of_cylinder(cylinder([0.0, 0.0], 0.1, sigma=0.0))["radius"] == f"0.100 m, {SIGMA} 0.0 mm"


def test_a_station_is_described_by_the_number_of_its_sweep_its_letter_and_its_pose() -> None:
    found = replace(drawn(poses=[[1.0, -2.0, np.pi / 3], [0.0, 0.0, 0.0]]), sweeps=np.array([4, 9]))
    first, second = station_facts(found)
    assert first.title == "station 4"
    assert table(first) == {"label": "A", "at": "(1.000, -2.000) m", "heading": "60.0°"}
    assert (second.key, table(second)["label"]) == ("station-9", "B")


@pytest.mark.parametrize(("yaw", "heading"), [(7.0, "41.1°"), (-4.0, "130.8°"), (2 * np.pi, "0.0°")])
def test_headings_after_whole_turns_are_given_within_one(yaw: float, heading: str) -> None:
    assert table(station_facts(drawn(poses=[[0.0, 0.0, yaw]]))[0])["heading"] == heading


def test_stations_that_would_crowd_the_drawing_have_no_label_but_all_else() -> None:
    facts = station_facts(drawn(poses=np.zeros((1000, 3))))
    assert len({each.key for each in facts}) == 1000
    assert table(facts[1])["label"] == "none"
    assert table(facts[39])["label"] == "39"


def test_a_corrected_station_is_described_with_its_uncertainty() -> None:
    covariance = np.diag([4e-6, 1e-6, np.radians(0.25) ** 2])
    (only,) = station_facts(replace(drawn(poses=[[1.0, -2.0, 0.0]]), pose_covariances=covariance[None]))
    assert table(only)[f"{SIGMA} in x, y"] == "2.0 mm, 1.0 mm"
    assert table(only)[f"{SIGMA} of the heading"] == "0.25°"


def test_an_opening_has_its_width_with_the_95_percent_interval_and_its_evidence() -> None:
    door, slit = opening_facts(gapped_map().openings)
    assert door.kind == "opening"
    assert table(door) == {
        "from": "(1.000, 0.000) m",
        "to": "(1.900, 0.000) m",
        "beside": "wall 0 and wall 1",
        "width": "0.900 m ± 0.039 m (95 %)",
        "evidence": "driven through",
    }
    assert table(slit)["evidence"] == "seen through"


def test_an_unobserved_stretch_has_its_ends_and_the_walls_beside_it() -> None:
    (hidden,) = unobserved_facts(gapped_map().unobserved)
    assert (hidden.key, hidden.kind) == ("unobserved-stretch-0", "unobserved")
    assert table(hidden)["to"] == "(4.500, 0.000) m"
    assert table(hidden)["beside"] == "wall 2 and wall 3"


def test_a_wall_lists_what_is_known_of_its_ends_and_nothing_else() -> None:
    facts = of_wall(gapped_map().walls[-1])
    assert facts[f"{SIGMA} of its start"] == "10.0 mm"
    assert facts["inferred at its end"] == "0.500 m"
    assert {f"{SIGMA} of its end", "inferred at its start"}.isdisjoint(facts)

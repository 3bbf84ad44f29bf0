import numpy as np
import pytest

from echoplan.evaluation import PAPER_ANGLES, PAPER_DISTANCES, evaluate, table5
from echoplan.model import FeatureMap, Truth, Wall

POINTS = np.array([[0, 0], [3.1, 0], [3.1, 1.2], [4.4, 1.2], [4.4, 2.9], [1.7, 2.9], [1.7, 2.1], [0, 2.1]])
TRUTH = Truth(walls_xy=np.stack([POINTS, np.roll(POINTS, -1, axis=0)], axis=1), walls_detected_by=np.full(8, 3))


def shifted_map(shift: float, *, walls: int = 8) -> FeatureMap:
    """The first walls of the room, each moved outward along its normal."""
    found = []
    for start, end in TRUTH.walls_xy[:walls]:
        tangent = (end - start) / np.hypot(*(end - start))
        normal = np.array([-tangent[1], tangent[0]])
        ends = np.array([start, end]) + shift * normal
        angle = float(np.arctan2(normal[1], normal[0]))
        found.append(
            Wall(normal_angle=angle, offset=float(ends[0] @ normal), endpoints_xy=ends, covariance=1e-6 * np.eye(2))
        )
    return FeatureMap(method="m", walls=tuple(found))


def test_the_figures_of_the_paper_have_the_mean_and_maximum_that_it_prints() -> None:
    assert 1000 * np.mean(PAPER_DISTANCES) == pytest.approx(5.2, abs=0.05)
    assert 1000 * max(PAPER_DISTANCES) == pytest.approx(12.8)
    assert np.degrees(np.mean(PAPER_ANGLES)) == pytest.approx(1.25)


def test_our_deviations_are_beside_those_of_the_paper_wall_by_wall() -> None:
    table = table5({"ours": evaluate(shifted_map(0.004), TRUTH)})
    assert table.columns == ("wall", "paper (mm)", "ours (mm)", "paper (°)", "ours (°)")
    assert table.rows[0] == ("1", "12.8", "4.0", "3.00", "0.00")
    assert table.rows[8] == ("mean", "5.2", "4.0", "1.25", "0.00")
    assert table.rows[9] == ("worst", "12.8", "4.0", "3.00", "0.00")


def test_a_wall_that_is_missing_has_a_dash_and_no_part_in_the_mean() -> None:
    table = table5({"ours": evaluate(shifted_map(0.002, walls=7), TRUTH)})
    assert table.rows[7][2] == "-"
    assert table.rows[8][2] == "2.0"


def test_an_empty_map_has_dashes_only() -> None:
    table = table5({"ours": evaluate(FeatureMap(method="m"), TRUTH)})
    assert {row[2] for row in table.rows} == {"-"}

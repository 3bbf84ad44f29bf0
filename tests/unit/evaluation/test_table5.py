"""Table 5 of the paper, put in and taken out again: a room of eight walls, each off by what the paper reports."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.evaluation import Evaluation, evaluate, pool, wall_table
from echoplan.model import FeatureClass, FeatureMap, Truth
from helpers import maps

DISTANCES_MM = (12.8, 6.7, 1.0, 7.8, 0.5, 1.8, 3.8, 7.0)
ANGLES_DEG = (3.0, 2.0, 0.0, 3.0, 0.0, 0.0, 1.0, 1.0)

# A room of eight walls, no two of them alike.
POINTS = np.array([[0, 0], [3.1, 0], [3.1, 1.2], [4.4, 1.2], [4.4, 2.9], [1.7, 2.9], [1.7, 2.1], [0, 2.1]])
TRUTH = Truth(walls_xy=np.stack([POINTS, np.roll(POINTS, -1, axis=0)], axis=1), walls_detected_by=np.arange(2, 10))


def displaced(ends_xy: FloatArray, *, distance: float, angle: float) -> FloatArray:
    """Move a wall sideways and turn it about its middle."""
    middle, half = ends_xy.mean(axis=0), (ends_xy[1] - ends_xy[0]) / 2
    normal = np.array([-half[1], half[0]]) / np.hypot(*half)
    turned = np.cos(angle) * half + np.sin(angle) * np.array([-half[1], half[0]])
    moved: FloatArray = middle + distance * normal + np.array([-turned, turned])
    return moved


def reported_map(*, sign: float = 1.0) -> FeatureMap:
    """A map whose walls are off as the paper's are, listed in another order than the truth."""
    walls = [
        maps.wall(*displaced(ends, distance=sign * distance / 1000, angle=-sign * np.radians(angle)))
        for ends, distance, angle in zip(TRUTH.walls_xy, DISTANCES_MM, ANGLES_DEG, strict=True)
    ]
    return maps.drawn(*walls[3:], *walls[:3])


@pytest.fixture(params=[1.0, -1.0], ids=["outward", "inward"])
def evaluation(request: pytest.FixtureRequest) -> Evaluation:
    return evaluate(reported_map(sign=request.param), TRUTH)


def test_the_table_shows_the_deviations_in_the_order_of_the_true_walls(evaluation: Evaluation) -> None:
    rows = wall_table(evaluation.matches.walls).rows
    assert [row[0] for row in rows] == ["1", "2", "3", "4", "5", "6", "7", "8"]
    assert [float(row[1]) for row in rows] == list(DISTANCES_MM)
    assert [float(row[2]) for row in rows] == list(ANGLES_DEG)
    assert [row[3] for row in rows] == ["2", "3", "4", "5", "6", "7", "8", "9"]


def test_the_paper_s_summary_of_the_table_comes_out(evaluation: Evaluation) -> None:
    # "the distance error ... is 1.2 cm and the angle error is 3 degrees": the greatest of each.
    summary = pool([evaluation], rng=np.random.default_rng(0))
    distance = summary.classes[FeatureClass.WALL].distance
    assert distance.maximum == pytest.approx(0.0128)
    assert distance.mean.value == pytest.approx(np.mean(DISTANCES_MM) / 1000)
    assert np.degrees(summary.wall_angle.maximum) == pytest.approx(3.0)
    assert np.degrees(summary.wall_angle.median.value) == pytest.approx(1.0)


def test_all_eight_walls_are_found_once(evaluation: Evaluation) -> None:
    tally = evaluation.matches.walls.tally
    assert (tally.wanted, tally.found, tally.right, tally.duplicate, tally.spurious) == (8, 8, 8, 0, 0)


def test_a_wall_turned_by_three_degrees_is_inconsistent_with_a_covariance_of_one(evaluation: Evaluation) -> None:
    # Its angle alone is off by 5.2 sigmas of 0.01 rad; walls 3, 5 and 6 are not turned at all.
    nees = dict(
        zip(
            (match.truth for match in evaluation.matches.walls.right),
            evaluation.consistency[FeatureClass.WALL].nees,
            strict=True,
        )
    )
    assert nees[0] > 27
    assert [nees[number] for number in (2, 4, 5)] == pytest.approx([0.01, 0.0025, 0.0324])

"""A wall that ends at an edge returns weak echoes there, and sensors past the edge detect it by diffraction."""

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import walk_of
from echoplan.arrays import FloatArray
from echoplan.evaluation import evaluate
from echoplan.evaluation.consistency import wall_error
from echoplan.geometry import directions
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.optimisation.attenuation import shadowed
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.range_factors import Association, Features, associate, range_jacobian
from echoplan.methods import map_sweeps
from echoplan.model import Polyline, Route, World
from echoplan.preprocessing.measurements import Measurements
from echoplan.simulation import Simulation
from echoplan.sources import find_rig
from helpers.expectations import SONAR, cylinder, listening, wall

# The west and the south side of a box north-east of (1, 1), as detected from the south-west.
WEST, SOUTH = wall(0.0, 1.0), wall(np.pi / 2, 1.0)
DETECTED = np.array([[1.05, 1.8], [-1.7, -1.1]])
NONE = [-np.inf, np.inf]


def test_two_sides_of_a_box_end_where_they_meet() -> None:
    found = edges_of(np.array([WEST, SOUTH, cylinder(1.0, 1.0, 0.1)]), np.vstack([DETECTED, [0.0, 0.0]]))
    assert found[:, :, 0] == pytest.approx(np.array([[1.0, np.inf], [-np.inf, -1.0], NONE]))
    assert found[:2, :, 5].tolist() == [[1.0, -1.0], [-1.0, 0.0]]


@pytest.mark.parametrize(
    ("rows", "detected"),
    [
        ([WEST, SOUTH], [[0.1, 0.95], [-0.95, -0.2]]),
        ([WEST, SOUTH], [[0.5, 1.8], [-1.7, -1.1]]),
        ([WEST, SOUTH], [[1.6, 1.8], [-1.7, -1.1]]),
        ([WEST, wall(0.2, 1.0)], [[1.05, 1.8], [-1.7, -1.1]]),
    ],
    ids=["a corner of a room", "detected past it", "not detected up to it", "hardly turned"],
)
def test_other_pairs_of_walls_have_no_edge(rows: list[FloatArray], detected: list[list[float]]) -> None:
    assert edges_of(np.array(rows), np.array(detected))[:, :, 0].tolist() == [NONE, NONE]


def test_a_wall_ends_at_the_nearest_of_its_edges() -> None:
    nearer = wall(np.pi / 2, 1.03)
    found = edges_of(np.array([WEST, SOUTH, nearer]), np.vstack([DETECTED, DETECTED[1]]))
    assert found[0, 0].tolist()[::5] == pytest.approx([1.03, 2.0])


def test_the_jacobian_of_edges_equals_finite_differences() -> None:
    rows, step = np.array([wall(0.1, 1.0), wall(1.4, 1.2)]), 1e-6
    detected = np.array([[1.1, 1.8], [-1.7, -0.9]])
    for place, side in ((0, 0), (1, 1)):
        end = edges_of(rows, detected)[place, side]
        assert np.isfinite(end[0])
        for column, (number, parameter) in enumerate([(place, 1), (place, 2), (1 - place, 1), (1 - place, 2)]):
            ahead, behind = rows.copy(), rows.copy()
            ahead[number, parameter] += step
            behind[number, parameter] -= step
            moved = edges_of(ahead, detected)[place, side, 0] - edges_of(behind, detected)[place, side, 0]
            assert end[1 + column] == pytest.approx(moved / (2 * step), abs=1e-6)


def box(rows: FloatArray, stations: int) -> Features:
    return Features(rows, DETECTED, np.zeros((2, stations)), np.zeros((2, stations)), edges_of(rows, DETECTED))


def beside(place: float) -> Measurements:
    """Return pings of a hub half a metre before the west side, at a place along it, without readings."""
    return listening([(0.45, place)], step=np.radians(4.0))


def expected(pings: Measurements, rows: FloatArray) -> tuple[Association, FloatArray]:
    """Return the associations with the west side, and the predicted readings."""
    guess = pings._replace(readings=np.full(len(pings.readings), 0.55))
    matched = associate(guess, SONAR.tabulated(), box(rows, 1), 0.09)
    return matched, 0.55 - matched.residuals


def test_the_jacobian_of_readings_near_an_edge_equals_finite_differences() -> None:
    rows, pings, step = np.array([wall(0.02, 1.0), wall(np.pi / 2 + 0.05, 1.01)]), beside(1.06), 1e-6
    matched, _ = expected(pings, rows)
    explained = np.flatnonzero((matched.owners == 0) & (matched.excesses > 1.0))
    walk = (SONAR.range_offset, SONAR.walk_gain, SONAR.reference_walk, SONAR.walk_exponent)
    jacobian, neighbours = range_jacobian(pings, SONAR.tabulated(), box(rows, 1), matched, explained, walk)
    ended = neighbours == 1
    assert ended.sum() > 10
    # Echoes around the edge do not come from the perpendicular exactly, so the derivatives are not exact there.
    seen = explained[ended & (directions_along(pings, rows)[explained] > 1.0)]
    kept = np.isin(explained, seen)
    assert kept.sum() > 5
    for column, (number, parameter) in {0: (0, 1), 1: (0, 2), 3: (1, 1), 4: (1, 2)}.items():
        ahead, behind = rows.copy(), rows.copy()
        ahead[number, parameter] += step
        behind[number, parameter] -= step
        change = (expected(pings, ahead)[1] - expected(pings, behind)[1])[seen] / (2 * step)
        assert jacobian[kept, column] == pytest.approx(change, rel=0.02, abs=0.02)
    moved = pings._replace(y=pings.y + step)
    change = (expected(moved, rows)[1] - expected(pings, rows)[1])[seen] / step
    assert jacobian[kept, 15] == pytest.approx(change, rel=0.02, abs=0.02)


def directions_along(pings: Measurements, rows: FloatArray) -> FloatArray:
    """Return the places of the feet along the west side, shifted so that its end is at 1 [m]."""
    along = directions(rows[0, 1] + np.pi / 2)
    end = edges_of(rows, DETECTED)[0, 0, 0]
    places: FloatArray = pings.x * along[0] + pings.y * along[1] - end + 1.0
    return places


def test_a_wall_is_attenuated_by_six_decibels_at_its_end() -> None:
    # At the end half of the amplitude remains (ITU-R P.526: 6.0 dB at 0, 0 dB below -0.78).
    whole = Features(WEST[None], DETECTED[:1], np.zeros((1, 1)), np.zeros((1, 1)), edges_of(WEST[None], DETECTED[:1]))
    pings = beside(1.0)._replace(readings=np.full(90, 0.55))
    alone = associate(pings, SONAR.tabulated(), whole, 0.09)
    ended = associate(pings, SONAR.tabulated(), box(np.array([WEST, SOUTH]), 1), 0.09)
    ahead = int(np.argmax(pings.ux))
    assert alone.excesses[ahead] - ended.excesses[ahead] == pytest.approx(6.0, abs=0.1)
    assert walk_of(SONAR.tabulated(), ended.excesses[ahead]) > walk_of(SONAR.tabulated(), alone.excesses[ahead])


def test_a_station_past_an_edge_does_not_constrain_the_wall() -> None:
    features = box(np.array([WEST, SOUTH]), 2)
    pings = listening([(0.45, 1.1), (0.45, 0.95)])
    assert np.isinf(
        shadowed(pings, SONAR.tabulated(), features, np.zeros(len(features.reflectors), dtype=bool)).attenuations[0]
    ).tolist() == [False, True]


@pytest.mark.parametrize("inside", [0.015, 0.03, 0.045])
def test_a_wall_detected_once_near_its_end_has_the_right_direction(inside: float) -> None:
    # The simulator uses the field behind a wedge, not the knife-edge model.
    room = Polyline(points_xy=np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]), closed=True)
    sides = Polyline(points_xy=np.array([[1.6, 1.2], [2.4, 1.2], [2.4, 1.8], [1.6, 1.8]]), closed=True)
    near = [1.6 + inside, 0.62, 0.3]
    others = [[0.8, 1.5, 1.0], [0.6, 1.35, 2.0], [0.9, 1.65, 0.0], [3.2, 2.2, 1.5], [0.7, 2.6, 0.5], [0.7, 0.5, 0.2]]
    simulation = Simulation(
        world=World(name="a box", polylines=(room, sides)),
        rig=find_rig("rotary-array"),
        route=Route(map_from_base=np.array([near, *others, [3.4, 0.5, 0.1]])),
    )
    found = map_sweeps(JointMapper(simulation.rig, JointSettings()), tuple(simulation))
    right = {each.truth: each.estimate for each in evaluate(found, simulation.truth).matches.walls.right}
    off = wall_error(found.walls[right[4]], simulation.truth.walls_xy[4])[0]
    assert abs(np.degrees(off)) < 0.7

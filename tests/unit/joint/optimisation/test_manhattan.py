from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.evaluation import evaluate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import PingScores
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.optimisation.layout import Layout
from echoplan.joint.optimisation.manhattan import (
    ManhattanPrior,
    ManhattanSettings,
    estimate_right_angles,
    main_direction,
    manhattan_factor,
    manhattan_residual,
    rest_on_few_stations,
    roughly_square,
)
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import Polyline, Route, World
from echoplan.simulation import Simulation
from echoplan.sources import find_rig
from helpers.constants import settings_with

SETTINGS = ManhattanSettings()


def faces(*degrees: float, llr: float = 100.0) -> list[Hypothesis]:
    nothing = PingScores(*(np.zeros(0, dtype=kind) for kind in (np.int64, float, float, bool, bool, float)))
    return [
        Hypothesis(
            reflector=np.array([Kind.WALL, np.radians(each), 1.0, 0.0]),
            ping_scores=nothing,
            llr_by_station=np.zeros(1),
            llr=llr,
        )
        for each in degrees
    ]


def test_walls_at_right_angles_have_a_common_direction() -> None:
    direction = main_direction(faces(10, 100, -80, 190), SETTINGS)
    assert direction is not None
    assert manhattan_residual(np.radians([10.0]), direction) == pytest.approx([0.0], abs=1e-12)


def test_the_common_direction_is_weighted_by_the_ratios() -> None:
    even = main_direction(faces(0, 90, 184, -86), SETTINGS)
    strong = main_direction([*faces(0, 90), *faces(184, -86, llr=900.0)], SETTINGS)
    assert even is not None
    assert strong is not None
    assert np.degrees(even) == pytest.approx(2.0, abs=0.1)
    assert np.degrees(strong) > 3.0


def test_oblique_walls_have_no_common_direction() -> None:
    assert main_direction(faces(0, 30, 75, 110), SETTINGS) is None


def test_too_few_walls_have_no_common_direction() -> None:
    assert main_direction(faces(0, 90, 180), SETTINGS) is None
    assert main_direction([], SETTINGS) is None


def test_only_walls_determine_the_common_direction() -> None:
    post = [replace(each, reflector=np.array([Kind.CYLINDER, 1.0, 1.0, 0.1])) for each in faces(0, 0, 0, 0)]
    assert main_direction([*faces(0, 90), *post], SETTINGS) is None


@pytest.mark.parametrize(("turn", "along_axes"), [(8.0, True), (-95.0, True), (20.0, False)])
def test_walls_near_the_axes_are_initially_aligned_with_them(turn: float, *, along_axes: bool) -> None:
    applied = roughly_square(
        [*faces(turn, turn + 90, turn + 180, turn - 90), *faces(turn + 40, llr=1.0)],
        SETTINGS,
        may_lie_along_axes=True,
    )
    assert applied is not None
    assert applied.members.tolist() == [True] * 4 + [False]
    assert applied.along_axes == along_axes


@pytest.mark.parametrize(("measured", "may"), [(0.1, True), (0.9, False)])
def test_walls_are_not_aligned_with_the_axes_with_a_low_prior_or_enough_stations(measured: float, *, may: bool) -> None:
    settings = ManhattanSettings(prior_axis_aligned=measured)
    applied = roughly_square(faces(8, 98, 188, -82), settings, may_lie_along_axes=may)
    assert applied is not None
    assert not applied.along_axes


@pytest.mark.parametrize(("detected", "few"), [((1, 2, 2, 5), True), ((1, 3, 3, 5), False), ((2, 2, 3, 3), False)])
def test_walls_rest_on_few_stations_if_most_have_one_or_two(detected: tuple[int, ...], *, few: bool) -> None:
    walls = [
        replace(each, llr_by_station=np.repeat([5.0, 0.5], [n, 5 - n]))
        for each, n in zip(faces(*detected), detected, strict=True)
    ]
    post = replace(walls[0], reflector=np.array([Kind.CYLINDER, 1.0, 1.0, 0.1]))
    assert rest_on_few_stations([*walls, post, post, post], 1.0) == few


@given(angle=st.floats(-10, 10), direction=st.floats(-10, 10), turns=st.integers(-3, 3))
def test_the_residual_is_periodic_in_right_angles(angle: float, direction: float, turns: int) -> None:
    off = manhattan_residual(np.array([angle]), direction)
    assert np.abs(off) <= np.pi / 4 + 1e-9
    again = manhattan_residual(np.array([angle + turns * np.pi / 2]), direction)
    assert np.abs(np.sin(2 * (off - again))) < 1e-6


def estimated_prior(
    degrees: list[float],
    sigmas: list[float],
    *,
    together: float = 0.0,
    stations: list[int] | None = None,
    by_hand: bool = False,
) -> ManhattanPrior | None:
    """Return the Manhattan prior of walls of given directions and sigmas [deg], and a cylinder.

    ``together`` is a common sigma [deg]; walls of one station have another common sigma of 10 degrees.
    """
    rows = [[Kind.WALL, np.radians(each), 1.0, 0.0] for each in degrees]
    layout = Layout(kinds=np.array([Kind.CYLINDER, *[Kind.WALL] * len(degrees)]))
    covariance = np.eye(layout.size)
    places = layout.starts[1:]
    of = np.arange(len(degrees)) if stations is None else np.array(stations)
    turned = 0.0 if stations is None else np.radians(10.0) ** 2
    covariance[np.ix_(places, places)] = np.diag(np.radians(sigmas) ** 2) + np.radians(together) ** 2
    covariance[np.ix_(places, places)] += turned * (of[:, None] == of)
    reflectors = np.array([[Kind.CYLINDER, 1.0, 1.0, 0.1], *rows])
    return estimate_right_angles(reflectors, layout, covariance, SETTINGS, by_hand=by_hand)


@pytest.mark.parametrize("together", [0.0, 3.0])
def test_an_uncertain_wall_joins_the_right_angles_of_the_others(together: float) -> None:
    found = estimated_prior([10.0, 100.01, -80.02, 190.0, 101.2], [0.02, 0.02, 0.02, 0.02, 1.0], together=together)
    assert found is not None
    assert found.members.tolist() == [False, True, True, True, True, True]
    assert np.degrees(found.sigma) < 0.1


def test_a_wall_known_to_be_oblique_is_no_member() -> None:
    found = estimated_prior([10.0, 100.01, -80.02, 190.0, 104.0], [0.02, 0.02, 0.02, 0.02, 0.9])
    assert found is not None
    assert found.members.tolist() == [False, True, True, True, True, False]


def test_walls_with_correlated_directions_are_used_jointly() -> None:
    degrees, sigmas = [3.0, 93.1, -84.0, 6.2, 178.1, 88.0], [0.5] * 6
    found = estimated_prior(degrees, sigmas, stations=[0, 0, 1, 1, 2, 2])
    assert found is not None
    assert found.members.sum() == 6
    assert estimated_prior(degrees[:4], sigmas[:4], stations=[0, 0, 1, 1]) is not None
    assert estimated_prior(degrees[:4], sigmas[:4], stations=[0, 1, 2, 3]) is None


def test_an_oblique_wall_among_others_of_its_station_is_no_member() -> None:
    found = estimated_prior([3.0, 93.1, 189.5, -84.0, 6.2, 178.1, 88.0], [0.5] * 7, stations=[0, 0, 0, 1, 1, 2, 2])
    assert found is not None
    assert found.members.tolist() == [False, True, True, False, True, True, True, True]


@pytest.mark.parametrize(
    ("turn", "together", "expected"),
    [(0.7, 1.3, True), (6.0, 2.0, False), (0.7, 0.1, False), (0.0, 25.0, False), (40.0, 2.0, False)],
    ids=["about the axes", "too far off", "known to be off", "known to nothing", "askew"],
)
@pytest.mark.parametrize("quarter", [0.0, 90.0, -180.0])
def test_walls_are_aligned_with_the_axes_of_waypoints_if_likely(
    turn: float, together: float, quarter: float, *, expected: bool
) -> None:
    degrees = [turn + quarter + each for each in (0.0, 90.02, -90.01, 180.0, 89.98)]
    found, by_wheels = (estimated_prior(degrees, [0.05] * 5, together=together, by_hand=each) for each in (True, False))
    assert found is not None
    assert by_wheels is not None
    assert found.along_axes == expected
    assert not by_wheels.along_axes


@pytest.mark.parametrize("along_axes", [True, False])
@pytest.mark.parametrize("sigma", [0.2, 1.0])
@pytest.mark.parametrize("askew", [0.0, 3.0])
def test_an_applied_manhattan_prior_is_removed_before_it_is_estimated_again(
    sigma: float, askew: float, *, along_axes: bool
) -> None:
    # Five walls of three stations, to which a Manhattan prior was applied; the last is oblique.
    angles = np.radians([3.0, 93.1 + askew, -84.0, 6.2, 178.1, 40.0])
    layout = Layout(kinds=np.array([Kind.WALL] * 6))
    stations = np.array([0, 0, 1, 1, 2, 2])
    covariance, places = np.eye(layout.size), np.ix_(layout.starts, layout.starts)
    covariance[places] = np.radians(0.5) ** 2 * np.eye(6) + np.radians(10.0) ** 2 * (stations[:, None] == stations)
    applied = ManhattanPrior(np.arange(6) < 5, np.radians(sigma), along_axes)
    rows = manhattan_factor(applied, angles, layout.starts)
    jacobian = np.zeros((5, layout.size))
    np.add.at(jacobian, (np.arange(5)[:, None], rows.columns), rows.jacobian)
    drawn: FloatArray = np.linalg.inv(
        np.linalg.inv(covariance) + jacobian.T @ (rows.weights[:, None] * jacobian)
    ).astype(np.float64)
    moved = angles + (drawn @ jacobian.T @ (rows.weights * rows.residuals))[layout.starts]

    def walls(angles: FloatArray) -> FloatArray:
        return np.column_stack([np.full(6, Kind.WALL), angles, np.ones(6), np.zeros(6)])

    free = estimate_right_angles(walls(angles), layout, covariance, SETTINGS, by_hand=True)
    again = estimate_right_angles(walls(moved), layout, drawn, SETTINGS, applied, by_hand=True)
    assert (free is None) == (again is None)
    if free is not None and again is not None:
        assert again.members.tolist() == free.members.tolist()
        assert again.along_axes == free.along_axes
        assert again.sigma == pytest.approx(free.sigma, rel=1e-4)
    assert (free is not None) == (askew == 0.0)


def test_a_manhattan_prior_that_exceeds_the_information_gives_no_estimate() -> None:
    angles = np.radians([0.0, 91.0, 180.0, 271.0])
    layout = Layout(kinds=np.array([Kind.WALL] * 4))
    covariance = np.radians(1.0) ** 2 * np.eye(layout.size)
    walls = np.column_stack([np.full(4, Kind.WALL), angles, np.ones(4), np.zeros(4)])
    # Without the prior the variances would be negative, so there is no estimate.
    applied = ManhattanPrior(np.ones(4, dtype=bool), np.radians(0.2))
    square = estimate_right_angles(walls, layout, covariance, SETTINGS, applied, by_hand=True)
    assert square is None


def test_the_manhattan_sigma_is_estimated_from_well_known_walls() -> None:
    off = np.random.default_rng(4).normal(0.0, 0.6, 12)
    found = estimated_prior([*(90.0 * np.arange(12) + off)], [0.02] * 12)
    assert found is not None
    assert np.degrees(found.sigma) == pytest.approx(off.std(ddof=1), rel=0.15)


def test_one_well_known_wall_does_not_bias_the_manhattan_sigma() -> None:
    # The residual of the wall that determines the common direction is nearly zero.
    rng, sigmas = np.random.default_rng(7), [0.02, 0.6, 0.6, 0.6, 0.6]
    off = rng.normal(0.0, np.hypot(0.2, sigmas), (60, 5))
    found = [estimated_prior([*(90.0 * np.arange(5) + row)], sigmas) for row in off]
    assert np.median([np.degrees(each.sigma) for each in found if each]) == pytest.approx(0.2, abs=0.05)


@pytest.mark.parametrize(
    ("degrees", "sigma"),
    [([0.0, 31.0, 75.0, 110.0, 163.0], 0.05), ([0.0, 90.0], 0.02), ([0.0, 86.0, 184.0, 275.0], 3.0), ([7.0], 0.01)],
    ids=["oblique", "any two", "hardly known", "one"],
)
def test_without_evidence_nothing_is_square(degrees: list[float], sigma: float) -> None:
    assert estimated_prior(degrees, [sigma] * len(degrees)) is None


def test_manhattan_factors_do_not_rotate_the_common_direction() -> None:
    angles, members = np.radians([10.0, 5.0, 100.4, -80.6]), np.array([True, False, True, True])
    rows = manhattan_factor(ManhattanPrior(members, np.radians(0.2)), angles, np.array([0, 2, 4, 6]))
    assert rows.jacobian.sum(axis=1) == pytest.approx(0.0, abs=1e-12)
    assert rows.columns.tolist() == [[0, 4, 6]] * 3
    assert np.degrees(rows.residuals) == pytest.approx([-1 / 15, -7 / 15, 8 / 15])
    step = -np.radians([0.0, 0.4, -0.6])
    assert rows.jacobian @ step == pytest.approx(rows.residuals)


def test_manhattan_factors_along_the_axes_are_absolute() -> None:
    angles, members = np.radians([1.0, 5.0, 90.4, -80.6]), np.array([True, False, True, True])
    rows = manhattan_factor(ManhattanPrior(members, np.radians(0.2), along_axes=True), angles, np.array([0, 2, 4, 6]))
    assert rows.columns.tolist() == [[0], [4], [6]]
    assert np.degrees(rows.residuals) == pytest.approx([-1.0, -0.4, -9.4])
    assert rows.jacobian == pytest.approx(1.0)
    assert rows.weights == pytest.approx(np.radians(0.2) ** -2.0)


def side_of_a_box(turn: float, settings: ManhattanSettings) -> float:
    """Return the angular error of a side of a box that one station detected; the box is turned in its room [deg]."""
    room = Polyline(points_xy=np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]), closed=True)
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    corners = np.array([[-0.3, -0.3], [0.3, -0.3], [0.3, 0.3], [-0.3, 0.3]]) @ [[cosine, sine], [-sine, cosine]]
    stations = [[0.8, 0.7, 0.0], [1.0, 1.62, 0.3], [0.8, 2.4, 0.7], [3.4, 2.5, 1.9], [3.3, 0.6, 2.5]]
    simulation = Simulation(
        world=World(name="a box", polylines=(room, Polyline(points_xy=corners + np.array([2.4, 1.6]), closed=True))),
        rig=find_rig("rotary-array"),
        route=Route(map_from_base=np.array(stations)),
        seed=3,
    )
    mapper = JointMapper(simulation.rig, JointSettings(poses=PoseMode.TRUST, manhattan=settings))
    truth = simulation.truth
    assert truth.walls_detected_by[7] == 1
    right = evaluate(map_sweeps(mapper, simulation), truth).matches.walls.right
    return next(float(np.degrees(each.angle)) for each in right if each.truth == 7)


def test_an_uncertain_side_of_a_box_is_square_to_the_room() -> None:
    assert side_of_a_box(0.0, settings_with(ManhattanSettings, min_log_odds=1e9)) > 0.2
    assert side_of_a_box(0.0, SETTINGS) < 0.02


def test_an_oblique_box_in_a_square_room_stays_oblique() -> None:
    assert side_of_a_box(3.0, SETTINGS) < 0.1

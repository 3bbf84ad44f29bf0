"""Laws of what is expected and explained: no place, direction or handedness is better than another."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echoplan.acoustics.predicted_echo import EchoModel, Kind, differentiate, shape_of
from echoplan.acoustics.range_walk_model import WalkCurve, fitted_walk
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, transform_points, wrap
from echoplan.joint.arcs import ArcSettings, arc_planes, find_arcs
from echoplan.joint.likelihood.crosstalk import emissions_of
from echoplan.joint.likelihood.double_bounces import ghosts_of_walls
from echoplan.joint.likelihood.hypothesis_scores import Occluders, rescore
from echoplan.joint.likelihood.image_sources import Extent
from echoplan.joint.likelihood.ping_scores import NO_ECHO, score_pings
from echoplan.preprocessing.measurements import Measurements, select_measurements
from echoplan.preprocessing.servo import apply_servo_latency
from helpers.expectations import NOISE, ROOM, SONAR, cylinder, edge, expected, listening, pings_of, wall
from helpers.multipath_log_densities import crosstalk_log_densities, ghosts_of_cylinder

POSES = st.tuples(st.floats(-10, 10), st.floats(-10, 10), st.floats(-3, 3))
SEEDS = st.integers(0, 10_000)
KINDS = st.sampled_from(list(Kind))
HEARING = SONAR.tabulated()
POST = cylinder(0.3, 0.9, 0.1)
# Readings anywhere are near some ghost, if they scatter so much [m].
ROUGH = 0.02
ENDS = (-3.0, 3.0)
SCENE = pings_of(listening(step=np.radians(5.0)), [*ROOM, POST], noise=0.002, rng=np.random.default_rng(0))


def some_reflector(kind: Kind, seed: int) -> FloatArray:
    """A reflector within reach of the middle of the room."""
    rng = np.random.default_rng(seed)
    way, depth = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 2.5)
    if kind is Kind.WALL:
        return wall(way, depth)
    x, y = depth * directions(way)
    return np.array([kind, x, y, rng.uniform(0.02, 0.2) if kind is Kind.CYLINDER else 0.0])


def moved(reflector: FloatArray, pose: tuple[float, float, float]) -> FloatArray:
    """A reflector taken by a pose."""
    if reflector[0] == Kind.WALL:
        angle = reflector[1] + pose[2]
        return wall(angle, float(reflector[2] + directions(angle) @ pose[:2]))
    return np.array([reflector[0], *transform_points(pose, reflector[1:3]), reflector[3]])


def moved_along(reflector: FloatArray, pose: tuple[float, float, float]) -> float:
    """By how much places along a wall change with it."""
    return float(directions(reflector[1] + pose[2] + np.pi / 2) @ pose[:2])


def taken(measurements: Measurements, pose: tuple[float, float, float]) -> Measurements:
    """Measurements taken by a pose."""
    turn = np.exp(1j * pose[2])
    places, axes, arms = (
        turn * (x + 1j * y)
        for x, y in (
            (measurements.x, measurements.y),
            (measurements.ux, measurements.uy),
            (measurements.arms_x, measurements.arms_y),
        )
    )
    return measurements._replace(
        x=places.real + pose[0],
        y=places.imag + pose[1],
        ux=axes.real.copy(),
        uy=axes.imag.copy(),
        arms_x=arms.real.copy(),
        arms_y=arms.imag.copy(),
        centers=transform_points(pose, measurements.centers),
    )


def mirrored(measurements: Measurements) -> Measurements:
    """Measurements in a mirror along the x axis."""
    return measurements._replace(
        y=-measurements.y,
        uy=-measurements.uy,
        arms_y=-measurements.arms_y,
        rates=-measurements.rates,
        centers=measurements.centers * [1.0, -1.0],
    )


def reflected(reflector: FloatArray) -> FloatArray:
    """A reflector in a mirror along the x axis."""
    sign = np.array([1.0, -1.0, 1.0, 1.0] if reflector[0] == Kind.WALL else [1.0, 1.0, -1.0, 1.0])
    image: FloatArray = reflector * sign
    return image


@settings(max_examples=30)
@given(KINDS, SEEDS, POSES)
def test_no_place_or_direction_changes_what_is_expected(
    kind: Kind, seed: int, pose: tuple[float, float, float]
) -> None:
    reflector, pings = some_reflector(kind, seed), select_measurements(SCENE, SCENE.stations == 0)
    here, there = expected(pings, reflector), expected(taken(pings, pose), moved(reflector, pose))
    assert there[0] == pytest.approx(here[0], abs=1e-5)
    assert there[1] == pytest.approx(here[1], abs=1e-7)


@settings(max_examples=30)
@given(KINDS, SEEDS)
def test_in_a_mirror_the_same_is_expected(kind: Kind, seed: int) -> None:
    reflector, pings = some_reflector(kind, seed), select_measurements(SCENE, SCENE.stations == 1)
    for here, there in zip(expected(pings, reflector), expected(mirrored(pings), reflected(reflector)), strict=True):
        assert there == pytest.approx(here, abs=1e-7)


@given(KINDS, SEEDS)
def test_moving_sensor_and_reflector_together_changes_no_reading(kind: Kind, seed: int) -> None:
    reflector, rng, jacobian = some_reflector(kind, seed), np.random.default_rng(seed), np.empty(8)
    x, y, bearing = rng.uniform([-0.1, -0.1, -np.pi], [0.1, 0.1, np.pi]).tolist()
    differentiate(HEARING, shape_of(reflector), (x, y, float(np.cos(bearing)), float(np.sin(bearing))), jacobian)
    if kind is Kind.WALL:
        nx, ny = directions(reflector[1])
        shifts = np.array([nx * jacobian[1] + jacobian[3], ny * jacobian[1] + jacobian[4]])
        turn = jacobian[0] + jacobian[5] - y * jacobian[3] + x * jacobian[4]
    else:
        shifts = jacobian[:2] + jacobian[3:5]
        turn = jacobian[5] - y * jacobian[3] + x * jacobian[4] - reflector[2] * jacobian[0] + reflector[1] * jacobian[1]
    assert shifts == pytest.approx(0.0, abs=1e-9)
    assert turn == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=30)
@given(st.sampled_from([*ROOM, POST, edge(0.3, 0.9), wall(0.3, 1.0)]), POSES)
def test_no_place_or_direction_changes_a_verdict(reflector: FloatArray, pose: tuple[float, float, float]) -> None:
    nothing, log_densities = Occluders(np.zeros((0, 4)), np.zeros((0, 2))), np.full(len(SCENE.readings), np.log(0.01))
    relocalised = taken(SCENE, pose)
    here = rescore(SCENE, reflector, score_pings(SCENE, HEARING, reflector, NOISE), log_densities, nothing)
    place = moved(reflector, pose)
    there = rescore(relocalised, place, score_pings(relocalised, HEARING, place, NOISE), log_densities, nothing)
    assert there.llr_by_station == pytest.approx(here.llr_by_station, abs=1e-3)
    if reflector[0] == Kind.WALL and here.llr > 0.0:
        shift = moved_along(reflector, pose)
        assert (there.low - shift, there.high - shift) == pytest.approx((here.low, here.high), abs=1e-6)


@settings(max_examples=30)
@given(st.sampled_from([*ROOM, POST, edge(0.3, 0.9), wall(0.3, 1.0)]))
def test_in_a_mirror_a_verdict_is_the_same_and_a_wall_runs_the_other_way(reflector: FloatArray) -> None:
    nothing, log_densities = Occluders(np.zeros((0, 4)), np.zeros((0, 2))), np.full(len(SCENE.readings), np.log(0.01))
    image, turned = mirrored(SCENE), reflected(reflector)
    here = rescore(SCENE, reflector, score_pings(SCENE, HEARING, reflector, NOISE), log_densities, nothing)
    there = rescore(image, turned, score_pings(image, HEARING, turned, NOISE), log_densities, nothing)
    assert there.llr_by_station == pytest.approx(here.llr_by_station, abs=1e-6)
    assert (-there.high, -there.low) == pytest.approx((here.low, here.high), abs=1e-9)


def volleys(
    measurements: Measurements, walls: tuple[FloatArray, FloatArray], extents: tuple[Extent, Extent]
) -> FloatArray:
    """What bursts by way of walls explain."""
    return crosstalk_log_densities((measurements, HEARING, emissions_of(measurements, HEARING)), walls, extents, ROUGH)


@settings(max_examples=30)
@given(POSES)
def test_no_place_or_direction_changes_a_ghost(pose: tuple[float, float, float]) -> None:
    rng, count = np.random.default_rng(1), len(SCENE.readings)
    crosstalk_sources = SCENE._replace(
        readings=rng.uniform(0.3, 3.9, count), crosstalk_sources=np.roll(np.arange(count), 3)[:, None]
    )
    relocalised, east, north = taken(crosstalk_sources, pose), moved(ROOM[0], pose), moved(ROOM[1], pose)
    along = [moved_along(each, pose) for each in (ROOM[0], ROOM[1])]
    spans = [(ENDS[0] + each, ENDS[1] + each) for each in along]
    pairs = (
        (
            ghosts_of_walls(crosstalk_sources, HEARING, (ROOM[0], ROOM[1]), (ENDS, ENDS), ROUGH),
            ghosts_of_walls(relocalised, HEARING, (east, north), (spans[0], spans[1]), ROUGH),
        ),
        (
            ghosts_of_cylinder((crosstalk_sources, HEARING), ROOM[0], POST, ROUGH),
            ghosts_of_cylinder((relocalised, HEARING), east, moved(POST, pose), ROUGH),
        ),
        (
            volleys(crosstalk_sources, (ROOM[1], ROOM[1]), (ENDS, ENDS)),
            volleys(relocalised, (north, north), (spans[1], spans[1])),
        ),
        (
            volleys(crosstalk_sources, (ROOM[0], ROOM[1]), (ENDS, ENDS)),
            volleys(relocalised, (east, north), (spans[0], spans[1])),
        ),
    )
    for here, there in pairs:
        assert (here > NO_ECHO).sum() > 5
        assert there == pytest.approx(here, abs=1e-4)


@given(SEEDS)
def test_the_order_of_two_walls_does_not_change_their_ghosts(seed: int) -> None:
    first, second = some_reflector(Kind.WALL, seed), some_reflector(Kind.WALL, seed + 1)
    one = ghosts_of_walls(SCENE, HEARING, (first, second), (ENDS, ENDS), NOISE)
    other = ghosts_of_walls(SCENE, HEARING, (second, first), (ENDS, ENDS), NOISE)
    assert one == pytest.approx(other, abs=1e-6)


@settings(max_examples=20)
@given(POSES)
def test_arcs_and_their_planes_move_with_the_scene(pose: tuple[float, float, float]) -> None:
    relocalised = taken(SCENE, pose)
    arcs = find_arcs(SCENE, resolution=0.001, settings=ArcSettings())
    others = find_arcs(relocalised, resolution=0.001, settings=ArcSettings())
    assert {frozenset(arc.pings.tolist()) for arc in arcs} == {frozenset(arc.pings.tolist()) for arc in others}
    here, there = arc_planes(arcs, SCENE, HEARING), arc_planes(arcs, relocalised, HEARING)
    for plane, image in zip(here, there, strict=True):
        truth = moved(wall(*plane), pose)
        assert wrap(image[0] - truth[1]) == pytest.approx(0.0, abs=1e-6)
        assert image[1] == pytest.approx(truth[2], abs=1e-6)


@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), SEEDS)
def test_a_servo_late_twice_is_late_by_the_sum(first: float, second: float, seed: int) -> None:
    rates = np.random.default_rng(seed).uniform(-2.0, 2.0, len(SCENE.readings))
    turning = SCENE._replace(rates=rates)
    twice = apply_servo_latency(apply_servo_latency(turning, first), second)
    once = apply_servo_latency(turning, first + second)
    for name in ("x", "y", "ux", "uy", "arms_x", "arms_y"):
        assert getattr(twice, name) == pytest.approx(getattr(once, name), abs=1e-12)
    assert np.hypot(twice.ux, twice.uy) == pytest.approx(1.0)
    assert np.hypot(twice.arms_x, twice.arms_y) == pytest.approx(np.hypot(SCENE.arms_x, SCENE.arms_y))


@given(SEEDS, st.floats(1e-3, 1e3), st.floats(-5, 5))
def test_unit_and_zero_of_residuals_do_not_change_a_fitted_walk(seed: int, unit: float, zero: float) -> None:
    rng = np.random.default_rng(seed)
    excess = rng.uniform(0.0, 40.0, 200)
    residuals, weights = np.exp(-excess / 8.0) + rng.normal(0.0, 0.05, 200), rng.uniform(0.1, 1.0, 200)
    fits = (fitted_walk(excess, each, weights=weights, pieces=8) for each in (residuals, unit * residuals + zero))
    (plain, fall), (scaled, scaled_fall) = fits
    assert (np.diff(plain.values) <= 1e-12).all()
    assert scaled.values == pytest.approx(plain.values, abs=1e-6)
    assert scaled_fall == pytest.approx(unit * fall, rel=1e-6)


@given(st.floats(20.0, 45.0), st.floats(3.0, 8.0), st.floats(0.0, 0.04))
def test_whatever_the_sonar_an_aimed_plane_at_one_metre_is_read_right(loud: float, ka: float, gain: float) -> None:
    walk = WalkCurve.from_table([0.0, 6.0, 40.0], [3.0, 1.0, 0.0])
    sonar = EchoModel(figure_of_merit=loud, ka=ka, absorption=1.3, walk=walk, walk_gain=gain)
    aimed = listening([(0.0, 0.0)], arm=0.0, step=np.radians(90.0))
    assert expected(aimed, wall(0.0, 1.0), sonar)[1][2] == pytest.approx(1.0, abs=1e-9)

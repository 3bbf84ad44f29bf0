import json
import pickle
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.evaluation import evaluate
from echoplan.geometry import aligned
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.optimisation import factors, optimiser, solution
from echoplan.joint.optimisation.solver import held, solve
from echoplan.joint.settings import PoseMode, WindowSettings
from echoplan.methods import find_method, map_sweeps
from echoplan.model import CornerKind, FeatureMap, Odometry, Rig, Route, Sweep, translated_wall
from echoplan.simulation import OdometryNoise, Simulation, SimulationSettings
from echoplan.sources import find_rig, find_route, find_world
from helpers import simulated_worlds
from library.rooms import random_simulation

pytestmark = pytest.mark.slow

# East, north, west and south wall of the square: normal angles and offsets.
SQUARE = np.array([[0.0, 2.0], [np.pi / 2, 2.5], [np.pi, 1.0], [-np.pi / 2, 0.5]])
VERTICES = np.array([[x, y] for x in (-1.0, 2.0) for y in (-0.5, 2.5)])
ARRAY, RING = "rotary-array", "ring-16"
# A turning array places walls to millimetres; sixteen pings a station, in steps of 3 mm, do not.
WITHIN = {ARRAY: 0.003, RING: 0.008}
both_rigs = pytest.mark.parametrize("rig", [ARRAY, RING])


@cache
def simulated(
    rig: str, *, quality_factor: float = 20.0, temperature: float = 20.0, **settings: float | str
) -> tuple[Sweep, ...]:
    """Return sweeps from five stations in a square of 3 x 3 m."""
    using = find_rig(rig)
    assert using.transducer
    using = replace(using, transducer=replace(using.transducer, quality_factor=quality_factor))
    simulated = SimulationSettings.model_validate({"air": {"temperature": temperature}} | settings)
    return tuple(
        Simulation(world=find_world("square"), rig=using, route=find_route("square"), settings=simulated, seed=2)
    )


def mapped(rig: str | Rig, sweeps: Sequence[Sweep], settings: JointSettings | None = None) -> FeatureMap:
    return map_sweeps(JointMapper(find_rig(rig) if isinstance(rig, str) else rig, settings), sweeps)


def mapped_without_check(rig: str | Rig, sweeps: Sequence[Sweep]) -> FeatureMap:
    """Return the map without the check that sweeps are from enough places."""
    mapper = JointMapper(find_rig(rig) if isinstance(rig, str) else rig)
    for sweep in sweeps:
        mapper.add(sweep)
    return mapper.result()


def changed(sweeps: Sequence[Sweep], change: Callable[[Sweep], FloatArray]) -> list[Sweep]:
    """Return the sweeps with other readings."""
    return [replace(sweep, ranges=change(sweep)) for sweep in sweeps]


def assert_square(found: FeatureMap, *, within: float) -> None:
    """Check that the map has exactly the four walls, with ends within a distance [m], and nothing false."""
    assert len(found.walls) == 4
    for angle, offset in SQUARE:
        (own,) = [each for each in found.walls if np.cos(each.normal_angle - angle) > 0.99]
        normal = np.array([np.cos(angle), np.sin(angle)])
        assert own.endpoints_xy @ normal == pytest.approx([offset, offset], abs=within)
    assert found.cylinders == ()
    assert all(np.hypot(*(VERTICES - each.position_xy).T).min() < 2 * within for each in found.corners)


@both_rigs
def test_a_square_room_is_mapped_as_a_square(rig: str) -> None:
    found = mapped(rig, simulated(rig))
    assert_square(found, within=WITHIN[rig])
    assert len(found.corners) == 4
    assert all(each.kind is CornerKind.CONCAVE for each in found.corners)
    assert [each.length for each in found.walls] == pytest.approx([3.0] * 4, abs=2 * WITHIN[rig])


@both_rigs
def test_errors_of_walls_agree_with_their_covariances(rig: str) -> None:
    for wall in mapped(rig, simulated(rig)).walls:
        own = SQUARE[np.argmax(np.cos(SQUARE[:, 0] - wall.normal_angle))]
        error = np.array([np.sin(wall.normal_angle - own[0]), wall.offset - own[1]])
        assert error @ np.linalg.solve(wall.covariance, error) < 16.0
        assert np.sqrt(wall.covariance[1, 1]) < WITHIN[rig]


@both_rigs
def test_class_probabilities_depend_on_the_observed_length(rig: str) -> None:
    for wall in mapped(rig, simulated(rig)).walls:
        # On unobserved length all classes are equally probable.
        unobserved = wall.inferred.sum() / wall.length
        assert wall.class_probabilities.wall > 0.99 - 2 / 3 * unobserved
        assert unobserved < (0.45 if rig == RING else 0.01)


@both_rigs
def test_a_square_is_mapped_with_a_fifth_of_the_readings_missing(rig: str) -> None:
    assert_square(mapped(rig, simulated(rig, dropout=0.2)), within=WITHIN[rig])


@both_rigs
def test_a_square_is_mapped_with_a_tenth_of_stray_echoes(rig: str) -> None:
    assert_square(mapped(rig, simulated(rig, stray=0.1)), within=WITHIN[rig])


@both_rigs
@pytest.mark.parametrize("reading", [np.inf, np.nan, -np.inf, 1.0], ids=["deaf", "faulty", "blocked", "stuck"])
def test_a_square_is_mapped_with_one_faulty_sensor(rig: str, reading: float) -> None:
    ill = changed(simulated(rig), lambda sweep: np.where(sweep.sensor_ids == 2, reading, sweep.ranges))
    assert_square(mapped(rig, ill), within=WITHIN[rig])


def with_person(sweep: Sweep) -> FloatArray:
    """Return readings in which a person hides part of the view, elsewhere in each of three sweeps."""
    if sweep.index > 2:
        return sweep.ranges
    bearings = sweep.servo_angles + find_rig(ARRAY).turret_from_sensors[sweep.sensor_ids, 2]
    toward = np.abs(np.angle(np.exp(1j * (bearings - 2.0 * sweep.index)))) < np.radians(25.0)
    legs = 0.6 + 0.1 * sweep.index + 0.02 * np.sin(40.0 * bearings)
    return np.where(toward, np.minimum(legs, sweep.ranges), sweep.ranges)


def test_a_square_is_mapped_while_a_person_walks_through() -> None:
    hidden = changed(simulated(ARRAY), with_person)
    assert sum(int((a.ranges != b.ranges).sum()) for a, b in zip(hidden, simulated(ARRAY), strict=True)) > 60
    assert_square(mapped(ARRAY, hidden), within=WITHIN[ARRAY])


@both_rigs
@pytest.mark.parametrize("reading", [np.inf, np.nan])
def test_a_sweep_without_echoes_does_no_harm(rig: str, reading: float) -> None:
    sweeps = list(simulated(rig))
    sweeps[1] = replace(sweeps[1], ranges=np.full(len(sweeps[1]), reading))
    found = mapped(rig, sweeps)
    assert found.sweeps.tolist() == [0, 1, 2, 3, 4]
    assert len(found.walls) == 4
    assert found.cylinders == ()


def test_a_sweep_without_pings_is_ignored() -> None:
    nothing = np.zeros(0)
    empty = Sweep(
        index=5,
        stamps_ns=nothing.astype(np.int64),
        sensor_ids=nothing.astype(np.int64),
        servo_angles=nothing,
        ranges=nothing,
        map_from_base=np.zeros((0, 3)),
    )
    found = mapped(RING, [*simulated(RING), empty])
    assert found.sweeps.tolist() == [0, 1, 2, 3, 4]
    assert len(found.walls) == 4
    assert mapped(RING, [empty]).walls == ()


@both_rigs
def test_the_map_is_empty_if_nothing_is_in_range(rig: str) -> None:
    found = mapped(rig, changed(simulated(rig), lambda sweep: np.full(len(sweep), np.inf)))
    assert (found.walls, found.corners, found.cylinders) == ((), (), ())
    assert len(found.poses) == 5


def test_the_map_is_empty_without_sweeps() -> None:
    found = mapped(ARRAY, [])
    assert (found.walls, found.corners, found.cylinders) == ((), (), ())
    assert found.poses.shape == (0, 3)


def test_the_map_is_empty_if_every_sensor_is_stuck() -> None:
    # A constant reading everywhere is no room.
    found = mapped(ARRAY, changed(simulated(ARRAY), lambda sweep: np.full(len(sweep), 1.0)))
    assert (found.walls, found.corners, found.cylinders) == ((), (), ())


def test_random_readings_make_no_map() -> None:
    rng = np.random.default_rng(1)
    found = mapped(ARRAY, changed(simulated(ARRAY), lambda sweep: rng.uniform(0.1, 2.9, len(sweep))))
    assert (found.walls, found.corners, found.cylinders) == ((), (), ())


def test_one_station_gives_the_walls_that_it_faces_with_honest_sigmas() -> None:
    found = mapped_without_check(ARRAY, simulated(ARRAY)[1:2])
    assert len(found.walls) == 4
    for wall in found.walls:
        own = SQUARE[np.argmax(np.cos(SQUARE[:, 0] - wall.normal_angle))]
        sigma = np.sqrt(wall.covariance[1, 1])
        assert abs(wall.offset - own[1]) < 3 * sigma
        # One station cannot determine the range scale, whose prior bounds the sigma of walls within 3 m.
        assert sigma < JointSettings().optimiser.scale_sigma * 3.0


def numbers_of(found: FeatureMap) -> FloatArray:
    """Return all numbers of a map."""
    walls = [[each.normal_angle, each.offset, *each.endpoints_xy.flat, *each.covariance.flat] for each in found.walls]
    corners = [[*each.position_xy, *each.covariance.flat] for each in found.corners]
    return np.array([number for row in walls + corners for number in row])


@both_rigs
def test_calling_result_twice_gives_the_same_map(rig: str) -> None:
    mapper = JointMapper(find_rig(rig))
    first = map_sweeps(mapper, simulated(rig))
    second = mapper.result()
    assert (numbers_of(first) == numbers_of(second)).all()
    assert first.parameters == second.parameters


def test_calling_result_between_sweeps_changes_nothing() -> None:
    mapper = JointMapper(find_rig(RING))
    for sweep in simulated(RING):
        mapper.add(sweep)
        between = mapper.result()
    assert (numbers_of(between) == numbers_of(mapped(RING, simulated(RING)))).all()


@cache
def twenty_rounds() -> tuple[Sweep, ...]:
    """Return a thousand sweeps of a ring on twenty rounds through the square, each past the same fifty places."""
    turns = np.linspace(0.0, 40 * np.pi, 1000, endpoint=False)
    way = np.column_stack([0.5 + 0.8 * np.cos(turns), 1.0 + 0.8 * np.sin(turns), turns + np.pi / 2])
    return tuple(Simulation(world=find_world("square"), rig=find_rig(RING), route=Route(map_from_base=way), seed=1))


def test_a_thousand_stations_are_mapped_with_bounded_memory() -> None:
    mapper = JointMapper(
        find_rig(RING), JointSettings(poses=PoseMode.TRUST, window=WindowSettings(stations=6, stride=6))
    )
    sizes = []
    for number, sweep in enumerate(twenty_rounds()):
        mapper.add(sweep)
        if number % 250 == 249:
            sizes.append(len(pickle.dumps(mapper)))
    found = mapper.result()
    assert_square(found, within=0.003)
    assert len(found.poses) == len(found.sweeps) == 1000
    assert all(wall.stations > 100 for wall in found.walls)
    # Only indices and poses are kept per sweep: a few stations are kept per place, and no later ones.
    assert sizes[-1] - sizes[0] < 750 * 100


def test_a_small_window_gives_as_good_a_map_as_all_stations_together() -> None:
    sweeps = twenty_rounds()[:40]
    small = JointSettings(poses=PoseMode.TRUST, window=WindowSettings(stations=4, stride=3))
    whole = JointSettings(poses=PoseMode.TRUST, window=WindowSettings(stations=99, stride=1))
    for settings in (small, whole):
        assert_square(mapped(RING, sweeps, settings), within=0.006)


def test_repeated_sweeps_from_one_pose_add_no_walls_and_no_false_certainty() -> None:
    rig, first = ARRAY, simulated(ARRAY)[0]
    period = int(first.stamps_ns[-1] - first.stamps_ns[0]) + 100_000_000
    room = Simulation(
        world=find_world("square"),
        rig=find_rig(rig),
        route=Route(map_from_base=np.tile(first.station, (12, 1))),
        settings=SimulationSettings(),
        seed=2,
    )
    again = [replace(each, index=k, stamps_ns=first.stamps_ns + k * period) for k, each in enumerate(room)]
    once, found = mapped_without_check(rig, again[:1]), mapped_without_check(rig, again)
    assert len(found.walls) == len(once.walls)
    assert found.poses == pytest.approx(np.tile(first.station, (12, 1)))
    for wall in found.walls:
        assert np.sqrt(wall.covariance[1, 1]) > 0.001
        assert any(abs(np.exp(1j * wall.normal_angle) - np.exp(1j * angle)) < 0.02 for angle, _ in SQUARE)


def test_exact_poses_are_kept_with_coarse_readings() -> None:
    fine = find_rig(ARRAY)
    coarse = replace(fine, sensors=tuple(replace(each, resolution=0.1) for each in fine.sensors))
    room = Simulation(world=find_world("square"), rig=coarse, route=find_route("square"), seed=2)
    found = mapped(coarse, list(room))
    learned = found.parameters["found"]
    assert isinstance(learned, dict)
    assert learned["noise"] >= 0.1 / np.sqrt(12.0)
    assert learned["poses"]["model"] == "fixed"
    assert found.poses == pytest.approx(room.truth.poses)


def test_consistent_poses_are_kept() -> None:
    found = mapped(ARRAY, simulated(ARRAY))
    assert found.poses == pytest.approx(np.array([sweep.station for sweep in simulated(ARRAY)]))
    assert found.sweeps.tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(("length", "width", "beside"), [(5.2, 3.4, 1.3), (3.3, 2.6, 0.8)])
def test_exact_poses_of_a_straight_drive_with_fixed_sensors_are_kept(
    length: float, width: float, beside: float
) -> None:
    way = np.array([[x, beside, 0.0] for x in np.arange(0.6, length - 0.8, 0.05)])
    places = enumerate([(0.1, 0.0), (0.0, 0.06), (-0.1, 0.0), (0.0, -0.06)])
    common = {"half_aperture": np.pi / 6, "max_range": 4.0, "resolution": 0.003}
    each = [simulated_worlds.sensor(number, x=x, y=y, yaw=number * np.pi / 2, **common) for number, (x, y) in places]
    car = replace(simulated_worlds.rig(*each, period=0.06, groups=((0,), (1,), (2,), (3,))), transducer=None)
    room = simulated_worlds.world([[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]], closed=True)
    sweeps = list(simulated_worlds.simulation(room, using=car, poses=way, seed=11, jitter=0.001))
    found = mapped(car, sweeps)
    assert found.poses == pytest.approx(way, abs=1e-9)
    assert len(found.walls) == 4
    for angle in np.arange(4) * np.pi / 2:
        assert sum(np.cos(wall.normal_angle - angle) > 0.99 for wall in found.walls) == 1


def test_the_calibration_is_reported_with_the_settings() -> None:
    found = mapped(ARRAY, simulated(ARRAY))
    parameters = json.loads(json.dumps(found.parameters))
    assert found.method == "joint"
    assert parameters["search"]["min_log_likelihood_ratio"] == JointSettings().search.min_log_likelihood_ratio
    range_scale = parameters["found"]["range_scale"]
    assert range_scale["value"] == pytest.approx(0.0, abs=4 * range_scale["sigma"])
    assert parameters["found"]["inlier_ratio"] > 0.95
    assert 0.001 < parameters["found"]["noise"] < 0.005


@both_rigs
@pytest.mark.parametrize(("temperature", "scale"), [(14.0, -0.0103), (26.0, 0.0102)])
def test_the_range_scale_compensates_the_air_temperature(rig: str, temperature: float, scale: float) -> None:
    # The module assumes the speed of sound at 20 degrees.
    found = mapped(rig, simulated(rig, temperature=temperature))
    parameters = json.loads(json.dumps(found.parameters))
    assert parameters["found"]["range_scale"]["value"] == pytest.approx(scale, abs=0.003)
    assert_square(found, within=WITHIN[rig])


def scale_of(rig: Rig, sweeps: Sequence[Sweep]) -> float:
    found: Any = mapped_without_check(rig, sweeps).parameters["found"]
    return float(found["range_scale"]["value"])


def test_with_one_station_only_a_thermometer_determines_the_range_scale() -> None:
    (warm, *_) = simulated(ARRAY, temperature=31.0)
    assert scale_of(find_rig(ARRAY), [replace(warm, temperature=31.0)]) == pytest.approx(0.0195, abs=0.003)
    assert abs(scale_of(find_rig(ARRAY), [warm]) - 0.0195) > 0.006


def test_the_speed_of_sound_of_the_rig_sets_the_range_scale() -> None:
    # The readings are right for 343 m/s, so a stated 340 m/s makes them short.
    rig, (first, *_) = replace(find_rig(ARRAY), speed_of_sound=340.0), simulated(ARRAY)
    assert scale_of(rig, [replace(first, temperature=20.0)]) == pytest.approx(0.0094, abs=0.003)


def test_a_detector_that_skips_carrier_periods_hardly_moves_walls() -> None:
    assert_square(mapped(ARRAY, simulated(ARRAY, detector="carrier")), within=WITHIN[ARRAY])


@pytest.mark.parametrize("quality_factor", [10.0, 40.0])
def test_a_wrong_quality_factor_of_the_transducer_moves_no_wall(quality_factor: float) -> None:
    # The range walk is half or twice that of the rig.
    assert_square(mapped(ARRAY, simulated(ARRAY, quality_factor=quality_factor)), within=WITHIN[ARRAY])


@both_rigs
@pytest.mark.parametrize("walk", ["fitted", ((0.0, 0.03), (6.0, 0.015), (20.0, 0.004), (50.0, 0.0))])
@pytest.mark.parametrize("detector", ["envelope", "carrier"])
def test_fitted_and_tabulated_range_walks_give_the_same_map(rig: str, walk: str, detector: str) -> None:
    settings = JointSettings.model_validate({"walk": walk})
    assert_square(mapped(rig, simulated(rig, detector=detector), settings), within=WITHIN[rig])


def test_a_side_of_a_box_taken_for_a_corner_becomes_a_wall() -> None:
    simulation = random_simulation(29)
    found = evaluate(mapped(simulation.rig, tuple(simulation)), simulation.truth).matches.walls
    assert found.found == found.wanted
    assert found.spurious == ()


@cache
def around_a_block() -> Simulation:
    """Return a drive around a block in a room, with odometry noise that the rig does not specify."""
    place = simulated_worlds.world(
        [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [0.0, 0.0]],
        [[1.6, 1.1], [2.5, 1.1], [2.5, 1.9], [1.6, 1.9], [1.6, 1.1]],
    )
    around = [
        [0.8, 0.6],
        [1.7, 0.6],
        [2.6, 0.6],
        [3.3, 0.9],
        [3.2, 1.7],
        [3.2, 2.4],
        [2.3, 2.4],
        [1.4, 2.4],
        [0.8, 2.1],
    ]
    way = np.array([*around, [0.8, 1.3], [0.85, 0.65]])
    ahead = np.diff(way, axis=0, append=way[1:2])
    return simulated_worlds.simulation(
        place,
        using=simulated_worlds.array(resolution=0.005),
        poses=np.column_stack([way, np.arctan2(ahead[:, 1], ahead[:, 0])]),
        seed=2,
        odometry=OdometryNoise(along=0.03, lateral=0.02, yaw_per_metre=np.radians(3.0)),
    )


def test_walls_detected_again_close_the_loop() -> None:
    drive = around_a_block()
    found = mapped(drive.rig, tuple(drive), JointSettings(poses=PoseMode.AUTO))
    lost, off = (np.hypot(*(each - drive.truth.poses)[-1, :2]) for each in (drive.truth.given, found.poses))
    assert lost > 0.1
    assert off < 0.005
    # Four walls of the room and four sides of the block, without duplicates.
    assert len(found.walls) == 8
    # Drifting poses do not determine the range scale, which keeps its prior.
    learned: Any = found.parameters["found"]
    assert learned["range_scale"] == {"value": pytest.approx(0.0, abs=1e-6), "sigma": 0.002, "prior_sigma": 0.002}


def test_odometry_does_not_scale_the_landmarks_from_which_another_recording_goes_on() -> None:
    drive = around_a_block()
    mapper = JointMapper(drive.rig)
    for sweep in drive:
        mapper.add(replace(sweep, map_from_base=sweep.map_from_base * [1.03, 1.03, 1.0]))
    known = mapper.prior()
    assert known is not None
    found = np.linalg.solve(known.summary.information, known.summary.vector)
    # Poses alone would move walls by 0.1 m.
    assert np.abs(found - np.concatenate([each.parameters for each in known.features])).max() < 0.01


def test_a_landmark_knows_which_recording_detected_it_first() -> None:
    drive = around_a_block()
    sweeps, mapper = tuple(drive), JointMapper(drive.rig)
    half = len(sweeps) // 2
    for sweep in sweeps[:half]:
        mapper.add(sweep)
    earlier = mapper.prior()
    assert earlier is not None
    mapper.begin_recording(sweeps[half].station)
    for sweep in sweeps[half:]:
        mapper.add(sweep)
    known = mapper.prior()
    assert known is not None
    recordings = {each.history.number: each.history.recording for each in known.features}
    assert set(recordings.values()) == {0, 1}
    assert all((number > earlier.issued) == recording for number, recording in recordings.items())


@pytest.mark.parametrize(
    ("specified", "farther"),
    [
        (Odometry(along=0.03), False),
        (Odometry(along=0.003, lateral=0.002, yaw_per_metre=np.radians(0.3), yaw_per_radian=0.0), True),
    ],
    ids=["part", "a tenth"],
)
@pytest.mark.parametrize("stations", [24, 7], ids=["at once", "as they come"])
def test_a_rig_that_understates_its_odometry_noise_does_not_distort_the_map(
    specified: Odometry, *, farther: bool, stations: int
) -> None:
    drive, window = around_a_block(), WindowSettings(stations=stations, stride=2)
    mapper = JointMapper(replace(drive.rig, odometry=specified), JointSettings(window=window))
    found = map_sweeps(mapper, tuple(drive))
    assert np.hypot(*(found.poses - drive.truth.poses)[:, :2].T).max() < 0.01
    assert len(found.walls) == 8
    learned: Any = found.parameters["found"]
    assert learned["poses"]["exceeds_specification"] == farther


def test_an_empty_odometry_table_has_no_effect() -> None:
    drive = around_a_block()
    plain, empty = (mapped(replace(drive.rig, odometry=each), tuple(drive)[:4]) for each in (None, Odometry()))
    assert np.array_equal(plain.poses, empty.poses)
    assert plain.parameters == empty.parameters


def test_the_frame_is_that_of_all_waypoints_and_not_of_the_first_one() -> None:
    # The error of the first pose, 2 cm and 4 degrees, would move the far wall by 20 cm if that pose were the frame.
    rng = np.random.default_rng(3)
    place = simulated_worlds.world([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [0.0, 0.0]])
    poses = np.array([[x, y, rng.uniform(-3.0, 3.0)] for y in (0.7, 1.5, 2.3) for x in (0.7, 1.5, 2.4, 3.3)])
    marks = np.tile([0.008, 0.008, np.radians(1.5)], (len(poses), 1))
    errors = marks * rng.standard_normal(marks.shape)
    errors[0] = [0.02, -0.02, np.radians(4.0)]
    exact = simulated_worlds.simulation(place, using=simulated_worlds.array(resolution=0.005), poses=poses, seed=2)
    sweeps = [
        replace(sweep, map_from_base=sweep.map_from_base + error) for sweep, error in zip(exact, errors, strict=True)
    ]
    found = mapped(exact.rig, sweeps, JointSettings(poses=PoseMode.AUTO))
    assert len(found.walls) == 4
    for wall in found.walls:
        axis = int(abs(np.cos(wall.normal_angle)) < 0.5)
        away = np.abs(wall.endpoints_xy[:, axis, None] - np.array([0.0, (4.0, 3.0)[axis]])).min(axis=1)
        assert away.max() < 0.02
    # All waypoints together determine the place and the scale of the room; echoes determine its shape.
    shape = aligned(found.poses, exact.truth.poses) - exact.truth.poses
    assert np.hypot(*shape[:, :2].T).max() < 0.007
    off = np.hypot(*(found.poses - exact.truth.poses)[:, :2].T)
    assert off[0] < 0.5 * np.hypot(*errors[0, :2])


@pytest.mark.parametrize("max_waypoints", [0, 60], ids=["odometry", "waypoints"])
def test_the_solver_is_at_most_six_calls_below_the_mapper(monkeypatch: pytest.MonkeyPatch, max_waypoints: int) -> None:
    chains = set[tuple[str, ...]]()

    def noted(solver: Callable[..., FloatArray]) -> Callable[..., FloatArray]:
        def wrapper(*arguments: Any) -> FloatArray:
            stack = [frame.f_code for frame, _ in traceback.walk_stack(None)]
            names = [each.co_name for each in stack if "echoplan/joint" in each.co_filename]
            chains.add((solver.__name__, *names))
            return solver(*arguments)

        return wrapper

    for module in (factors, optimiser, solution):
        monkeypatch.setattr(module, "solve", noted(solve))
    monkeypatch.setattr(optimiser, "held", noted(held))
    settings = JointSettings(poses=PoseMode.CORRECT, max_waypoints=max_waypoints)
    mapper = JointMapper(find_rig(ARRAY), settings)
    for sweep in simulated(ARRAY):
        mapper.add(sweep)
    mapper.result()
    assert {chain[-1] for chain in chains} == {"result"}
    assert max(len(chain) - 1 for chain in chains) <= 6


def test_stations_miss_a_wall_that_is_not_there_and_no_other() -> None:
    # In a frame that begins far away, as that of a country does.
    mapper, away = find_method("joint").build(find_rig(ARRAY)), np.array([4096.0, -8192.0])
    sweeps = [replace(each, map_from_base=each.map_from_base + np.append(away, 0.0)) for each in simulated(ARRAY)]
    found = map_sweeps(mapper, sweeps)
    # Half a metre before the wall in the east.
    east = max(found.walls, key=lambda wall: float(np.cos(wall.normal_angle)))
    nearer = translated_wall(east, np.array([-0.5, 0.0]))
    *there, nowhere = mapper.misses(sweeps)([*found.walls, nearer])
    assert min(there) > -12.0
    assert nowhere < -36.0

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echoplan.acoustics import Air
from echoplan.arrays import ComplexArray, FloatArray
from echoplan.geometry import compose
from echoplan.model import Route
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.simulation.echoes import find_echoes
from echoplan.simulation.schedule import build_schedule
from helpers import simulated_worlds

SECOND = 1_000_000_000
few = settings(max_examples=25)
poses = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-np.pi, np.pi)).map(np.array)
# Places in the air of the test room, well off its walls.
places = st.sampled_from([(0.9, 1.5), (2.3, 0.9), (3.7, 1.9), (1.0, 2.2), (2.2, 1.7)])
headings = st.floats(-np.pi, np.pi)
seeds = st.integers(0, 2**31)


def of_room(place: tuple[float, float], heading: float, **changed: Any) -> Simulation:
    rig = simulated_worlds.array(sensors=2)
    return simulated_worlds.simulation(simulated_worlds.room(), using=rig, poses=[[*place, heading]], **changed)


def same(one: FloatArray, other: FloatArray, *, atol: float) -> float:
    """Share of readings that agree; those at the very threshold may tip over by rounding."""
    with np.errstate(invalid="ignore"):
        return float(((one == other) | (np.abs(one - other) <= atol)).mean())


@few
@given(poses, places, headings)
def test_it_does_not_matter_where_the_world_lies(frame: FloatArray, place: tuple[float, float], heading: float) -> None:
    here = of_room(place, heading)
    there = simulated_worlds.simulation(
        simulated_worlds.moved(simulated_worlds.room(), frame),
        using=simulated_worlds.array(sensors=2),
        poses=[compose(frame, np.array([*place, heading]))],
    )
    assert same(simulated_worlds.readings(here), simulated_worlds.readings(there), atol=1e-6) > 0.98


@few
@given(places, headings)
def test_a_mirrored_world_reads_mirrored(place: tuple[float, float], heading: float) -> None:
    room = simulated_worlds.room()
    flip = np.array([1.0, -1.0])
    mirrored = simulated_worlds.world(
        *(line.points_xy * flip for line in room.polylines[1:]),
        pillars=[(pillar.center_xy[0], -pillar.center_xy[1], pillar.radius) for pillar in room.pillars],
    )
    upright = simulated_worlds.world(
        *(line.points_xy for line in room.polylines[1:]),
        pillars=[(*pillar.center_xy, pillar.radius) for pillar in room.pillars],
    )
    # The servo stands still, so that it does not turn the other way.
    rig = simulated_worlds.rig(*(simulated_worlds.sensor(each, yaw=each * 0.7) for each in range(9)))
    other_rig = simulated_worlds.rig(*(simulated_worlds.sensor(each, yaw=-each * 0.7) for each in range(9)))
    here = simulated_worlds.simulation(upright, using=rig, poses=[[*place, heading]])
    there = simulated_worlds.simulation(mirrored, using=other_rig, poses=[[place[0], -place[1], -heading]])
    assert same(simulated_worlds.readings(here), simulated_worlds.readings(there), atol=1e-6) == 1.0


def over(simulation: Simulation, *, source: int, receiver: int) -> tuple[FloatArray, ComplexArray]:
    """Echoes of one burst at one receiver, in the order of time."""
    stage = simulation._receivers.stage
    emitters = np.zeros(2, dtype=np.int64)
    emitters[receiver] = source
    shots = stage.shots._replace(first_burst=emitters, last_burst=emitters + 1)
    found = find_echoes(stage._replace(shots=shots), np.array([receiver]), shots.deadlines[[receiver]])
    order = np.argsort(found.times)
    return found.times[order], found.strengths[order]


@given(places, places, headings, headings)
def test_transmitter_and_receiver_can_be_exchanged(
    first: tuple[float, float], second: tuple[float, float], heading: float, other: float
) -> None:
    rig = simulated_worlds.rig(
        simulated_worlds.sensor(0, x=first[0], y=first[1], yaw=heading),
        simulated_worlds.sensor(1, x=second[0], y=second[1], yaw=other),
    )
    simulation = simulated_worlds.simulation(simulated_worlds.room(), using=rig)
    times, strengths = over(simulation, source=0, receiver=1)
    back, echoed = over(simulation, source=1, receiver=0)
    np.testing.assert_allclose(times, back, rtol=1e-9)
    np.testing.assert_allclose(np.sort(abs(strengths)), np.sort(abs(echoed)), rtol=1e-6)


@few
@given(places, headings, st.floats(-10, 40))
def test_only_the_ratio_of_assumed_to_true_speed_scales_ranges(
    place: tuple[float, float], heading: float, assumed: float
) -> None:
    # The same air, read by a module that takes it for colder or warmer; its zero moves by less than a millimetre.
    right = simulated_worlds.readings(of_room(place, heading))
    wrong = simulated_worlds.readings(of_room(place, heading, assumed_temperature=assumed))
    ratio = Air(temperature=assumed).speed_of_sound / Air().speed_of_sound
    both = np.isfinite(right) & np.isfinite(wrong)
    assert both.any()
    np.testing.assert_allclose(wrong[both], right[both] * ratio, atol=0.001)


@few
@given(places, headings, seeds)
def test_the_same_seed_gives_the_same_bits(place: tuple[float, float], heading: float, seed: int) -> None:
    noisy = {"jitter": 0.003, "stray": 0.1, "dropout": 0.1}
    one, other = (simulated_worlds.readings(of_room(place, heading, seed=seed, **noisy)) for _ in range(2))
    np.testing.assert_array_equal(one, other)


@few
@given(places, headings, seeds)
def test_readings_are_ranges_within_reach_or_say_what_is_the_matter(
    place: tuple[float, float], heading: float, seed: int
) -> None:
    readings = simulated_worlds.readings(of_room(place, heading, seed=seed, jitter=0.01, stray=0.3, dropout=0.2))
    finite = readings[np.isfinite(readings)]
    assert not np.isnan(readings).any()
    assert (finite >= 0.03).all()
    assert (finite <= 3.0).all()


@few
@given(places, headings)
def test_an_incoherent_sum_is_at_least_its_strongest_echo(place: tuple[float, float], heading: float) -> None:
    simulation = of_room(place, heading, superposition="incoherent", crosstalk=False, second_time_around=False)
    stage = simulation._receivers.stage
    pings = np.arange(len(stage.shots.instants))
    echoes = find_echoes(stage, pings, stage.shots.deadlines - 3e-4)
    loudest = np.array(
        [
            abs(echoes.strengths[begin:end]).max(initial=0.0)
            for begin, end in zip(echoes.bounds, echoes.bounds[1:], strict=False)
        ]
    )
    assert (simulated_worlds.readings(simulation)[loudest > 1.01] < np.inf).all()


@given(st.floats(0.02, 0.2), st.floats(0.5, 5.0), st.integers(1, 3))
def test_a_schedule_never_goes_back_in_time_and_covers_every_ping(period: float, seconds: float, groups: int) -> None:
    sensors = [simulated_worlds.sensor(each) for each in range(groups)]
    rig = simulated_worlds.rig(
        *sensors,
        servo=simulated_worlds.turning(-20, 20, 5),
        period=period,
        groups=tuple((each,) for each in range(groups)),
    )
    route = Route(
        map_from_base=np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 1.0]]), stamps_ns=np.array([0, int(seconds * SECOND)])
    )
    schedule = build_schedule(rig, route)
    assert (np.diff(schedule.stamps_ns) >= 0).all()
    assert (np.diff(schedule.bounds) > 0).all()
    assert schedule.bounds[-1] == len(schedule.stamps_ns) == len(schedule.servo_angles)
    assert np.abs(schedule.servo_angles).max() <= np.radians(20.001)


@few
@given(st.floats(0.2, 3.0), st.floats(-0.5, 0.5))
def test_a_wall_is_read_no_nearer_than_it_is(distance: float, angle: float) -> None:
    # But for the zero of the module: nearer than 1 m an echo is louder and trips sooner.
    simulation = simulated_worlds.simulation(simulated_worlds.wall(distance), poses=[[0.0, 0.0, angle]])
    reading = float(simulated_worlds.readings(simulation)[0])
    zero = 0.5 * Air().speed_of_sound * simulation._module.zero_delay
    assert reading >= distance - zero
    if distance >= 1.0:
        assert reading >= distance - 1e-9


def test_settings_are_plain_values() -> None:
    assert SimulationSettings(jitter=0.002) == SimulationSettings(jitter=0.002)
    with pytest.raises(ValueError, match="frozen"):
        SimulationSettings().jitter = 0.1

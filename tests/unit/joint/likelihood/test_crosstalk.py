import itertools

import numpy as np
import pytest
from scipy.optimize import minimize

from echoplan.acoustics import Air
from echoplan.acoustics.echo_model import EchoModel
from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.crosstalk import add_crosstalk, emissions_of
from echoplan.joint.likelihood.image_sources import Extent
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import NOISE, listening, wall
from helpers.multipath_log_densities import crosstalk_log_densities
from helpers.single_ping import PLAIN, length, likeliest, one_ping, point_on

ENDLESS = (-50.0, 50.0)
EAST, OBLIQUE = wall(0.0, 1.0), wall(np.radians(110.0), 1.1)
# Range that corresponds to the travel of sound between two firings 25 ms apart [m].
FIRING, WAIT = 0.025, 0.025 * Air().speed_of_sound / 2


def crosstalk_over(
    measurements: Measurements, model: EchoModel, *walls: FloatArray, extents: tuple[Extent, ...] = ()
) -> FloatArray:
    """Return the log densities of the pings by crosstalk over walls."""
    pings_of, reaches = model.tabulated(), extents or (ENDLESS, ENDLESS)
    pair, ends = (walls[0], walls[-1]), (reaches[0], reaches[-1])
    return crosstalk_log_densities((measurements, pings_of, emissions_of(measurements, pings_of)), pair, ends, NOISE)


def detected(measurements: Measurements, *walls: FloatArray, extents: tuple[Extent, ...] = ()) -> FloatArray:
    """Return the same without range walk."""
    return crosstalk_over(measurements, PLAIN, *walls, extents=extents)


def shortest_path(
    origin: tuple[float, float], place: tuple[float, float], *walls: FloatArray
) -> tuple[float, FloatArray]:
    """Return the shortest path over two walls and its reflection points, by Fermat's principle."""

    def way(alongs: FloatArray) -> float:
        spots = [point_on(each, along) for each, along in zip(walls, alongs, strict=True)]
        return length(np.array(origin), *spots, np.array(place))

    found = minimize(way, np.zeros(2), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000})
    return float(found.fun), found.x


@pytest.mark.parametrize("mate", [(0.05, 0.0), (0.0, -0.4), (-0.6, 0.5)])
def test_crosstalk_over_one_wall_comes_from_the_image_source(mate: tuple[float, float]) -> None:
    log_densities = detected(measurements := one_ping((0.0, 0.0), 0.2, mate=mate, mate_bearing=0.3), EAST)
    image = np.array([2.0 - mate[0], mate[1]])
    assert likeliest(measurements, log_densities) == pytest.approx(np.hypot(*image) / 2, abs=1e-4)


@pytest.mark.parametrize("mate", [(0.05, 0.0), (0.3, -0.4), (-0.2, 0.3)])
@pytest.mark.parametrize("walls", list(itertools.permutations([EAST, OBLIQUE])))
def test_crosstalk_over_two_walls_has_the_shortest_path(
    mate: tuple[float, float], walls: tuple[FloatArray, FloatArray]
) -> None:
    measurements = one_ping((0.1, 0.0), 1.0, mate=mate, mate_bearing=0.9)
    shortest, _ = shortest_path(mate, (0.1, 0.0), *walls)
    assert likeliest(measurements, detected(measurements, *walls)) == pytest.approx(shortest / 2, abs=1e-4)


def test_crosstalk_of_an_opposite_sensor_comes_over_two_parallel_walls() -> None:
    measurements = one_ping((0.3, 0.0), 0.0, mate=(0.3, 0.0), mate_bearing=np.pi)
    assert likeliest(measurements, detected(measurements, wall(np.pi, 1.0), EAST)) == pytest.approx(2.0, abs=1e-4)
    assert (detected(measurements, EAST, wall(np.pi, 1.0)) == NO_ECHO).all()


def test_crosstalk_of_the_previous_firing_reads_short_by_its_travel_time() -> None:
    measurements = one_ping((0.0, 0.0), 0.0, mate=(0.0, 0.0), lag=FIRING)
    far = wall(0.0, WAIT + 0.7)
    assert likeliest(measurements, detected(measurements, far)) == pytest.approx(0.7, abs=1e-4)


def test_crosstalk_of_the_previous_firing_depends_on_the_speed_of_sound() -> None:
    measurements, far = one_ping((0.0, 0.0), 0.0, mate=(0.0, 0.0), lag=FIRING), wall(0.0, 1.02 * (WAIT + 0.7))
    warm = crosstalk_over(measurements, PLAIN.scaled(0.02), far)
    assert likeliest(measurements, warm) == pytest.approx(0.7, abs=1e-4)


def test_without_other_bursts_there_is_no_crosstalk() -> None:
    for walls in ((EAST,), (EAST, OBLIQUE)):
        assert (detected(one_ping((0.0, 0.0), 0.2), *walls) == NO_ECHO).all()


def test_crosstalk_is_reflected_within_the_extent_of_the_wall() -> None:
    # The reflection point is halfway between the sensors, which are equally far from the wall.
    measurements = one_ping((0.0, 0.0), 0.2, mate=(0.0, 0.6), mate_bearing=0.0)
    inside, outside = (detected(measurements, EAST, extents=(extent,)) for extent in ((0.29, 0.31), (0.31, 0.9)))
    assert inside.max() > 0.0
    assert (outside == NO_ECHO).all()


@pytest.mark.parametrize("hidden", [0, 1])
def test_crosstalk_over_two_walls_needs_both_reflection_points(hidden: int) -> None:
    measurements = one_ping((0.1, 0.0), 1.0, mate=(0.3, -0.4), mate_bearing=0.9)
    _, strikes = shortest_path((0.3, -0.4), (0.1, 0.0), EAST, OBLIQUE)
    around = [(each - 0.05, each + 0.05) for each in strikes]
    assert detected(measurements, EAST, OBLIQUE, extents=tuple(around)).max() > 0.0
    around[hidden] = (strikes[hidden] + 0.1, strikes[hidden] + 0.2)
    assert (detected(measurements, EAST, OBLIQUE, extents=tuple(around)) == NO_ECHO).all()


@pytest.mark.parametrize(("place", "mate"), [((0.0, 0.0), (1.5, 0.0)), ((1.5, 0.0), (0.0, 0.0))])
def test_crosstalk_does_not_pass_through_a_wall(place: tuple[float, float], mate: tuple[float, float]) -> None:
    measurements = one_ping(place, 0.0, mate=mate)
    assert (detected(measurements, EAST) == NO_ECHO).all()


def test_a_sensor_that_points_away_causes_less_crosstalk() -> None:
    toward, away = (
        detected(one_ping((0.0, 0.0), 0.2, mate=(0.0, -0.4), mate_bearing=bearing), wall(0.0, 2.5)).max()
        for bearing in (0.1, 2.0)
    )
    assert toward > 0.0
    assert away < toward - 5.0


def test_the_most_likely_burst_explains_a_reading() -> None:
    measurements = one_ping((0.0, 0.0), 0.2, mate=(0.0, -0.4), mate_bearing=0.1)
    crosstalk_sources = measurements.crosstalk_sources.copy()
    crosstalk_sources[:, 0] = crosstalk_sources[:, 1]
    twice = measurements._replace(crosstalk_sources=crosstalk_sources)
    assert detected(twice, EAST).tolist() == detected(measurements, EAST).tolist()


def test_restricting_crosstalk_to_possible_sources_loses_nothing() -> None:
    rng, tables = np.random.default_rng(4), PLAIN.tabulated()
    scene = listening(step=np.radians(0.5))
    count = len(scene.readings) // len(scene.centers)
    # The other sensor of each ping is at the same station and points 5 degrees aside.
    crosstalk_sources = scene.stations * count + (np.arange(len(scene.readings)) + 10) % count
    measured = scene._replace(
        readings=rng.uniform(0.3, 3.9, len(crosstalk_sources)),
        crosstalk_sources=crosstalk_sources[:, None],
        crosstalk_delays=np.zeros((len(crosstalk_sources), 1)),
    )
    emissions = emissions_of(measured, tables)
    everywhere = emissions._replace(spread=np.full(len(emissions.spread), np.inf))
    for walls in ((EAST, EAST), (wall(np.pi / 2, 0.8), EAST)):
        here, there = (
            crosstalk_log_densities((measured, tables, each), walls, (ENDLESS, ENDLESS), 0.02)
            for each in (emissions, everywhere)
        )
        assert (here > NO_ECHO).sum() > 5
        assert here.tolist() == there.tolist()


def test_bursts_out_of_range_are_left_out() -> None:
    near, far = (one_ping((0.0, 0.0), 0.0, mate=(0.0, 0.0), lag=lag) for lag in (FIRING, 8 * FIRING))
    assert len(emissions_of(near, PLAIN.tabulated()).pings) > 0
    assert len(emissions_of(far, PLAIN.tabulated()).pings) == 0


def test_adding_crosstalk_keeps_better_explanations() -> None:
    measurements, tables = one_ping((0.0, 0.0), 0.2, mate=(0.0, -0.4), mate_bearing=0.1), PLAIN.tabulated()
    emissions, ends = emissions_of(measurements, tables), (ENDLESS, ENDLESS)
    alone = crosstalk_log_densities((measurements, tables, emissions), (EAST, EAST), ends, NOISE)
    known = np.where(np.arange(len(alone)) % 2, 0.0, NO_ECHO)
    add_crosstalk(log_densities := known.copy(), (measurements, tables, emissions), (EAST, EAST), ends, NOISE)
    assert alone.max() > 0.0
    assert log_densities.tolist() == np.maximum(alone, known).tolist()

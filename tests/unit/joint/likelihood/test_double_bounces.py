from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

from echoplan.acoustics import directivity, edge_echo, signal_excess
from echoplan.acoustics.air import Air
from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.double_bounces import add_ghosts_of_cylinder, add_ghosts_of_walls, ghosts_of_walls
from echoplan.joint.likelihood.image_sources import Extent
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import NOISE, SONAR, cylinder, wall
from helpers.multipath_log_densities import ghosts_of_cylinder
from helpers.oracles import bistatic_cylinder_echo
from helpers.simulated_worlds import PAPER
from helpers.single_ping import PLAIN, length, likeliest, one_ping, point_on

ENDLESS = (-50.0, 50.0)
EAST, NORTH = wall(0.0, 1.0), wall(np.pi / 2, 0.8)
# Only walls that meet at 90 degrees or less return sound over both.
OBLIQUE = wall(np.radians(110.0), 1.1)


def chance(excess: float) -> float:
    """Return the detection probability of a double echo, whose excess is known to some decibels only."""
    return float(1 / (1 + np.exp(-excess / 3.0)))


def shortest_path(place: tuple[float, float], first: FloatArray, second: FloatArray) -> tuple[float, FloatArray]:
    """Return the shortest path over both walls and back, and its reflection points (Fermat's principle)."""
    start = np.array(place)

    def way(alongs: FloatArray) -> float:
        return length(start, point_on(first, alongs[0]), point_on(second, alongs[1]), start)

    found = minimize(way, np.zeros(2), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000})
    return float(found.fun), found.x


def double_echoes(
    measurements: Measurements,
    first: FloatArray,
    second: FloatArray,
    extents: tuple[Extent, Extent] = (ENDLESS, ENDLESS),
) -> FloatArray:
    """Return the log densities of double echoes over two walls, without range walk."""
    return ghosts_of_walls(measurements, PLAIN.tabulated(), (first, second), extents, NOISE)


@pytest.mark.parametrize("place", [(0.2, 0.1), (-0.5, 0.4), (0.7, -0.6)])
def test_in_a_right_angle_a_double_echo_reads_the_distance_of_the_vertex(place: tuple[float, float]) -> None:
    away = np.array([1.0, 0.8]) - place
    measurements = one_ping(place, float(np.arctan2(away[1], away[0])))
    reading = likeliest(measurements, double_echoes(measurements, EAST, NORTH))
    assert reading == pytest.approx(np.hypot(*away), abs=1e-4)


@pytest.mark.parametrize("place", [(0.2, 0.1), (-0.3, 0.4), (0.1, -0.6)])
@pytest.mark.parametrize("second", [OBLIQUE, wall(np.radians(-125.0), 1.2)])
def test_a_double_echo_takes_the_shortest_path_over_both_walls(place: tuple[float, float], second: FloatArray) -> None:
    measurements = one_ping(place, float(second[1] / 2))
    shortest, _ = shortest_path(place, EAST, second)
    there, back = (
        likeliest(measurements, double_echoes(measurements, *pair)) for pair in ((EAST, second), (second, EAST))
    )
    assert there == back == pytest.approx(shortest / 2, abs=1e-4)


def test_a_path_over_two_parallel_walls_returns_from_behind_and_is_not_detected() -> None:
    measurements = one_ping((0.3, 0.0), 0.0)
    assert (double_echoes(measurements, EAST, wall(np.pi, 1.0)) == NO_ECHO).all()


@pytest.mark.parametrize("hidden", [0, 1])
def test_a_double_echo_needs_both_walls_at_its_reflection_points(hidden: int) -> None:
    place, walls = (0.2, 0.1), (EAST, OBLIQUE)
    _, strikes = shortest_path(place, *walls)
    measurements = one_ping(place, 0.9)
    around = [strike + np.array([-0.05, 0.05]) for strike in strikes]
    assert double_echoes(measurements, *walls, (around[0], around[1])).max() > 0.0
    beside = [each + (0.2 if number == hidden else 0.0) for number, each in enumerate(around)]
    assert (double_echoes(measurements, *walls, (beside[0], beside[1])) == NO_ECHO).all()


@pytest.mark.parametrize("place", [(1.2, 0.1), (0.2, 0.9)])
def test_there_is_no_double_echo_from_behind_a_wall(place: tuple[float, float]) -> None:
    assert (double_echoes(one_ping(place, 0.7), EAST, NORTH) == NO_ECHO).all()


def test_a_double_echo_has_one_and_a_half_times_the_noise_of_an_echo() -> None:
    measurements = one_ping((0.2, 0.1), 0.7188)
    log_densities = double_echoes(measurements, EAST, NORTH)
    detected = log_densities > NO_ECHO
    late = measurements.readings[detected] - np.hypot(0.8, 0.7)
    assert log_densities[detected] - log_densities.max() == pytest.approx(-0.5 * (late / (1.5 * NOISE)) ** 2, abs=1e-3)
    assert np.abs(late).max() == pytest.approx(6 * 1.5 * NOISE, abs=2e-4)


def test_multipath_explains_no_missing_echo() -> None:
    assert double_echoes(one_ping((0.2, 0.1), 0.7), EAST, NORTH)[-1] == NO_ECHO


def test_a_double_echo_is_attenuated_by_the_beam_on_departure_and_arrival() -> None:
    # In an oblique corner the directions of departure and arrival differ.
    place, bearing = np.array([0.2, 0.1]), 0.8
    measurements = one_ping((0.2, 0.1), bearing)
    shortest, strikes = shortest_path((0.2, 0.1), EAST, OBLIQUE)
    ends = [point_on(each, strike) - place for each, strike in zip((EAST, OBLIQUE), strikes, strict=True)]
    offs = [float(np.arctan2(way[1], way[0])) - bearing for way in ends]
    beams = np.prod([directivity(off, PLAIN.ka) for off in offs])
    # The path in both directions adds coherently.
    excess = float(signal_excess(2 / shortest, shortest, transducer=PAPER, air=Air(), beams=beams))
    peak = np.log(chance(excess) / (np.sqrt(2 * np.pi) * 1.5 * NOISE))
    assert abs(offs[0] - offs[1]) > 0.5
    assert double_echoes(measurements, EAST, OBLIQUE).max() == pytest.approx(peak, abs=1e-2)


@pytest.mark.parametrize(("degrees", "louder"), [(90.0, 0.0), (89.0, 4.37), (85.0, 6.02)])
def test_both_paths_merge_in_the_vertex_of_a_right_angle(degrees: float, louder: float) -> None:
    # At 89 degrees the path over a vertex 3 m away is 0.11 wavelengths longer: 1 + 2 sqrt(0.11) times one of the two.
    angle = np.radians(degrees)
    walls = [wall(side * (np.pi - angle) / 2, 3 * np.sin(angle / 2)) for side in (-1, 1)]
    measurements = one_ping((0.0, 0.0), 0.0)
    depth, beams = 3 * np.sin(angle), directivity(np.pi / 2 - angle, PLAIN.ka) ** 2
    one_way = float(signal_excess(1 / (2 * depth), 2 * depth, transducer=PAPER, air=Air(), beams=beams))
    expected = np.log(chance(one_way + louder) / (np.sqrt(2 * np.pi) * 1.5 * NOISE))
    assert double_echoes(measurements, walls[0], walls[1]).max() == pytest.approx(expected, abs=0.01)


def corner(degrees: float, distance: float) -> tuple[FloatArray, FloatArray]:
    """Return two walls that meet at a distance ahead of the origin."""
    angle = np.radians(degrees)
    first, second = (wall(side * (np.pi - angle) / 2, distance * np.sin(angle / 2)) for side in (-1, 1))
    return first, second


@pytest.mark.parametrize("distance", [1.0, 2.5])
@pytest.mark.parametrize("degrees", [90.5, 92.0, 95.0])
def test_the_vertex_of_a_wide_corner_returns_sound_as_diffraction_theory_predicts(
    degrees: float, distance: float
) -> None:
    measurements = one_ping((0.0, 0.0), 0.0)
    wavenumber, opening = 2 * np.pi / PLAIN.tabulated().wavelength, np.radians(degrees)
    echo = abs(edge_echo(distance, angle=opening / 2, opening=opening, wavenumber=wavenumber))
    excess = float(signal_excess(echo, 2 * distance, transducer=PAPER, air=Air()))
    expected = np.log(chance(excess) / (np.sqrt(2 * np.pi) * 1.5 * NOISE))
    log_densities = double_echoes(measurements, *corner(degrees, distance))
    assert likeliest(measurements, log_densities) == pytest.approx(distance, abs=1e-4)
    assert log_densities.max() == pytest.approx(expected, abs=0.2)


def test_a_vertex_returns_sound_only_if_both_walls_reach_it_and_from_within() -> None:
    measurements, (first, second) = one_ping((0.0, 0.0), 0.0), corner(92.0, 1.0)
    # Along the first wall the vertex is at +0.69 m, along the second at -0.69 m.
    reaching, short = (-2.0, 0.8), (-2.0, 0.4)
    assert double_echoes(measurements, first, second, (reaching, (-0.8, 2.0))).max() > NO_ECHO
    assert double_echoes(measurements, first, second, (short, (-0.8, 2.0))).max() == NO_ECHO
    # A convex edge: both walls lead away from the sensor.
    assert double_echoes(measurements, first, second, ((0.6, 2.0), (-2.0, -0.6))).max() == NO_ECHO


@pytest.mark.parametrize(("begin", "is_detected"), [(-0.3, True), (0.3, False)])
def test_a_vertex_returns_sound_if_a_wall_extends_before_the_other_one(begin: float, *, is_detected: bool) -> None:
    # The line continues far behind the second wall; before it, it has 1 m, or no more than the extrapolation of a wall.
    measurements, (first, second) = one_ping((0.0, 0.0), 0.0), corner(92.0, 1.0)
    log_densities = double_echoes(measurements, first, second, ((begin, 5.0), (-0.8, 2.0)))
    assert (log_densities.max() > NO_ECHO) == is_detected


def test_double_echoes_have_the_range_walk_of_their_signal_excess() -> None:
    measurements, depth = one_ping((-1.5, -1.4), 0.7), np.hypot(2.5, 2.2)
    walking = ghosts_of_walls(measurements, SONAR.tabulated(), (EAST, NORTH), (ENDLESS, ENDLESS), NOISE)
    assert likeliest(measurements, double_echoes(measurements, EAST, NORTH)) == pytest.approx(depth, abs=1e-4)
    assert depth + 0.001 < likeliest(measurements, walking) < depth + SONAR.walk_gain


def test_short_readings_are_scaled_before_multipath_explains_them() -> None:
    measurements = one_ping((0.2, 0.1), 0.7188)
    log_densities = ghosts_of_walls(
        measurements, replace(PLAIN, range_scale=0.05).tabulated(), (EAST, NORTH), (ENDLESS, ENDLESS), NOISE
    )
    assert likeliest(measurements, log_densities) == pytest.approx(np.hypot(0.8, 0.7) / 1.05, abs=1e-4)


def over_cylinder(place: tuple[float, float], reflector: FloatArray, disc: tuple[float, float, float]) -> float:
    """Return the length of the shortest path over a cylinder and a wall and back, by minimisation over the cylinder."""
    start, center = np.array(place), np.array(disc[:2])
    depth = reflector[2] - start @ directions(reflector[1])
    image = start + 2 * depth * directions(reflector[1])
    facing = float(np.arctan2(*(start - center)[::-1]))

    def way(angle: float) -> float:
        spot = center + disc[2] * directions(angle)
        return length(start, spot, image)

    return float(
        minimize_scalar(way, bounds=(facing - 1.5, facing + 1.5), method="bounded", options={"xatol": 1e-10}).fun
    )


@pytest.mark.parametrize("radius", [0.02, 0.05, 0.12])
@pytest.mark.parametrize("center", [(0.5, 1.0), (-0.4, 1.4), (0.2, -1.2)])
def test_the_echo_over_a_wall_and_a_cylinder_takes_the_shortest_path(
    radius: float, center: tuple[float, float]
) -> None:
    measurements = one_ping((0.0, 0.0), float(np.arctan2(center[1], center[0] + 0.5)))
    log_densities = ghosts_of_cylinder(
        (measurements, PLAIN.tabulated()), EAST, cylinder(center[0], center[1], radius), NOISE
    )
    shortest = over_cylinder((0.0, 0.0), EAST, (*center, radius))
    assert likeliest(measurements, log_densities) == pytest.approx(shortest / 2, abs=1e-4)


def test_the_echo_over_a_wall_and_a_cylinder_has_the_predicted_excess() -> None:
    center, radius, bearing = np.array([-0.3, 1.5]), 0.1, 1.3
    measurements = one_ping((0.0, 0.0), bearing)
    log_densities = ghosts_of_cylinder(
        (measurements, PLAIN.tabulated()), wall(0.0, 0.6), cylinder(-0.3, 1.5, radius), NOISE
    )
    image = np.array([1.2 - center[0], center[1]])
    near, far = np.hypot(*center), np.hypot(*image)
    incidence = (np.arctan2(*center[::-1]) - np.arctan2(*image[::-1])) / 2
    amplitude = 2 * bistatic_cylinder_echo(near - radius, far - radius, radius, incidence=incidence)
    offs = [np.arctan2(*way[::-1]) - bearing for way in (center, image)]
    beams = np.prod([directivity(off, PLAIN.ka) for off in offs])
    excess = float(signal_excess(amplitude, near + far - 2 * radius, transducer=PAPER, air=Air(), beams=beams))
    truth = np.log(chance(excess) / (np.sqrt(2 * np.pi) * 2 * NOISE))
    assert log_densities.max() == pytest.approx(truth, abs=1.0)


def test_a_sensor_behind_the_wall_detects_no_echo_over_a_cylinder() -> None:
    measurements = one_ping((1.5, 0.0), 1.5)
    log_densities = ghosts_of_cylinder((measurements, PLAIN.tabulated()), EAST, cylinder(0.5, 1.0, 0.05), NOISE)
    assert (log_densities == NO_ECHO).all()


@pytest.mark.parametrize("walls", [(EAST, NORTH), (EAST, OBLIQUE)])
def test_adding_double_echoes_keeps_better_explanations(walls: tuple[FloatArray, FloatArray]) -> None:
    detected = one_ping((0.2, 0.1), 0.7), PLAIN.tabulated()
    alone = ghosts_of_walls(*detected, walls, (ENDLESS, ENDLESS), NOISE)
    known = np.where(np.arange(len(alone)) % 2, 0.0, NO_ECHO)
    add_ghosts_of_walls(log_densities := known.copy(), detected, walls, (ENDLESS, ENDLESS), NOISE)
    assert alone.max() > 0.0
    assert log_densities.tolist() == np.maximum(alone, known).tolist()


def test_adding_echoes_over_a_cylinder_keeps_better_explanations() -> None:
    detected, post = (one_ping((0.0, 0.0), 1.1), PLAIN.tabulated()), cylinder(0.5, 1.0, 0.05)
    alone = ghosts_of_cylinder(detected, EAST, post, NOISE)
    known = np.where(np.arange(len(alone)) % 2, 0.0, NO_ECHO)
    add_ghosts_of_cylinder(log_densities := known.copy(), detected, EAST, post, NOISE)
    assert alone.max() > 0.0
    assert log_densities.tolist() == np.maximum(alone, known).tolist()

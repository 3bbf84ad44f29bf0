import math
from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics import Air, directivity, signal_excess, two_way_loss, wavenumber, wedge_coefficient
from echoplan.acoustics.detection import crossing_delay, peak_delay
from echoplan.acoustics.predicted_echo import (
    SILENCE,
    EchoModel,
    Kind,
    Ping,
    bistatic_excess_of,
    differentiate,
    echo_geometry,
    excess_of,
    predict_echo,
    shape_of,
    walk_of,
)
from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.model import Transducer
from helpers.expectations import corner, cylinder, edge, wall
from helpers.simulated_worlds import HC_SR04, PAPER

AIR = Air()
SKEWED = EchoModel(
    figure_of_merit=33.0,
    ka=4.1,
    absorption=1.3,
    walk=EchoModel.of(PAPER).walk,
    walk_gain=0.026,
    range_offset=0.004,
    range_scale=0.02,
)


def ping(x: float, y: float, bearing: float) -> Ping:
    """A sensor that looks somewhere."""
    return x, y, float(np.cos(bearing)), float(np.sin(bearing))


def reflectors(kind: Kind, count: int, *, seed: int) -> FloatArray:
    """Reflectors of a kind, 0.3 to 3 m from the origin, all around it; round walls about it."""
    rng = np.random.default_rng(seed)
    ways, depths, radii = rng.uniform(-np.pi, np.pi, count), rng.uniform(0.3, 3.0, count), rng.uniform(0.01, 0.2, count)
    if kind is Kind.WALL:
        return np.column_stack([np.full(count, kind), ways, depths, np.zeros(count)])
    if kind is Kind.EDGE:
        depths = 0.15 * depths
    if kind is Kind.ROUND:
        return np.column_stack([np.full(count, kind), 0.3 * np.cos(ways), 0.3 * np.sin(ways), 0.5 + 0.5 * depths])
    reach = depths + radii if kind is Kind.CYLINDER else depths
    round_ = radii if kind is Kind.CYLINDER else np.zeros(count)
    return np.column_stack([np.full(count, kind), reach * np.cos(ways), reach * np.sin(ways), round_])


def toward(reflector: FloatArray) -> float:
    """Direction from the origin to a reflector: the nearest point of a large round wall, the farthest of a small."""
    if reflector[0] == Kind.ROUND and reflector[3] > 1.2:
        return float(np.arctan2(-reflector[2], -reflector[1]))
    return float(reflector[1] if reflector[0] == Kind.WALL else np.arctan2(reflector[2], reflector[1]))


def written_out(model: EchoModel, reflector: FloatArray, place: tuple[float, float, float]) -> tuple[float, ...]:
    """Depth, excess and reading, by the formulas alone."""
    kind, a, b, radius = reflector
    x, y, bearing = place
    if kind == Kind.WALL:
        depth, way, strength = b - np.cos(a) * x - np.sin(a) * y, a, 0.0
    elif kind == Kind.ROUND:
        away, ahead = np.hypot(a - x, b - y), np.cos(bearing) * (a - x) + np.sin(bearing) * (b - y) > 0.0
        depth, strength = radius + away if ahead else radius - away, 0.0
        way = np.arctan2(b - y, a - x) if ahead else np.arctan2(y - b, x - a)
    else:
        depth, way = np.hypot(a - x, b - y) - radius, np.arctan2(b - y, a - x)
        strength = {
            Kind.CYLINDER: 10 * np.log10(radius / (radius + depth)) if radius else 0.0,
            Kind.CORNER: 0.0,
            Kind.EDGE: -36.0 - 10 * np.log10(depth),
        }[Kind(int(kind))]
    beam = -two_way_loss(wrap(bearing - way), model.ka)
    excess = model.figure_of_merit - 20 * np.log10(2 * depth) - 2 * model.absorption * depth + beam + strength
    curve = model.walk.blurred(model.excess_scale)
    walk = model.walk_gain * (curve(excess) - curve(model.reference_excess))
    return float(depth), float(excess), float(depth + model.range_offset + walk)


@pytest.mark.parametrize("kind", list(Kind))
def test_a_predicted_echo_is_what_the_formulas_say(kind: Kind) -> None:
    rng, tables = np.random.default_rng(5), SKEWED.tabulated()
    for reflector in reflectors(kind, 60, seed=int(kind)):
        x, y = rng.uniform(-0.02, 0.02, 2)
        bearing = toward(reflector) + rng.uniform(-0.7, 0.7)
        depth, excess, reading = written_out(SKEWED, reflector, (x, y, bearing))
        found = predict_echo(tables, shape_of(reflector), ping(x, y, bearing))
        assert found[0] == pytest.approx(depth, abs=1e-9)
        assert found[1] == pytest.approx(excess, abs=1e-3)
        assert found[2] == pytest.approx(reading, abs=1e-6)


@pytest.mark.parametrize("kind", list(Kind))
def test_derivatives_are_those_of_the_reading(kind: Kind) -> None:
    rng, tables, step, jacobian = np.random.default_rng(7), SKEWED.tabulated(), 1e-7, np.empty(8)
    loud = 0
    for reflector in reflectors(kind, 120, seed=10 + int(kind)):
        unknowns = np.array([*reflector[1:], *rng.uniform(-0.02, 0.02, 2), toward(reflector) + rng.uniform(-0.9, 0.9)])

        def reading(values: FloatArray, kind: Kind = kind) -> float:
            shape = shape_of(np.array([kind, *values[:3]]))
            return predict_echo(tables, shape, ping(*values[3:]))[2]

        excess = differentiate(tables, shape_of(reflector), ping(*unknowns[3:]), jacobian)[1]
        moved = step * np.eye(6)
        differences = np.array([(reading(unknowns + way) - reading(unknowns - way)) / (2 * step) for way in moved])
        free = [0, 1, 2, 3, 4, 5] if kind in (Kind.CYLINDER, Kind.ROUND) else [0, 1, 3, 4, 5]
        assert jacobian[free] == pytest.approx(differences[free], abs=1e-5)
        by_level, by_width = louder(reflector, ping(*unknowns[3:]))
        assert jacobian[6] == pytest.approx(by_level, abs=1e-6)
        assert jacobian[7] == pytest.approx(by_width, rel=0.01, abs=1e-4)
        loud += excess > 0.0
    assert loud > 40


def louder(reflector: FloatArray, place: Ping, step: float = 1e-4) -> list[float]:
    """How the reading changes with the level of the echo and the logarithm of ka."""
    shape, tables, merit = shape_of(reflector), SKEWED.tabulated(), SKEWED.figure_of_merit
    pairs = [
        [tables._replace(figure_of_merit=merit + way) for way in (step, -step)],
        [replace(SKEWED, ka=SKEWED.ka * math.exp(way)).tabulated() for way in (step, -step)],
    ]
    readings = np.array([[predict_echo(each, shape, place)[2] for each in pair] for pair in pairs])
    return [float(one - other) / (2 * step) for one, other in readings]


@pytest.mark.parametrize("kind", list(Kind))
def test_derivatives_come_with_the_same_depth_and_excess(kind: Kind) -> None:
    tables, jacobian = SKEWED.tabulated(), np.empty(8)
    for reflector in reflectors(kind, 10, seed=3):
        place = ping(0.01, -0.02, toward(reflector) + 0.2)
        assert differentiate(tables, shape_of(reflector), place, jacobian) == pytest.approx(
            predict_echo(tables, shape_of(reflector), place)[:2]
        )


def test_an_echo_below_the_threshold_changes_its_reading_with_the_depth_alone() -> None:
    faint, jacobian = EchoModel.of(PAPER).tabulated(), np.empty(8)
    _, excess = differentiate(faint, shape_of(wall(0.0, 5.5)), ping(0.0, 0.0, 0.6), jacobian)
    assert excess < 0.0
    assert jacobian == pytest.approx([0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("transducer", [PAPER, HC_SR04])
@pytest.mark.parametrize("depth", [0.1, 0.5, 1.0, 3.0])
def test_the_excess_of_an_aimed_plane_is_that_of_the_sonar_equation(transducer: Transducer, depth: float) -> None:
    excess = predict_echo(EchoModel.of(transducer).tabulated(), shape_of(wall(0.3, depth)), ping(0.0, 0.0, 0.3))[1]
    truth = signal_excess(1 / (2 * depth), 2 * depth, transducer=transducer, air=AIR)
    assert excess == pytest.approx(float(truth), abs=1e-6)


@pytest.mark.parametrize("degrees", [5.0, 15.0, 25.0, 35.0])
def test_off_the_axis_an_echo_fades_by_the_beam_on_the_way_out_and_back(degrees: float) -> None:
    model, off = EchoModel.of(PAPER), np.radians(degrees)
    truth = signal_excess(0.25, 4.0, transducer=PAPER, air=AIR, beams=directivity(off, model.ka) ** 2)
    for side in (off, -off):
        excess = predict_echo(model.tabulated(), shape_of(wall(0.0, 2.0)), ping(0.0, 0.0, side))[1]
        assert excess == pytest.approx(float(truth), abs=1e-3)


def test_the_echo_of_a_right_angled_edge_is_as_faint_as_diffraction_makes_it() -> None:
    depth, half = 1.0, 0.75 * np.pi
    coefficient = wedge_coefficient(
        half,
        half,
        opening=1.5 * np.pi,
        wavenumber=wavenumber(40_000.0, AIR.speed_of_sound),
        distance_parameter=depth / 2,
    )
    amplitude = abs(coefficient) / np.sqrt(2 * depth) / depth
    strength = echo_geometry(shape_of(edge(depth, 0.0)), ping(0.0, 0.0, 0.0))[4]
    assert strength == pytest.approx(20 * np.log10(float(amplitude) * 2 * depth), abs=2.0)


def test_a_corner_returns_as_much_as_a_plane_and_a_thick_cylinder_nearly_so() -> None:
    tables, place = EchoModel.of(PAPER).tabulated(), ping(0.0, 0.0, 0.0)
    plane = predict_echo(tables, shape_of(wall(0.0, 1.0)), place)[1]
    assert predict_echo(tables, shape_of(corner(1.0, 0.0)), place)[1] == pytest.approx(plane)
    assert predict_echo(tables, shape_of(cylinder(101.0, 0.0, 100.0)), place)[1] == pytest.approx(plane, abs=0.05)
    assert predict_echo(tables, shape_of(cylinder(1.1, 0.0, 0.1)), place)[1] == pytest.approx(plane - 10.414, abs=0.01)


def test_a_cylinder_without_a_radius_is_as_loud_as_a_thin_one() -> None:
    tables, place = EchoModel.of(PAPER).tabulated(), ping(0.0, 0.0, 0.0)
    none, thin = (predict_echo(tables, shape_of(cylinder(1.0, 0.0, radius)), place)[1] for radius in (0.0, 1e-3))
    assert none == pytest.approx(thin, abs=0.02)


def test_no_echo_is_predicted_beyond_75_degrees() -> None:
    tables, place = EchoModel.of(PAPER).tabulated(), ping(0.0, 0.0, 0.0)
    for degrees, silent in [(74.9, False), (75.1, True), (180.0, True)]:
        excess = excess_of(tables, echo_geometry(shape_of(wall(np.radians(degrees), 1.0)), place))
        assert (excess == SILENCE) == silent


def test_beyond_the_first_null_the_beam_is_no_louder_than_in_it() -> None:
    tables = EchoModel.of(HC_SR04).tabulated()
    assert (np.diff(tables.beam) <= 0.0).all()
    # A louder transducer shows side lobes below 75 degrees; they are levelled, not cut off.
    wide = EchoModel.of(Transducer(piston_radius=0.012)).tabulated()
    place = ping(0.0, 0.0, 0.0)
    walls = [shape_of(wall(angle, 1.0)) for angle in np.radians([40.0, 50.0, 60.0])]
    excesses = [excess_of(wide, echo_geometry(shape, place)) for shape in walls]
    assert excesses == sorted(excesses, reverse=True)
    assert excesses[-1] > SILENCE


@pytest.mark.parametrize("radius", [0.0062, 0.008, 0.012])
def test_lobes_are_as_loud_as_the_loudest_at_or_beyond_an_angle(radius: float) -> None:
    model, place = EchoModel.of(Transducer(piston_radius=radius)), ping(0.0, 0.0, 0.0)
    tables, angles = model.tabulated(), np.radians(np.arange(0.5, 88.0, 2.5))
    plain = predict_echo(tables, shape_of(wall(0.0, 1.0)), place)[1]
    for angle in angles:
        beyond = -two_way_loss(np.linspace(angle, np.pi / 2, 4000), model.ka)
        heading = float(np.cos(angle)), float(np.sin(angle))
        geometry = echo_geometry(shape_of(wall(angle, 1.0)), place)
        excess = bistatic_excess_of(tables, 1.0, heading, heading, 0.0)
        assert excess == pytest.approx(plain + max(beyond.max(), -80.0), abs=0.2)
        assert excess >= excess_of(tables, geometry) - 1e-9
        # Half of the loss is at departure, half at arrival.
        halfway = bistatic_excess_of(tables, 1.0, (1.0, 0.0), heading, -3.0)
        assert halfway == pytest.approx(0.5 * (plain + excess) - 3.0, abs=1e-9)


def test_behind_a_sensor_there_is_silence() -> None:
    tables = EchoModel.of(PAPER).tabulated()
    ahead, behind = (1.0, 0.0), (-0.9, 0.436)
    for leaving, coming in ((ahead, behind), (behind, ahead)):
        assert bistatic_excess_of(tables, 1.0, leaving, coming, 0.0) == SILENCE


def test_at_the_face_of_a_sensor_echoes_do_not_grow_without_bound() -> None:
    tables = EchoModel.of(PAPER).tabulated()
    near, nearer = (predict_echo(tables, shape_of(wall(0.0, depth)), ping(0.0, 0.0, 0.0))[1] for depth in (0.02, 1e-9))
    assert nearer == pytest.approx(near)


def test_a_maker_sets_a_module_right_on_an_aimed_plane_at_one_metre() -> None:
    for transducer in (PAPER, HC_SR04):
        reading = predict_echo(EchoModel.of(transducer).tabulated(), shape_of(wall(0.0, 1.0)), ping(0.0, 0.0, 0.0))[2]
        assert reading == pytest.approx(1.0, abs=1e-9)


def test_offset_and_scale_of_readings_are_those_of_the_model() -> None:
    tables = SKEWED.tabulated()
    ranged = predict_echo(tables, shape_of(wall(0.0, 1.0)), ping(0.0, 0.0, 0.0))[2]
    assert ranged == pytest.approx(1.004)
    assert tables.scale == 1.02


@pytest.mark.parametrize("temperature", [0.0, 10.0, 28.0])
def test_the_absorption_of_air_follows_from_the_range_scale(temperature: float) -> None:
    air = Air(temperature=temperature)
    scaled = EchoModel.of(PAPER).scaled(air.speed_of_sound / Air().speed_of_sound - 1.0)
    assert scaled.absorption == pytest.approx(air.absorption(PAPER.frequency), rel=0.01)
    assert scaled.range_scale == pytest.approx(air.speed_of_sound / Air().speed_of_sound - 1.0)


def test_faint_echoes_are_read_too_long_and_loud_ones_too_short() -> None:
    tables = EchoModel.of(PAPER).tabulated()
    place = ping(0.0, 0.0, 0.0)
    far, near = (predict_echo(tables, shape_of(wall(0.0, depth)), place)[2] - depth for depth in (3.0, 0.2))
    assert far > 0.0 > near


def test_the_walk_runs_over_half_the_way_that_sound_goes_until_the_peak() -> None:
    model = replace(EchoModel.of(PAPER), excess_scale=0.0)
    tables = model.tabulated()
    assert model.walk_gain == pytest.approx(AIR.speed_of_sound * peak_delay(PAPER) / 2)
    delays = crossing_delay([0.0, 6.0, 70.0], PAPER)
    walks = [walk_of(tables, excess) for excess in (0.0, 6.0, 70.0)]
    assert np.diff(walks) == pytest.approx(AIR.speed_of_sound / 2 * np.diff(delays))


@pytest.mark.parametrize("excess", [-30.0, 0.0, 0.026, 7.77, 69.99, 70.0, 300.0])
def test_the_walk_is_read_from_its_curve(excess: float) -> None:
    tables = SKEWED.tabulated()
    walk = SKEWED.walk.blurred(SKEWED.excess_scale)
    curve = 0.004 + 0.026 * (walk(excess) - walk(SKEWED.reference_excess))
    assert walk_of(tables, excess) == pytest.approx(float(curve), abs=1e-9)


@pytest.mark.parametrize("sonar", [SKEWED, replace(SKEWED, range_offset=-0.01), SKEWED.as_ray_cone(0.25)])
def test_walks_are_the_least_and_the_greatest_of_the_curve(sonar: EchoModel) -> None:
    tables = sonar.tabulated()
    assert tables.walks == (tables.walk.min(), tables.walk.max())


def test_readings_scatter_as_their_excess_is_uncertain() -> None:
    sigmas = SKEWED.sigma_from_excess([0.0, 1.0, 30.0])
    assert sigmas == pytest.approx(0.026 * SKEWED.walk.sigma_from_excess([0.0, 1.0, 30.0], SKEWED.excess_scale))
    assert replace(SKEWED, excess_scale=0.0).sigma_from_excess(0.0) == 0.0


def test_a_reflector_is_seen_to_the_left_at_a_negative_sine() -> None:
    _, cosine, sine, _, _ = echo_geometry(shape_of(corner(1.0, 1.0)), ping(0.0, 0.0, 0.0))
    assert (cosine, sine) == pytest.approx((np.sqrt(0.5), -np.sqrt(0.5)))
    _, cosine, sine, _, _ = echo_geometry(shape_of(wall(np.pi / 4, 1.0)), ping(0.0, 0.0, 0.0))
    assert (cosine, sine) == pytest.approx((np.sqrt(0.5), -np.sqrt(0.5)))

import numpy as np
import pytest
from numpy.typing import ArrayLike

from echoplan.acoustics import (
    Air,
    cylinder_echo,
    directivity,
    edge_echo,
    piston_ka,
    plane_echo,
    signal_excess,
    strip_echo,
    wavenumber,
)
from echoplan.geometry import compose
from echoplan.model import Polyline, Rig, World
from echoplan.simulation import Simulation
from echoplan.simulation.detector import Echoes
from echoplan.simulation.echoes import find_echoes
from helpers import simulated_worlds
from helpers.twin import FLOOR, Twin

pytestmark = pytest.mark.slow

AIR = Air()
HALF = 0.5 * np.pi


def echoes_of(simulation: Simulation, pings: ArrayLike = (0,)) -> Echoes:
    stage, chosen = simulation._receivers.stage, np.array(pings, dtype=np.int64)
    return find_echoes(stage, chosen, stage.shots.deadlines[chosen])


def levels(simulation: Simulation) -> list[float]:
    """Levels of the echoes of the first ping over the threshold [dB], in the order of time."""
    echoes = echoes_of(simulation)
    return [float(20 * np.log10(abs(echoes.strengths[each]))) for each in np.argsort(echoes.times)]


def total(simulation: Simulation) -> float:
    """Level of the sum of all echoes of the first ping, as if none were late [dB]."""
    return float(20 * np.log10(abs(echoes_of(simulation).strengths.sum())))


def excess(amplitude: ArrayLike, length: float) -> float:
    return float(signal_excess(amplitude, length, transducer=simulated_worlds.HC_SR04, air=AIR))


@pytest.mark.parametrize(
    ("using", "settings"),
    [
        (simulated_worlds.array(), {}),
        (simulated_worlds.array(), {"crosstalk": False, "second_time_around": False}),
        (simulated_worlds.array(), {"reflection_order": 1, "diffraction": False}),
        (
            simulated_worlds.rig(
                simulated_worlds.sensor(x=0.1),
                transducer=simulated_worlds.HC_SR04,
                servo=simulated_worlds.turning(-90, 90, 7),
            ),
            {},
        ),
    ],
    ids=["all", "own bursts", "mirrors", "one sensor"],
)
def test_the_machine_code_finds_the_echoes_of_its_reference(using: Rig, settings: dict[str, bool]) -> None:
    poses = [[0.9, 1.5, 0.3], [3.6, 1.9, 2.0], [2.3, 0.8, -1.2]]
    simulation = simulated_worlds.simulation(simulated_worlds.room(), using=using, poses=poses, **settings)
    twin = Twin(simulation)
    rng = np.random.default_rng(5)
    pings = rng.choice(len(simulation._schedule.sensors), 12, replace=False)
    echoes = echoes_of(simulation, pings)
    assert len(echoes.times) > 20
    for number, ping in enumerate(pings):
        times, strengths = twin.echoes(int(ping))
        own = np.arange(echoes.bounds[number], echoes.bounds[number + 1])
        own = own[abs(echoes.strengths[own]) >= FLOOR]
        own = own[np.argsort(echoes.times[own])]
        np.testing.assert_allclose(echoes.times[own], times, rtol=0, atol=1e-12)
        np.testing.assert_allclose(echoes.strengths[own], strengths, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("distance", [0.2, 1.0, 3.0])
def test_a_plane_echoes_by_its_law_and_on_time(distance: float) -> None:
    simulation = simulated_worlds.simulation(simulated_worlds.wall(distance))
    echoes = echoes_of(simulation)
    assert echoes.times.tolist() == pytest.approx([2 * distance / AIR.speed_of_sound])
    assert levels(simulation) == pytest.approx([excess(plane_echo(distance), 2 * distance)], abs=1e-6)
    assert echoes.reflectors.tolist() == [0]


def test_a_sensor_that_turns_receives_off_its_axis_what_it_sent_on_it() -> None:
    # 400 degrees a second: while sound flies 6 m the axis turns by 7 degrees.
    rig = simulated_worlds.rig(servo=simulated_worlds.turning(0, 90, 10), period=0.025)
    simulation = simulated_worlds.simulation(simulated_worlds.wall(3.0), using=rig, second_time_around=False)
    turned = np.radians(400.0) * 6.0 / AIR.speed_of_sound
    assert np.degrees(turned) == pytest.approx(7.0, abs=0.05)
    beam = directivity(turned, piston_ka(simulated_worlds.HC_SR04, AIR))
    law = signal_excess(plane_echo(3.0), 6.0, transducer=simulated_worlds.HC_SR04, air=AIR, beams=beam)
    assert levels(simulation) == pytest.approx([float(law)], abs=0.01)


@pytest.mark.parametrize("radius", [0.05, 0.3])
def test_a_cylinder_echoes_by_its_law(radius: float) -> None:
    simulation = simulated_worlds.simulation(simulated_worlds.pillar(1.0, radius))
    assert levels(simulation) == pytest.approx([excess(cylinder_echo(1.0, radius), 2.0)], abs=1e-6)


@pytest.mark.parametrize("turn", [0.0, 0.3, 2.2, -1.9])
@pytest.mark.parametrize("place", [(1.1, 0.8), (0.3, 2.0)])
def test_a_right_angle_echoes_as_loudly_as_a_plane(place: tuple[float, float], turn: float) -> None:
    # Two paths share the image in the vertex, wherever the corner stands and however the numbers round.
    frame = np.array([0.1, -0.7, turn])
    corner = simulated_worlds.moved(simulated_worlds.world([[0.0, 9.0], [0.0, 0.0], [9.0, 0.0]]), frame)
    aimed = np.array([*place, np.arctan2(place[1], place[0]) + np.pi])
    simulation = simulated_worlds.simulation(corner, poses=[compose(frame, aimed)])
    echoes, away = echoes_of(simulation), float(np.hypot(*place))
    in_vertex = np.isclose(echoes.times, 2 * away / AIR.speed_of_sound, rtol=1e-9)
    level = float(20 * np.log10(abs(echoes.strengths[in_vertex].sum())))
    assert level == pytest.approx(excess(plane_echo(away), 2 * away), abs=0.01)


def corner_level(degrees: float) -> float:
    """Level of a corner's double bounce, seen from its bisector 1.5 m away, against that of a plane [dB]."""
    away, angle = 1.5, np.radians(degrees)
    corner = simulated_worlds.world(np.array([[9, 0], [0, 0], [9 * np.cos(angle), 9 * np.sin(angle)]]))
    pose = [away * np.cos(angle / 2), away * np.sin(angle / 2), angle / 2 + np.pi]
    echoes = echoes_of(simulated_worlds.simulation(corner, poses=[pose]))
    late = echoes.times > 1.8 * away / AIR.speed_of_sound
    return float(20 * np.log10(abs(echoes.strengths[late].sum()))) - excess(plane_echo(away), 2 * away)


def test_a_corner_fades_without_a_jump_as_it_opens() -> None:
    # An acute corner returns both of its double bounces, a blunt one only what is diffracted.
    angles = np.concatenate([np.linspace(86.0, 96.0, 101), [90 - 1e-4, 90 - 1e-10, 90 + 1e-10, 90 + 1e-4]])
    found = np.array([corner_level(angle) for angle in np.sort(angles)])
    assert np.abs(np.diff(found)).max() < 0.5
    assert corner_level(90.0) == pytest.approx(0.0, abs=0.01)
    assert corner_level(88.0) == pytest.approx(6.5, abs=0.5)
    blunt = found[np.sort(angles) >= 90]
    assert (np.diff(blunt) <= 0.01).all()
    assert blunt[-1] == pytest.approx(-16.3, abs=0.5)


@pytest.mark.parametrize(("distance", "level"), [(0.3, -31.0), (1.0, -36.0)])
def test_the_edge_of_a_box_echoes_by_diffraction_alone(distance: float, level: float) -> None:
    box = simulated_worlds.world(np.add([[0, 0], [2, 2], [4, 0], [2, -2]], [distance, 0.0]), closed=True)
    simulation = simulated_worlds.simulation(box)
    found = total(simulation) - excess(plane_echo(distance), 2 * distance)
    assert found == pytest.approx(level, abs=0.5)
    k = wavenumber(40_000.0, AIR.speed_of_sound)
    law = np.abs(edge_echo(distance, angle=0.75 * np.pi, opening=1.5 * np.pi, wavenumber=k))
    assert found == pytest.approx(float(20 * np.log10(law / plane_echo(distance))), abs=0.01)


@pytest.mark.parametrize("distance", [0.3, 1.0, 2.3])
def test_a_strip_echoes_by_the_law_of_strips_though_it_is_a_mirror_with_two_ends(distance: float) -> None:
    width = 0.0254
    strip = simulated_worlds.world([[distance, -width / 2], [distance, width / 2]])
    wavelength = AIR.speed_of_sound / 40_000.0
    law = strip_echo(distance, width, wavelength=wavelength)
    assert total(simulated_worlds.simulation(strip)) == pytest.approx(excess(law, 2 * distance), abs=0.1)


def test_the_echo_of_a_wall_fades_past_its_end_without_a_jump() -> None:
    shifts = np.concatenate([np.linspace(-0.2, 0.2, 201), [-1e-12, 0.0, 1e-12]])
    walls = [
        total(simulated_worlds.simulation(simulated_worlds.world([[1.0, shift], [1.0, 30.0]])))
        for shift in np.sort(shifts)
    ]
    assert np.abs(np.diff(walls)).max() < 1.0
    assert walls[0] == pytest.approx(excess(plane_echo(1.0), 2.0), abs=0.3)
    assert walls[len(walls) // 2] == pytest.approx(excess(plane_echo(1.0), 2.0) - 6.0, abs=0.3)
    assert walls[-1] < walls[0] - 20


def test_a_bend_of_no_angle_is_no_edge() -> None:
    straight, bent = simulated_worlds.wall(1.0), simulated_worlds.world([[1.0, -20.0], [1.0, 0.0], [1.0, 20.0]])
    assert total(simulated_worlds.simulation(bent)) == pytest.approx(
        total(simulated_worlds.simulation(straight)), abs=1e-9
    )


def test_what_stands_in_the_way_hides_what_is_behind() -> None:
    shield = simulated_worlds.world([[0.5, -0.3], [0.5, 0.3]], [[1.0, -0.1], [1.0, 0.1]])
    assert set(echoes_of(simulated_worlds.simulation(shield)).reflectors.tolist()) == {0, -1}
    post = simulated_worlds.world([[1.0, -9.0], [1.0, 9.0]], pillars=[(0.5, 0.0, 0.05)])
    assert 0 not in echoes_of(simulated_worlds.simulation(post)).reflectors


def test_soft_faces_return_less() -> None:
    hard = simulated_worlds.wall(1.0)
    soft = World(name="soft", polylines=(Polyline(points_xy=np.array([[1, -9], [1, 9]]), material="foam"),))
    loss = levels(simulated_worlds.simulation(hard))[0] - levels(simulated_worlds.simulation(soft))[0]
    assert loss == pytest.approx(-10 * np.log10(0.05))


def test_echoes_go_round_by_a_wall_and_a_cylinder_both_ways() -> None:
    # A cylinder ahead and a wall to the left: sensor - wall - cylinder - sensor, and back.
    world = simulated_worlds.world([[-3.0, 0.5], [3.0, 0.5]], pillars=[(1.0, 0.0, 0.1)])
    echoes = echoes_of(simulated_worlds.simulation(world, poses=[[0.0, 0.0, np.radians(20)]]))
    pairs = np.flatnonzero((echoes.reflectors == -1) & (echoes.times * AIR.speed_of_sound < 2.5))
    both = pairs[np.isclose(echoes.times[pairs], echoes.times[pairs].min(), atol=1e-12)]
    assert len(both) == 2
    assert echoes.strengths[both[0]] == pytest.approx(echoes.strengths[both[1]])
    image = np.hypot(1.0, 1.0)
    longest = (image - 0.1) + 0.9
    assert echoes.times[both[0]] * AIR.speed_of_sound == pytest.approx(longest, abs=0.06)


@pytest.mark.parametrize(
    ("pose", "world"),
    [
        ([1.0, 0.0, HALF], simulated_worlds.wall(1.0)),
        ([1.0, 30.0, 0.0], simulated_worlds.wall(1.0)),
        ([1.0, 20.0, 0.0], simulated_worlds.wall(1.0)),
        ([0.0, 0.0, 0.0], simulated_worlds.world([[0.0, 9.0], [0.0, 0.0], [9.0, 0.0]])),
        ([0.0, 1.0, 0.0], simulated_worlds.world([[0.0, 9.0], [0.0, 0.0], [9.0, 0.0]])),
        ([1.0, 0.0, 0.0], simulated_worlds.pillar(0.95, 0.2)),
        ([0.0, 0.0, 0.0], simulated_worlds.pillar(0.0, 0.2)),
        ([-1.0, 0.2, 0.0], simulated_worlds.pillar(0.5, 0.2)),
        ([0.0, 0.0, 0.0], simulated_worlds.world()),
        ([0.5, 0.5, 0.1], simulated_worlds.world([[0.0, 0.0], [1.0, 0.0], [0.5, 0.5 + 1e-10]], closed=True)),
    ],
    ids=[
        "on a wall",
        "on its line",
        "at its end",
        "in a vertex",
        "on a face of a corner",
        "in a cylinder",
        "on a cylinder",
        "at its tangent",
        "nowhere",
        "at a hair from a vertex",
    ],
)
def test_no_pose_gives_readings_that_are_nan(pose: list[float], world: World) -> None:
    simulation = simulated_worlds.simulation(world, using=simulated_worlds.array(), poses=[pose])
    assert not np.isnan(simulated_worlds.readings(simulation)).any()
    assert np.isfinite(echoes_of(simulation, range(90)).strengths).all()

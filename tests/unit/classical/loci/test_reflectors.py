import numpy as np
import pytest

from echoplan.classical.loci import (
    Loci,
    Reflector,
    ReflectorKind,
    VoteSettings,
    echo_points,
    find_reflectors,
    observations_of_reflector,
)
from helpers import arcs

WALL, OTHER = (0.3, 2.011), (1.9, 1.5)
POINT = (-1.51, -1.02)
STATIONS = [(0.0, 0.0), (0.3, 0.9), (0.5, -0.8), (1.1, 0.2)]
TURNS = (-0.2, 0.0, 0.2)
SETTINGS = VoteSettings()
DEGREES = np.array([0.0, 0.0, 1.0])


def scene() -> Loci:
    parts = [arcs.on_wall(line, STATIONS, turns=TURNS) for line in (WALL, OTHER)]
    return Loci.joined([*parts, arcs.on_point(POINT, STATIONS, turns=TURNS)])


def test_lines_and_points_share_the_echoes_out_among_them() -> None:
    reflectors = find_reflectors(scene(), SETTINGS)
    kinds = sorted(reflector.kind.value for reflector in reflectors)
    assert kinds == ["line", "line", "point"]
    members = np.concatenate([reflector.members for reflector in reflectors])
    assert sorted(members.tolist()) == list(range(36))


def test_reflectors_are_fitted_to_all_their_echoes() -> None:
    reflectors = find_reflectors(scene(), SETTINGS)
    lines = sorted(tuple(each.parameters) for each in reflectors if each.kind is ReflectorKind.LINE)
    (point,) = [each.parameters for each in reflectors if each.kind is ReflectorKind.POINT]
    assert np.array(lines) == pytest.approx(np.array([WALL, OTHER]), abs=1e-6)
    assert point == pytest.approx(POINT, abs=1e-6)


def test_noise_of_a_step_parts_no_wall() -> None:
    rng = np.random.default_rng(2)
    loci = arcs.on_wall(WALL, STATIONS, turns=np.linspace(-0.3, 0.3, 30).tolist())
    rough = Loci(
        centers_xy=loci.centers_xy,
        ranges=loci.ranges + rng.uniform(-0.005, 0.005, len(loci)),
        bearings=loci.bearings,
        half_apertures=loci.half_apertures,
        sweeps=loci.sweeps,
    )
    (wall,) = find_reflectors(rough, SETTINGS)
    assert len(wall.members) == 120
    assert wall.parameters == pytest.approx(WALL, abs=2e-3)


def test_two_stations_are_too_few_for_a_reflector() -> None:
    loci = arcs.on_wall(WALL, STATIONS[:2], turns=TURNS)
    assert find_reflectors(loci, SETTINGS) == []
    assert len(find_reflectors(loci, VoteSettings(min_sweeps=2))) == 1


def test_each_sweep_observes_a_wall_once() -> None:
    loci = arcs.on_wall(WALL, STATIONS, turns=TURNS)
    (wall,) = find_reflectors(loci, SETTINGS)
    observations = observations_of_reflector(wall, loci, degrees=DEGREES)
    assert [each.sweep for each in observations] == [0, 1, 2, 3]
    assert [each.pings for each in observations] == [3] * 4
    for each, station in zip(observations, STATIONS, strict=True):
        assert each.point.hub_xy == pytest.approx(station)
        assert each.point.bearing == pytest.approx(WALL[0])
        assert each.point.distance == pytest.approx(WALL[1] - np.dot(station, [np.cos(0.3), np.sin(0.3)]))
        assert np.sqrt(each.point.covariance[0, 0]) == pytest.approx(arcs.HALF_APERTURE / 3)


def test_echoes_come_from_where_the_reflector_touches_their_arcs() -> None:
    loci = arcs.on_wall(WALL, STATIONS, turns=TURNS)
    (wall,) = find_reflectors(loci, SETTINGS)
    assert echo_points(wall, loci) @ [np.cos(WALL[0]), np.sin(WALL[0])] == pytest.approx(WALL[1], abs=1e-6)
    post = Reflector(kind=ReflectorKind.POINT, parameters=np.array(POINT), members=np.arange(12))
    points = echo_points(post, arcs.on_point(POINT, STATIONS, turns=TURNS))
    assert points == pytest.approx(np.tile(POINT, (12, 1)))


def test_without_arcs_there_is_no_reflector() -> None:
    assert find_reflectors(arcs.nothing(), SETTINGS) == []

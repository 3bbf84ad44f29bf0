import numpy as np
import pytest

from echoplan.errors import UnknownNameError
from echoplan.model import Pillar, Polyline, World
from echoplan.simulation.scene import build_scene
from helpers import simulated_worlds

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])


def openings(world: World) -> list[float]:
    """Angles of the air before all edges that diffract [degrees], in order."""
    return sorted(np.degrees(build_scene(world).edges["opening"]).round(6).tolist())


def test_faces_and_cylinders_keep_their_order_and_size() -> None:
    scene = build_scene(simulated_worlds.room())
    ends = scene.faces["start"] + scene.faces["length"] * scene.faces["tangent"]
    expected = simulated_worlds.room().segments_xy
    np.testing.assert_allclose(np.column_stack([ends.real, ends.imag]), expected[:, 1])
    np.testing.assert_allclose(scene.discs["radius"], [0.1, 0.06])


def test_materials_become_reflection_coefficients() -> None:
    scene = build_scene(simulated_worlds.room())
    assert scene.faces["gain"][:5].tolist() == [1.0] * 5
    np.testing.assert_allclose(scene.faces["gain"][5:7], np.sqrt(0.93))
    np.testing.assert_allclose(scene.discs["gain"], [1.0, np.sqrt(0.95)])


def test_a_material_that_nobody_knows_is_refused() -> None:
    strange = World(name="w", polylines=(Polyline(points_xy=SQUARE, material="unobtainium"),))
    with pytest.raises(UnknownNameError, match="unobtainium"):
        build_scene(strange)
    strange = World(name="w", polylines=(), pillars=(Pillar(center_xy=np.zeros(2), radius=1.0, material="aether"),))
    with pytest.raises(UnknownNameError, match="aether"):
        build_scene(strange)


def test_a_box_diffracts_at_its_corners_on_the_outside_only() -> None:
    assert openings(simulated_worlds.world(SQUARE, closed=True)) == [270.0] * 4


def test_a_free_wall_diffracts_at_both_ends_as_half_planes() -> None:
    assert openings(simulated_worlds.wall(1.0)) == [360.0, 360.0]


def test_a_bend_diffracts_on_both_of_its_sides() -> None:
    bent = simulated_worlds.world([[-1.0, 0.0], [0.0, 0.0], [np.cos(np.radians(40)), np.sin(np.radians(40))]])
    assert openings(bent) == [140.0, 220.0, 360.0, 360.0]


def test_a_wall_goes_on_through_a_vertex_that_does_not_bend() -> None:
    assert openings(simulated_worlds.world([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]])) == [360.0, 360.0]


def test_where_the_material_changes_even_a_straight_wall_diffracts() -> None:
    first = Polyline(points_xy=np.array([[0.0, 0.0], [1.0, 0.0]]))
    second = Polyline(points_xy=np.array([[1.0, 0.0], [2.0, 0.0]]), material="carpet")
    assert openings(World(name="w", polylines=(first, second))) == [180.0, 180.0, 360.0, 360.0]


def test_polylines_that_share_a_vertex_are_welded() -> None:
    halves = simulated_worlds.world(SQUARE[:3], SQUARE[[2, 3, 0]])
    assert openings(halves) == openings(simulated_worlds.world(SQUARE, closed=True))


def test_a_wall_that_abuts_another_has_no_free_end_there() -> None:
    tee = simulated_worlds.world([[-1.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]])
    assert openings(tee) == [180.0 * 2] * 3
    slanted = simulated_worlds.world([[-1.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.6, 1.0]])
    assert len(openings(slanted)) == 4  # 59 degrees on one side stay silent, 121 on the other do not


def test_sharp_corners_stay_silent_within() -> None:
    sharp = simulated_worlds.world([[1.0, 0.0], [0.0, 0.0], [np.cos(np.radians(50)), np.sin(np.radians(50))]])
    assert openings(sharp) == [310.0, 360.0, 360.0]


def test_the_gains_of_an_edge_are_those_of_its_faces_counter_clockwise() -> None:
    soft = Polyline(points_xy=np.array([[1.0, 0.0], [0.0, 0.0]]), material="carpet")
    hard = Polyline(points_xy=np.array([[0.0, 0.0], [0.0, 1.0]]))
    edges = build_scene(World(name="w", polylines=(soft, hard))).edges
    outside = edges[np.isclose(edges["opening"], 1.5 * np.pi)][0]
    assert outside["first"] == pytest.approx(np.pi / 2)
    assert outside["first_gain"] == 1.0
    assert outside["second_gain"] == pytest.approx(np.sqrt(0.56))


def test_an_empty_world_is_an_empty_scene() -> None:
    scene = build_scene(simulated_worlds.world())
    assert [len(part) for part in (scene.faces, scene.discs, scene.edges, *scene.tree)] == [0] * 5

"""Boxes around faces change nothing but the time that the ray tracer takes."""

import tracemalloc

import numpy as np
import pytest

from echoplan.compiled import compiled
from echoplan.geometry import crosses_segments
from echoplan.model import Polyline, World
from echoplan.simulation import visibility
from echoplan.simulation.scene import Scene, build_scene

# Faces are records, whose fields have names in compiled functions only.
faces_within, is_blocked = compiled(visibility.faces_within), compiled(visibility.is_blocked)


def strewn(count: int, seed: int) -> World:
    """Short walls that lie about in a hall, in no order."""
    rng = np.random.default_rng(seed)
    starts = rng.uniform(0.0, 10.0, (count, 1, 2))
    ends = starts + rng.uniform(-1.0, 1.0, (count, 1, 2))
    walls = np.concatenate([starts, ends], axis=1)
    return World(name="strewn", polylines=tuple(Polyline(points_xy=wall) for wall in walls))


def ring(count: int) -> World:
    angles = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    points = np.column_stack([2.0 * np.cos(angles), 1.5 * np.sin(angles)])
    return World(name="ring", polylines=(Polyline(points_xy=points, closed=True),))


def as_complex(points_xy: np.ndarray) -> np.ndarray:
    return points_xy[..., 0] + 1j * points_xy[..., 1]


@pytest.mark.parametrize("count", [1, 4, 5, 300])
def test_a_way_is_blocked_by_any_of_many_faces(count: int) -> None:
    world = strewn(count, seed=count)
    ways = np.random.default_rng(1).uniform(0.0, 10.0, (500, 2, 2))
    expected = crosses_segments(ways[:, 0], ways[:, 1], world.segments_xy).any(axis=1)
    scene = build_scene(world)
    assert [is_blocked(scene, *as_complex(way)) for way in ways] == expected.tolist()


def reached(scene: Scene, face: int, image: complex, reach: float) -> list[int]:
    found = np.empty(len(scene.faces), np.int64)
    return [int(each) for each in found[: faces_within(scene, scene.faces[face], image, reach, found)]]


def test_the_faces_that_an_image_reaches_through_its_face_are_found_in_their_order() -> None:
    world = strewn(200, seed=3)
    scene = build_scene(world)
    image, face, reach = 5.0 + 5.0j, 17, 4.0
    start, end = world.segments_xy[face]
    shares = np.linspace(0.0, 1.0, 400)[:, None]
    through = start + shares * (end - start)
    away = through - [5.0, 5.0]
    far = [5.0, 5.0] + reach * away / np.hypot(*away.T)[:, None]
    met = crosses_segments(through + 1e-9 * away, far, world.segments_xy).any(axis=0)
    found = reached(scene, face, image, reach)
    assert found == sorted(found)
    assert set(np.flatnonzero(met)) <= set(found)
    assert met.sum() <= len(found) < 60


def test_in_a_ring_of_many_faces_an_image_reaches_few_through_one_of_them() -> None:
    scene = build_scene(ring(4000))
    start = complex(scene.faces["start"][100])
    assert len(reached(scene, 100, 1.2 * start, 10.0)) < 40
    assert len(reached(scene, 100, 1.2 * start, 0.1)) == 0


def test_an_image_on_its_face_reaches_all_faces() -> None:
    scene = build_scene(ring(20))
    assert reached(scene, 3, complex(scene.faces["start"][3]), 10.0) == list(range(20))


def test_the_memory_of_a_scene_grows_with_its_faces() -> None:
    tracemalloc.start()
    try:
        build_scene(ring(4000))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # A table of all edges and faces would take 128 MB.
    assert peak < 30e6

"""Occlusion by a body behind the wall x = 2 between y = -1 and y = 1."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.map_extraction.bodies import Bodies
from helpers.outlines import segment

FRONT = segment(0.0, 2.0, (-1.0, 1.0))
# The line y = 3 behind the body, seen from below it.
NORTH = np.array([np.pi / 2, 3.0])
NOWHERE = np.zeros((0, 2))


def occlusion_probability(
    bodies: Bodies, x: float, *, to: float | None = None, owner: int = 1, line: FloatArray = NORTH
) -> float:
    """Return the probability that the line of sight from (x, -3) to the line y = 3, at x or ``to``, is occluded."""
    places = np.array([-(x if to is None else to)])
    return float(bodies.hide(np.array([[x, -3.0]]), owner, line, places)[0])


def test_the_occlusion_by_a_body_decreases_behind_its_front() -> None:
    bodies = Bodies.behind([FRONT], NOWHERE)
    chances = [occlusion_probability(bodies, x) for x in (1.9, 2.001, 2.3, 3.0, 5.0)]
    assert chances[:2] == pytest.approx([0.0, 1.0], abs=0.01)
    assert chances[1:] == sorted(chances[1:], reverse=True)
    assert chances[-1] < 0.01


def test_a_line_of_sight_through_the_front_is_occluded_and_one_aside_is_not() -> None:
    bodies = Bodies.behind([FRONT], NOWHERE)
    assert occlusion_probability(bodies, 1.5, to=3.0) == pytest.approx(1.0)
    # Behind the line of the front only past its end.
    assert occlusion_probability(bodies, 1.5, to=2.2) == 0.0
    assert occlusion_probability(bodies, 0.0, to=1.9) == 0.0


def test_a_body_ends_before_the_path_of_the_robot() -> None:
    bodies = Bodies.behind([FRONT], np.array([[2.4, 0.0], [9.0, 5.0], [1.0, 0.0]]))
    assert occlusion_probability(bodies, 2.3) > 0.5
    assert occlusion_probability(bodies, 2.5) == 0.0


def test_a_body_ends_at_its_back() -> None:
    bodies = Bodies.behind([FRONT, segment(np.pi, -2.4, (-0.5, 0.5), owner=2)], NOWHERE)
    assert occlusion_probability(bodies, 2.3) == pytest.approx(1.0)
    assert occlusion_probability(bodies, 2.5) == 0.0


def test_a_wall_occludes_neither_itself_nor_what_it_faces() -> None:
    bodies = Bodies.behind([FRONT], NOWHERE)
    assert occlusion_probability(bodies, 2.3, owner=FRONT.owner) == 0.0
    # The line x = 2.6, detected from behind, may be the other face of the wall.
    back = np.array([np.pi, -2.6])
    assert bodies.hide(np.array([[3.0, 0.0]]), 1, back, np.array([0.0])).tolist() == [0.0]
    assert bodies.hide(np.array([[1.0, 0.0]]), 1, np.array([0.0, 2.6]), np.array([0.0])).tolist() == [1.0]


def test_no_bodies_occlude_nothing() -> None:
    assert occlusion_probability(Bodies.behind([], NOWHERE), 2.3) == 0.0

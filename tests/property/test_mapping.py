"""Laws of fits and of what is made of them: they do not depend on the frame, nor on the order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.arrays import FloatArray
from echoplan.classical.features import (
    AssociationSettings,
    Span,
    Stack,
    fit_circle,
    fit_line,
    group_lines,
    junctions,
    shares,
)
from echoplan.geometry import compose, transform_points, wrap
from helpers import scenes

GATES = AssociationSettings()
HUBS = [(0.2, 0.1), (1.4, -0.3), (2.2, 0.4)]
frames = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-np.pi, np.pi)).map(np.array)
normals = st.floats(-np.pi, np.pi)
offsets = st.floats(3.0, 6.0)


def noisy(stack: Stack, seed: int) -> Stack:
    rng = np.random.default_rng(seed)
    return Stack(
        hubs_xy=stack.hubs_xy,
        bearings=stack.bearings + rng.normal(0, 0.01, len(stack.bearings)),
        distances=stack.distances + rng.normal(0, 0.003, len(stack.bearings)),
        bearing_sigmas=np.full(len(stack.bearings), 0.01),
        distance_sigmas=np.full(len(stack.bearings), 0.003),
    )


def moved(stack: Stack, frame: FloatArray) -> Stack:
    return Stack(
        hubs_xy=transform_points(frame, stack.hubs_xy),
        bearings=stack.bearings + frame[2],
        distances=stack.distances,
        bearing_sigmas=stack.bearing_sigmas,
        distance_sigmas=stack.distance_sigmas,
    )


@given(frames, normals, offsets, st.integers(0, 1000))
def test_a_line_is_the_same_line_in_another_frame(frame: FloatArray, normal: float, offset: float, seed: int) -> None:
    stack = noisy(Stack.of([scenes.observed_wall((normal, offset), hub) for hub in HUBS]), seed)
    here, there = fit_line(stack), fit_line(moved(stack, frame))
    assert float(wrap(there.parameters[0] - here.parameters[0] - frame[2])) == pytest.approx(0.0, abs=1e-7)
    assert there.distance_residuals == pytest.approx(here.distance_residuals, abs=1e-7)
    assert there.covariance[0, 0] == pytest.approx(here.covariance[0, 0], rel=1e-5)


@given(frames, st.floats(0.02, 0.4), st.integers(0, 1000))
def test_a_circle_is_the_same_circle_in_another_frame(frame: FloatArray, radius: float, seed: int) -> None:
    stack = noisy(Stack.of([scenes.observed_circle((1.0, 1.6, radius), hub) for hub in HUBS]), seed)
    here, there = (fit_circle(each, radius=0.1, radius_sigma=0.1) for each in (stack, moved(stack, frame)))
    center = compose(frame, np.append(here.parameters[:2], 0.0))[:2]
    assert there.parameters[:2] == pytest.approx(center, abs=1e-6)
    assert there.parameters[2] == pytest.approx(here.parameters[2], abs=1e-6)


@given(st.permutations(range(6)))
def test_groups_do_not_depend_on_the_order_of_the_walls(order: list[int]) -> None:
    lines = ((np.pi / 2, 3.0), (0.0, 4.0))
    detected = [scenes.observed_wall(line, hub, sweep=k) for line in lines for k, hub in enumerate(HUBS)]
    groups = group_lines([detected[each] for each in order], GATES)
    bearings = sorted([float(wrap(each.point.bearing)) for each in group.members] for group in groups)
    assert np.array(bearings) == pytest.approx(np.repeat([[0.0], [np.pi / 2]], 3, axis=1))


@given(normals, st.floats(0.4, np.pi - 0.4), st.booleans())
def test_two_walls_meet_alike_in_whichever_order_they_are_named(normal: float, turn: float, low: bool) -> None:  # noqa: FBT001
    first = Span(line=np.array([normal, 2.0]), low=-1.0, high=1.0)
    second = Span(line=np.array([normal + (turn if low else -turn), 2.0]), low=-1.0, high=1.0)
    meetings = [junctions(pair, max_extension=9.0) for pair in ([first, second], [second, first])]
    assert len(meetings[0]) == len(meetings[1])
    for one, other in zip(*meetings, strict=True):
        assert one.position_xy == pytest.approx(other.position_xy)
        assert one.kind is other.kind
        assert one.extension == pytest.approx(other.extension)


@given(st.lists(st.floats(-1, 2), min_size=3, max_size=3))
def test_shares_are_probabilities_in_the_order_of_the_degrees(degrees: list[float]) -> None:
    found = shares(np.array(degrees))
    values = [found.corner, found.cylinder, found.wall]
    assert sum(values) == pytest.approx(1.0)
    assert min(values) >= 0
    if max(degrees) > 0:
        assert values[int(np.argmax(degrees))] == max(values)

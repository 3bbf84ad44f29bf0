"""Frames and the transforms between them over time (/tf and /tf_static)."""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.io.ros.series import Role, Series, SeriesKey

__all__ = ["Frames", "Step", "frames_of", "plane_pose", "span_ns", "transforms_along", "way_between"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Step:
    """A transform from one frame to the next.

    Parameters
    ----------
    start, end : str
        The frames.
    series : Series
        The transforms from child to parent over time.
    is_fixed : bool
        Whether it never changes.
    is_down : bool
        Whether ``end`` is the child.
    """

    start: str
    end: str
    series: Series
    is_fixed: bool
    is_down: bool


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Frames:
    """The frames of a robot.

    Parameters
    ----------
    steps : tuple of Step
        Every transform, once in each direction.
    """

    steps: tuple[Step, ...]

    @property
    def names(self) -> set[str]:
        """Names of all frames."""
        return {step.start for step in self.steps}

    def find(self, name: str) -> str | None:
        """Find a frame by its name, or else by the last part of it (``robot1/odom``) if only one frame matches."""
        ending = [each for each in self.names if each.rpartition("/")[2] == name]
        if name in ending:
            return name
        return ending[0] if len(ending) == 1 else None


def frames_of(contents: Mapping[SeriesKey, Series], *, is_whole: bool = True) -> Frames:
    """Gather all transforms; of the whole, one on /tf that never changes counts as fixed, like those on /tf_static.

    Transforms with numbers that are not finite, or with an all-zero quaternion, are left out.
    """
    steps = []
    for key, recorded in contents.items():
        if key.role not in (Role.FIXED_TRANSFORM, Role.MOVING_TRANSFORM) or key.frame == key.child:
            continue
        finite = recorded.finite()
        series = finite[np.flatnonzero(finite.values[:, 3:].any(axis=1))]
        if not len(series):
            continue
        is_same = bool((series.values == series.values[0]).all()) or np.ptp(series.stamps_ns) == 0
        is_fixed = key.role is Role.FIXED_TRANSFORM or bool(is_same & is_whole)
        for start, end in ((key.frame, key.child), (key.child, key.frame)):
            steps.append(Step(start=start, end=end, series=series, is_fixed=is_fixed, is_down=end == key.child))
    return Frames(steps=tuple(steps))


def way_between(frames: Frames, start: str, *, end: str) -> list[Step] | None:
    """Find the shortest path from one frame to another; None if they are not connected."""
    ways: dict[str, list[Step]] = {start: []}
    queue = deque([start])
    while queue:
        here = queue.popleft()
        if here == end:
            return ways[here]
        for step in frames.steps:
            if step.start == here and step.end not in ways:
                ways[step.end] = [*ways[here], step]
                queue.append(step.end)
    return None


def transforms_along(way: Iterable[Step], stamps_ns: IntArray) -> FloatArray:
    """Chain the transforms along a path at the given times: ``start_from_end``, shape (n, 4, 4)."""
    chained = np.broadcast_to(np.eye(4), (len(stamps_ns), 4, 4))
    for step in way:
        here = _matrices(step, stamps_ns)
        chained = chained @ (here if step.is_down else np.linalg.inv(here))
    return chained


def plane_pose(matrices: FloatArray) -> FloatArray:
    """Project transforms onto the plane: ``(x, y, yaw)``, shape (n, 3); yaw is the direction of the x axis."""
    return np.column_stack([matrices[:, 0, 3], matrices[:, 1, 3], np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])])


def _matrices(step: Step, stamps_ns: IntArray) -> FloatArray:
    from scipy.spatial.transform import Rotation, Slerp  # noqa: PLC0415 - it takes a while

    series = step.series
    if step.is_fixed:
        # The last one counts: a static transform is replaced by publishing it again.
        values = np.broadcast_to(series.values[-1], (len(stamps_ns), 7))
        turns = Rotation.from_quat(values[:, 3:]).as_matrix()
        shifts = values[:, :3]
    else:
        times, places = np.unique(series.stamps_ns, return_index=True)
        knots = (times - times[0]).astype(np.float64)
        moments = np.clip((stamps_ns - times[0]).astype(np.float64), knots[0], knots[-1])
        known = series.values[places]
        turns = Slerp(knots, Rotation.from_quat(known[:, 3:]))(moments).as_matrix()
        shifts = np.stack([np.interp(moments, knots, column) for column in known[:, :3].T], axis=-1)
    matrices = np.tile(np.eye(4), (len(stamps_ns), 1, 1))
    matrices[:, :3, :3] = turns
    matrices[:, :3, 3] = shifts
    return matrices


def span_ns(steps: Sequence[Step]) -> tuple[int, int]:
    """Return the first and last time [ns] at which every moving transform of a path is known."""
    moving = [step.series.stamps_ns for step in steps if not step.is_fixed]
    if not moving:
        return -(2**62), 2**62
    return max(int(stamps[0]) for stamps in moving), min(int(stamps[-1]) for stamps in moving)

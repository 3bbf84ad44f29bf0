"""Values: values of all unknowns, before and after each step of an adjustment."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.layout import Layout
from echoplan.joint.optimisation.range_factors import Features
from echoplan.preprocessing.servo import AS_RECORDED, ServoError

__all__ = ["Values"]

# Features, walls where they were heard, poses and the servo move no farther than this in a step [rad or m], loudness
# and beam change by no more than these [dB, 1].
_LONGEST, _LOUDER, _WIDER = 0.05, 1.0, 0.05
# The exponent of the range walk stays between these: bursts that rise as t^4 or faster, and at once.
_SLOWEST, _FASTEST = 0.5, 2.0
# Radii stay between these [m].
_THIN, _THICK = 0.01, 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Values:
    """Where features, sonar and poses are now.

    Parameters
    ----------
    features : Features
        The features.
    model : EchoModel
        The sonar.
    latency : float, optional
        By how much the servo lags behind what was recorded [s].
    servo : ServoError, optional
        Gain and offset of the servo.
    poses : ndarray, shape (s, 3), optional
        Poses of the stations [m, m, rad]; empty if they are trusted.
    """

    features: Features
    model: EchoModel
    latency: float = 0.0
    servo: ServoError = AS_RECORDED
    poses: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    @cached_property
    def layout(self) -> Layout:
        """What stands where among the unknowns."""
        return Layout(kinds=self.features.reflectors[:, 0].astype(np.int64), poses=len(self.poses))

    @property
    def values(self) -> FloatArray:
        """All of them in one vector, shape (u,)."""
        model = self.model
        sonar = [model.range_offset, model.walk_gain, model.range_scale, self.latency, *self.servo]
        sonar += [model.figure_of_merit, math.log(model.ka), model.walk_exponent]
        return np.concatenate([self.features.reflectors[:, 1:][self.layout.free], sonar, self.poses.ravel()])

    def retracted(self, step: FloatArray) -> "Values":
        """Take a step.

        Parameters
        ----------
        step : ndarray, shape (u,)
            Of all unknowns.

        Returns
        -------
        Values
            Points, poses and the middles of walls go no farther than 5 cm along any axis at once, and nothing turns
            more than 0.05 rad: longer steps are shortened as a whole.  Loudness changes by 1 dB at most, the beam by
            5 %.  Radii stay within what a cylinder may have.
        """
        layout, reflectors = self.layout, self.features.reflectors.copy()
        steps = layout.steps(step)
        # A wall turns about where it was heard: far from the origin its offset changes by much though it stays there.
        moves = np.where(layout.kinds[:, None] == Kind.WALL, _at_middle(steps, self.features.extents), steps)
        reflectors[:, 1:] += _share(moves) * steps
        reflectors[:, 3] = np.where(layout.kinds == Kind.CYLINDER, np.clip(reflectors[:, 3], _THIN, _THICK), 0.0)
        ways = step[layout.pose :].reshape(-1, 3)
        offset, gain, scale, latency, *servo, merit, log_ka, exponent = step[layout.sonar : layout.pose].tolist()
        model = replace(
            self.model.scaled(self.model.range_scale + scale),
            range_offset=self.model.range_offset + offset,
            walk_gain=self.model.walk_gain + gain,
            figure_of_merit=self.model.figure_of_merit + min(max(merit, -_LOUDER), _LOUDER),
            ka=self.model.ka * math.exp(min(max(log_ka, -_WIDER), _WIDER)),
            walk_exponent=min(max(self.model.walk_exponent + exponent, _SLOWEST), _FASTEST),
        )
        extents = self.features.extents + _shifts(self.features, reflectors)[:, None]
        return Values(
            features=self.features._replace(reflectors=reflectors, extents=extents, ends=edges_of(reflectors, extents)),
            model=model,
            latency=self.latency + latency,
            servo=ServoError(
                *(now + min(max(turn, -_LONGEST), _LONGEST) for now, turn in zip(self.servo, servo, strict=True))
            ),
            poses=self.poses + _share(ways) * ways,
        )


def _at_middle(steps: FloatArray, extents: FloatArray) -> FloatArray:
    """How walls turn, and how far the middle of what was heard of them moves, shape (f, 3)."""
    moves = steps.copy()
    moves[:, 1] -= extents.mean(axis=1) * steps[:, 0]
    return moves


def _shifts(features: Features, reflectors: FloatArray) -> FloatArray:
    """By how much places along walls change that turn about the middle of what was heard of them, shape (f,) [m]."""
    angles, middles = features.reflectors[:, 1], features.extents.mean(axis=1)
    points = features.reflectors[:, 2:3] * directions(angles) + middles[:, None] * directions(angles + np.pi / 2)
    moved = np.sum(points * directions(reflectors[:, 1] + np.pi / 2), axis=1)
    shifts: FloatArray = np.where(features.reflectors[:, 0] == Kind.WALL, moved - middles, 0.0)
    return shifts


def _share(moves: FloatArray) -> FloatArray:
    """Tell which share of each move may be taken at once, the same of all that belongs to it, shape (m, 1)."""
    farthest = np.abs(moves).max(axis=1, initial=_LONGEST, keepdims=True)
    share: FloatArray = _LONGEST / farthest
    return share

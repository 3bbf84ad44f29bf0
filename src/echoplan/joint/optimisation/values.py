"""Values of all unknowns, before and after each step of the optimiser."""

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

# Greatest change in one step: of landmarks (walls at the middle of their extent), poses and servo [rad or m], of the
# figure of merit [dB], and of the logarithm of ka.
_LONGEST, _LOUDER, _WIDER = 0.05, 1.0, 0.05
# Bounds of the exponent of the range walk, which depends on how steeply the burst rises.
_SLOWEST, _FASTEST = 0.5, 2.0
# Bounds of the radius of a cylinder [m].
_THIN, _THICK = 0.01, 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Values:
    """Present landmarks, calibration and poses."""

    features: Features
    model: EchoModel
    # Latency of the servo [s].
    latency: float = 0.0
    # Gain and offset of the servo.
    servo: ServoError = AS_RECORDED
    # Poses of the stations [m, m, rad], shape (s, 3); empty if they are fixed.
    poses: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    @cached_property
    def layout(self) -> Layout:
        """Positions of the unknowns in the state vector."""
        return Layout(kinds=self.features.reflectors[:, 0].astype(np.int64), poses=len(self.poses))

    @property
    def values(self) -> FloatArray:
        """State vector, shape (u,)."""
        model = self.model
        sonar = [model.range_offset, model.walk_gain, model.range_scale, self.latency, *self.servo]
        sonar += [model.figure_of_merit, math.log(model.ka), model.walk_exponent]
        return np.concatenate([self.features.reflectors[:, 1:][self.layout.free], sonar, self.poses.ravel()])

    def retracted(self, step: FloatArray) -> "Values":
        """Return the values after a step of shape (u,), shortened where it is too long.

        Points, poses and the middles of walls move by at most 5 cm along any axis and turn by at most 0.05 rad: a
        longer move is scaled as a whole. The figure of merit changes by at most 1 dB, ka by 5 %; radii stay within
        their bounds.
        """
        layout, reflectors = self.layout, self.features.reflectors.copy()
        steps = layout.steps(step)
        # Moves of walls are limited at the middle of their extent: far from the origin a small rotation changes the
        # offset by much.
        moves = steps.copy()
        moves[:, 1] -= np.where(layout.kinds == Kind.WALL, self.features.extents.mean(axis=1) * steps[:, 0], 0.0)
        reflectors[:, 1:] += _share(moves) * steps
        reflectors[:, 3] = np.where(
            layout.kinds == Kind.CYLINDER, np.clip(reflectors[:, 3], _THIN, _THICK), self.features.reflectors[:, 3]
        )
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


def _shifts(features: Features, reflectors: FloatArray) -> FloatArray:
    """Return the change of positions along walls that turn about the middle of their extent, shape (f,) [m]."""
    angles, middles = features.reflectors[:, 1], features.extents.mean(axis=1)
    points = features.reflectors[:, 2:3] * directions(angles) + middles[:, None] * directions(angles + np.pi / 2)
    moved = np.sum(points * directions(reflectors[:, 1] + np.pi / 2), axis=1)
    shifts: FloatArray = np.where(features.reflectors[:, 0] == Kind.WALL, moved - middles, 0.0)
    return shifts


def _share(moves: FloatArray) -> FloatArray:
    """Return the factor that shortens each move to what is allowed in one step, shape (m, 1)."""
    farthest = np.abs(moves).max(axis=1, initial=_LONGEST, keepdims=True)
    share: FloatArray = _LONGEST / farthest
    return share

"""Simultaneous localisation and mapping: a filter over the last poses and all landmarks.

A single sweep cannot tell a wall from a point: both look like one place at one distance.  So what matches no landmark
waits until another sweep sees something that only one shape explains together with it; then a landmark is born.  That
needs the poses of both sweeps in the state (delayed initialisation; Leonard et al. 2002 [recalled]).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import log

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray
from echoplan.classical.features.observations import Observation
from echoplan.classical.slam.gaussian_state import Belief, Innovation
from echoplan.classical.slam.landmarks import CIRCLE, LINE, Shape
from echoplan.classical.slam.motion import MotionSettings, moved
from echoplan.geometry import compose, invert, wrap

__all__ = ["Landmark", "Slam", "SlamSettings"]


class SlamSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of the filter."""

    motion: MotionSettings = Field(default_factory=MotionSettings)
    gate: float = Field(
        default=0.99, gt=0.0, lt=1.0, description="share of the sightings of a landmark that are to be taken for it"
    )
    odds: float = Field(
        default=20.0, ge=1.0, description="how many times likelier one shape must be before a landmark is born"
    )
    window: int = Field(default=12, ge=2, description="sweeps whose poses are still corrected")
    bearing_floor: float = Field(
        default=0.0175, gt=0.0, description="what all echoes of one sweep have in common in bearing [rad]: 1 degree"
    )
    distance_floor: float = Field(
        default=0.003, gt=0.0, description="likewise in distance [m]: range walk of the modules"
    )
    radius: float = Field(default=0.05, gt=0.0, description="radius of a circle of which nothing is known yet [m]")
    radius_sigma: float = Field(default=0.05, gt=0.0, description="its standard deviation [m]")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Landmark:
    """A line or a circle that was seen from several poses.

    Parameters
    ----------
    name : str
        Name of its block in the belief.
    shape : Shape
        What it is.
    sightings : tuple of Observation
        What was seen of it, in ``base_link`` of each sweep.
    """

    name: str
    shape: Shape
    sightings: tuple[Observation, ...]

    def joined_by(self, sighting: Observation) -> "Landmark":
        """Add a sighting.

        Parameters
        ----------
        sighting : Observation
            In ``base_link`` of its sweep.

        Returns
        -------
        Landmark
            The same landmark, seen once more.
        """
        return Landmark(name=self.name, shape=self.shape, sightings=(*self.sightings, sighting))


class Slam:
    """Filters odometry and sightings, sweep by sweep.

    Parameters
    ----------
    settings : SlamSettings, optional
        Noise and gates.
    """

    def __init__(self, settings: SlamSettings | None = None) -> None:
        self.settings = settings or SlamSettings()
        self.belief = Belief(sizes={}, mean=np.zeros(0), covariance=np.zeros((0, 0)))
        self.landmarks: list[Landmark] = []
        self._stations: dict[int, FloatArray] = {}
        self._settled: dict[int, FloatArray] = {}
        self._waiting: list[Observation] = []

    @property
    def poses(self) -> FloatArray:
        """Corrected pose of each sweep [m, m, rad], shape (s, 3)."""
        poses = [self.pose(sweep) for sweep in self._stations]
        return np.array([[x, y, float(wrap(yaw))] for x, y, yaw in poses]).reshape(-1, 3)

    def pose(self, sweep: int) -> FloatArray:
        """Tell where the robot was.

        Parameters
        ----------
        sweep : int
            Number of a sweep that was added.

        Returns
        -------
        ndarray, shape (3,)
            Corrected pose [m, m, rad]; yaw is not wrapped.
        """
        settled = self._settled.get(sweep)
        return self.belief[_pose(sweep)] if settled is None else settled

    def add(self, sweep: int, station: FloatArray, sightings: list[Observation]) -> None:
        """Move to the next station and look about.

        Parameters
        ----------
        sweep : int
            Its number.
        station : ndarray, shape (3,)
            Its pose as dead reckoning tells it [m, m, rad].
        sightings : list of Observation
            What was seen there, in ``base_link``.
        """
        self._move(sweep, station)
        for sighting in sorted(sightings, key=lambda each: each.point.covariance[0, 0]):
            self._see(sighting)
        self._settle()

    def _move(self, sweep: int, station: FloatArray) -> None:
        if not self._stations:
            self.belief = Belief(sizes={_pose(sweep): 3}, mean=station, covariance=np.zeros((3, 3)))
        else:
            last, before = next(reversed(self._stations.items()))
            motion = compose(invert(before), station)
            self.belief = moved(self.belief, _pose(sweep), motion, start=_pose(last), settings=self.settings.motion)
        self._stations[sweep] = station

    def _see(self, sighting: Observation) -> None:
        """Take a sighting for a landmark, or for the second one of something new, or let it wait."""
        number = self._seen_again(sighting)
        if number is None and not self._born(sighting):
            self._waiting.append(sighting)
        if number is not None:
            landmark = self.landmarks[number]
            self.belief = self.belief.corrected(self._innovation(self.belief, landmark.name, landmark.shape, sighting))
            self.landmarks[number] = landmark.joined_by(sighting)

    def _seen_again(self, sighting: Observation) -> int | None:
        """Find the landmark that explains a sighting best, if any is within the gate."""
        innovations = {
            number: self._innovation(self.belief, landmark.name, landmark.shape, sighting)
            for number, landmark in enumerate(self.landmarks)
        }
        within = {number: each for number, each in innovations.items() if self._is_within(self.belief, each)}
        return min(within, key=lambda number: self.belief.surprise(within[number]), default=None)

    def _born(self, sighting: Observation) -> bool:
        """Make a landmark of a sighting and one that waited, if they are surely of one shape."""
        candidates = list(self._candidates(sighting))
        if not candidates:
            return False
        _, earlier, shape = min(candidates, key=lambda each: each[0])
        name = f"landmark {len(self.landmarks)}"
        grown = self._grown(self.belief, name, shape, earlier)
        self.belief = grown.corrected(self._innovation(grown, name, shape, sighting))
        self.landmarks.append(Landmark(name=name, shape=shape, sightings=(earlier, sighting)))
        self._waiting.remove(earlier)
        return True

    def _candidates(self, sighting: Observation) -> Iterator[tuple[float, Observation, Shape]]:
        """Yield what a sighting may be together with an earlier one: the surprise, the earlier one, the shape."""
        for earlier in self._waiting:
            if earlier.sweep == sighting.sweep:
                continue
            both = self.belief.of([_pose(earlier.sweep), _pose(sighting.sweep)])
            ranked = sorted(
                (self._surprise(both, shape, earlier, sighting), shape.name, shape) for shape in (LINE, CIRCLE)
            )
            (least, _, shape), (other, _, _) = ranked
            if other - least >= 2 * log(self.settings.odds):
                yield least, earlier, shape

    def _surprise(self, belief: Belief, shape: Shape, earlier: Observation, sighting: Observation) -> float:
        """How surprising a sighting is if it is of the same shape as an earlier one; inf beyond the gate."""
        grown = self._grown(belief, "new", shape, earlier)
        innovation = self._innovation(grown, "new", shape, sighting)
        return grown.surprise(innovation) if self._is_within(grown, innovation) else np.inf

    def _is_within(self, belief: Belief, innovation: Innovation) -> bool:
        # Chi squared with two degrees of freedom is an exponential distribution.
        return belief.squared_distance(innovation) <= -2 * log(1 - self.settings.gate)

    def _grown(self, belief: Belief, name: str, shape: Shape, sighting: Observation) -> Belief:
        """Add a landmark that was seen once: its parameters solve the equations of its sighting.

        By the theorem of implicit functions their derivatives are those of the sighting, inverted; what one sighting
        cannot tell, the radius of a circle, is a sighting of its own: the guess.
        """
        pose = belief[_pose(sighting.sweep)]
        values = shape.place(pose, sighting.point, self.settings.radius)
        expected = shape.expect(pose, values, sighting.point.hub_xy)
        guesses = shape.size - 2
        noise = np.eye(shape.size) * self.settings.radius_sigma**2
        noise[:2, :2] = self._noise(sighting)
        inverse = np.linalg.inv(np.vstack([expected.by_landmark, np.eye(shape.size)[2:]]))
        by_pose = np.vstack([expected.by_pose, np.zeros((guesses, 3))])
        return belief.extended(
            name, values, given=[_pose(sighting.sweep)], jacobian=-inverse @ by_pose, noise=inverse @ noise @ inverse.T
        )

    def _innovation(self, belief: Belief, name: str, shape: Shape, sighting: Observation) -> Innovation:
        expected = shape.expect(belief[_pose(sighting.sweep)], belief[name], sighting.point.hub_xy)
        return Innovation(
            blocks=(_pose(sighting.sweep), name),
            residual=expected.residual(sighting.point),
            jacobian=np.hstack([expected.by_pose, expected.by_landmark]),
            noise=self._noise(sighting),
        )

    def _noise(self, sighting: Observation) -> FloatArray:
        floor = np.square([self.settings.bearing_floor, self.settings.distance_floor])
        noise: FloatArray = sighting.point.covariance + np.diag(floor)
        return noise

    def _settle(self) -> None:
        """Let go of the poses that have left the window, as they are now, and of what waited there."""
        past = [sweep for sweep in list(self._stations)[: -self.settings.window] if sweep not in self._settled]
        for sweep in past:
            self._settled[sweep] = self.belief[_pose(sweep)]
        gone = {_pose(sweep) for sweep in past}
        self.belief = self.belief.of([block for block in self.belief.sizes if block not in gone])
        self._waiting = [each for each in self._waiting if each.sweep not in self._settled]


def _pose(sweep: int) -> str:
    return f"pose {sweep}"

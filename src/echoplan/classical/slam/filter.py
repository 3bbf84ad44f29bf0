"""Simultaneous localisation and mapping: a filter over the last poses and all landmarks.

A single sweep cannot distinguish a wall from a point: both give one bearing and one distance.  So an observation that
matches no landmark waits until an observation of another sweep fits together with it only one shape; then a landmark is
initialised from both.  That needs the poses of both sweeps in the state (delayed initialisation; Leonard et al. 2002
[recalled]).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import log
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.features.observations import Observation
from echoplan.classical.slam.gaussian_state import GaussianState, Innovation
from echoplan.classical.slam.landmarks import CIRCLE, LINE, Shape
from echoplan.classical.slam.motion import MotionSettings, moved
from echoplan.geometry import compose, invert, wrap
from echoplan.settings import Settings

__all__ = ["Landmark", "Slam", "SlamSettings"]


class SlamSettings(Settings):
    """Settings of the filter."""

    former_keys: ClassVar = {
        "odds": "min_likelihood_ratio",
        "bearing_floor": "common_bearing_sigma",
        "distance_floor": "common_distance_sigma",
    }

    motion: MotionSettings = Field(default_factory=MotionSettings)
    gate: float = Field(
        default=0.99, gt=0.0, lt=1.0, description="Share of the measurements of a landmark that are associated with it."
    )
    min_likelihood_ratio: float = Field(
        default=20.0, ge=1.0, description="Smallest likelihood ratio of two shapes with which a landmark is added."
    )
    window: int = Field(default=12, ge=2, description="Number of latest sweeps whose poses are corrected.")
    common_bearing_sigma: float = Field(
        default=0.0175,
        gt=0.0,
        description="Standard deviation of the bearing error that all echoes of a sweep share [rad]: 1 degree.",
    )
    common_distance_sigma: float = Field(
        default=0.003,
        gt=0.0,
        description="Standard deviation of the range error that all echoes of a sweep share [m]: range walk of "
        "the modules.",
    )
    radius: float = Field(default=0.05, gt=0.0, description="Expected radius of a circle before it is measured [m].")
    radius_sigma: float = Field(default=0.05, gt=0.0, description="Standard deviation of the expected radius [m].")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Landmark:
    """A line or a circle that was observed from several poses.

    Parameters
    ----------
    name : str
        Name of its block of the state.
    shape : Shape
        Line or circle.
    sightings : tuple of Observation
        Its observations, each in ``base_link`` of its sweep.
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
            The landmark with one more sighting.
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
        self.state = GaussianState(sizes={}, mean=np.zeros(0), covariance=np.zeros((0, 0)))
        self.landmarks: list[Landmark] = []
        self._stations: dict[int, FloatArray] = {}
        self._final_poses: dict[int, FloatArray] = {}
        self._waiting: list[Observation] = []

    @property
    def poses(self) -> FloatArray:
        """Corrected pose of each sweep [m, m, rad], shape (s, 3)."""
        poses = [self.pose(sweep) for sweep in self._stations]
        return np.array([[x, y, float(wrap(yaw))] for x, y, yaw in poses]).reshape(-1, 3)

    def pose(self, sweep: int) -> FloatArray:
        """Return the corrected pose of a sweep.

        Parameters
        ----------
        sweep : int
            Number of a sweep that was added.

        Returns
        -------
        ndarray, shape (3,)
            Corrected pose [m, m, rad]; yaw is not wrapped.
        """
        pose = self._final_poses.get(sweep)
        return self.state[_pose(sweep)] if pose is None else pose

    def add(self, sweep: int, station: FloatArray, sightings: list[Observation]) -> None:
        """Predict the pose of the next sweep and update the map with its sightings.

        Parameters
        ----------
        sweep : int
            Its number.
        station : ndarray, shape (3,)
            Its pose by odometry [m, m, rad].
        sightings : list of Observation
            Its observations, in ``base_link``.
        """
        self._move(sweep, station)
        for sighting in sorted(sightings, key=lambda each: each.point.covariance[0, 0]):
            self._observe(sighting)
        self._marginalise()

    def _move(self, sweep: int, station: FloatArray) -> None:
        if not self._stations:
            self.state = GaussianState(sizes={_pose(sweep): 3}, mean=station, covariance=np.zeros((3, 3)))
        else:
            last, before = next(reversed(self._stations.items()))
            motion = compose(invert(before), station)
            self.state = moved(self.state, _pose(sweep), motion, start=_pose(last), settings=self.settings.motion)
        self._stations[sweep] = station

    def _observe(self, sighting: Observation) -> None:
        """Associate a sighting with a landmark, initialise one with an earlier sighting, or keep it for later."""
        number = self._associate(sighting)
        if number is None and not self._initialise(sighting):
            self._waiting.append(sighting)
        if number is not None:
            landmark = self.landmarks[number]
            self.state = self.state.updated(self._innovation(self.state, landmark.name, landmark.shape, sighting))
            self.landmarks[number] = landmark.joined_by(sighting)

    def _associate(self, sighting: Observation) -> int | None:
        """Find the landmark with the least deviance of a sighting within the gate; None if there is none."""
        innovations = {
            number: self._innovation(self.state, landmark.name, landmark.shape, sighting)
            for number, landmark in enumerate(self.landmarks)
        }
        within = {number: each for number, each in innovations.items() if self._is_within(self.state, each)}
        return min(within, key=lambda number: self.state.deviance(within[number]), default=None)

    def _initialise(self, sighting: Observation) -> bool:
        """Initialise a landmark from a sighting and an earlier one, if one shape fits clearly better than the other."""
        candidates = list(self._candidates(sighting))
        if not candidates:
            return False
        _, earlier, shape = min(candidates, key=lambda each: each[0])
        name = f"landmark {len(self.landmarks)}"
        augmented = self._augmented(self.state, name, shape, earlier)
        self.state = augmented.updated(self._innovation(augmented, name, shape, sighting))
        self.landmarks.append(Landmark(name=name, shape=shape, sightings=(earlier, sighting)))
        self._waiting.remove(earlier)
        return True

    def _candidates(self, sighting: Observation) -> Iterator[tuple[float, Observation, Shape]]:
        """Yield pairs of a sighting with an earlier one that only one shape fits: deviance, earlier sighting, shape."""
        for earlier in self._waiting:
            if earlier.sweep == sighting.sweep:
                continue
            both = self.state.marginal([_pose(earlier.sweep), _pose(sighting.sweep)])
            ranked: list[tuple[float, str, Shape]] = []
            for shape in (LINE, CIRCLE):
                augmented = self._augmented(both, "new", shape, earlier)
                innovation = self._innovation(augmented, "new", shape, sighting)
                deviance = augmented.deviance(innovation) if self._is_within(augmented, innovation) else np.inf
                ranked.append((deviance, shape.name, shape))
            (least, _, likeliest), (other, _, _) = sorted(ranked)
            if other - least >= 2 * log(self.settings.min_likelihood_ratio):
                yield least, earlier, likeliest

    def _is_within(self, state: GaussianState, innovation: Innovation) -> bool:
        # Quantile of chi-squared with two degrees of freedom, an exponential distribution.
        return state.squared_distance(innovation) <= -2 * log(1 - self.settings.gate)

    def _augmented(self, state: GaussianState, name: str, shape: Shape, sighting: Observation) -> GaussianState:
        """Augment the state with a landmark whose parameters solve the measurement equations of one sighting.

        By the implicit function theorem their Jacobian is the inverse of that of the sighting.  One sighting does not
        determine the radius of a circle, so its prior is a measurement of its own.
        """
        pose = state[_pose(sighting.sweep)]
        values = shape.place(pose, sighting.point, self.settings.radius)
        expected = shape.expect(pose, values, sighting.point.hub_xy)
        guesses = shape.size - 2
        noise = np.eye(shape.size) * self.settings.radius_sigma**2
        noise[:2, :2] = self._noise(sighting)
        inverse = np.linalg.inv(np.vstack([expected.by_landmark, np.eye(shape.size)[2:]]))
        by_pose = np.vstack([expected.by_pose, np.zeros((guesses, 3))])
        return state.extended(
            name, values, given=[_pose(sighting.sweep)], jacobian=-inverse @ by_pose, noise=inverse @ noise @ inverse.T
        )

    def _innovation(self, state: GaussianState, name: str, shape: Shape, sighting: Observation) -> Innovation:
        expected = shape.expect(state[_pose(sighting.sweep)], state[name], sighting.point.hub_xy)
        return Innovation(
            blocks=(_pose(sighting.sweep), name),
            residual=expected.residual(sighting.point),
            jacobian=np.hstack([expected.by_pose, expected.by_landmark]),
            noise=self._noise(sighting),
        )

    def _noise(self, sighting: Observation) -> FloatArray:
        floor = np.square([self.settings.common_bearing_sigma, self.settings.common_distance_sigma])
        noise: FloatArray = sighting.point.covariance + np.diag(floor)
        return noise

    def _marginalise(self) -> None:
        """Marginalise poses that have left the window, and drop their unassociated sightings."""
        past = [sweep for sweep in list(self._stations)[: -self.settings.window] if sweep not in self._final_poses]
        for sweep in past:
            self._final_poses[sweep] = self.state[_pose(sweep)]
        gone = {_pose(sweep) for sweep in past}
        self.state = self.state.marginal([block for block in self.state.sizes if block not in gone])
        self._waiting = [each for each in self._waiting if each.sweep not in self._final_poses]


def _pose(sweep: int) -> str:
    return f"pose {sweep}"

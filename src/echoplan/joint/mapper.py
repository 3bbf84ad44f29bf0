"""The `joint` mapper: landmark hypotheses scored by a sonar model, and one optimisation of all stations.

A wall is a line tangent to the range circles of its stations, a corner or an edge is a point on them, a cylinder is a
circle tangent to them (Leonard and Durrant-Whyte 1992). A physical model of signal excess, beam, masking and range walk
predicts detections and non-detections, and so decides which of these explains the pings.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from threadpoolctl import threadpool_limits

from echoplan.acoustics.echo_model import SonarTables
from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.geometry import directions
from echoplan.joint.calibration import calibration
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.known_map import resumed, without_walls
from echoplan.joint.likelihood.hypothesis_scores import missed
from echoplan.joint.likelihood.ping_scores import score_pings
from echoplan.joint.map_extraction.openings import openings_of, unobserved_of
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.marginalisation import marginalise, survey, without_sonar
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.settings import EstimateSettings
from echoplan.joint.trace import record_window
from echoplan.joint.trajectory import Trajectory, joined, posed
from echoplan.model import FeatureMap, Rig, Sweep, Wall
from echoplan.preprocessing.measurements import Measurements, join_measurements, measurements_of
from echoplan.preprocessing.servo import AS_RECORDED, turned_by
from echoplan.preprocessing.stations import Stations, at_stations, group_sweeps, without_repeats

__all__ = ["JointMapper", "JointSettings"]


class JointSettings(EstimateSettings):
    """Settings of all stages of method `joint`."""


class JointMapper:
    """Estimate a map from all stations at once; of a long recording, from a window and a marginal prior.

    Parameters
    ----------
    rig : Rig
        Sensors that recorded the sweeps.
    settings : JointSettings, optional
        Settings of all stages.
    prior : MarginalPrior, optional
        What is known before the first sweep, such as a map; nothing by default.
    """

    # From one place, a wall, a corner and a cylinder return the same echoes.
    needs_places = True

    def __init__(self, rig: Rig, settings: JointSettings | None = None, *, prior: MarginalPrior | None = None) -> None:
        self.rig = rig
        self.settings = settings or JointSettings()
        self._marginal_prior = prior or MarginalPrior()
        self._indices: list[int] = []
        self._done: list[Trajectory] = []
        self._sweeps: list[Sweep] = []
        self._measurements: list[Measurements] = []
        self._first_station = 0
        # Number of sweeps before this recording, and the first pose of the next one if no sweep of it was added yet.
        self._earlier = 0
        self._next_start: FloatArray | None = None
        # The solution for all sweeps so far, if it was asked for.
        self._solved: _Solution | None = None

    def add(self, sweep: Sweep) -> None:
        """Add a sweep; marginalise the oldest stations once the window is full.

        Parameters
        ----------
        sweep : Sweep
            Pings of one pass of the array from one pose.
        """
        if not len(sweep):
            return
        if self._next_start is not None:
            self._resume(self._next_start)
        self._solved = None
        self._indices.append(sweep.index)
        self._sweeps.append(sweep)
        self._measurements.append(measurements_of(sweep, self.rig))
        window, stations = self.settings.window, self._stations()
        # Sweeps may still be added to the newest station.
        if len(stations.poses) > window.stations + window.stride:
            with _one_thread():
                self._let_go(stations, window.stride)

    def begin_recording(self, pose: FloatArray) -> None:
        """Go on with another recording of the same place with the next sweep: earlier stations are marginalised then.

        Its poses may be in a frame of their own; they count as those of odometry.  Landmarks may have moved since: one
        that the recording misses is removed, however often it was detected before.

        Parameters
        ----------
        pose : ndarray, shape (3,)
            Pose of its first sweep in the frame of the map [m, m, rad], right to 0.1 m and some degrees, as
            ``localise`` finds it.

        Raises
        ------
        InvalidValueError
            If there is neither a sweep nor a map before it.
        """
        if not self._sweeps and self._marginal_prior.is_empty:
            raise InvalidValueError("add the sweeps of a recording before another one begins")
        self._next_start = pose

    def forget(self, walls: Sequence[Wall]) -> None:
        """Forget what earlier recordings detected of some walls, since these are there no more.

        Parameters
        ----------
        walls : sequence of Wall
            Walls of the map, or pieces of them.
        """
        self._marginal_prior, self._solved = without_walls(self._marginal_prior, walls), None

    def result(self) -> FeatureMap:
        """Estimate the map from all sweeps so far.

        Returns
        -------
        FeatureMap
            Walls, corners, cylinders and openings, and the poses of the sweeps with covariances.
        """
        parameters, sweeps = self.settings.model_dump(mode="json"), np.array(self._indices, dtype=np.int64)
        if not self._has_echoes:
            return FeatureMap(method="joint", parameters=parameters, sweeps=sweeps, poses=self._given())
        with _one_thread():
            stations = self._stations()
            # Not by ``_solve``: the way down to the solver is to be short.
            solved = self._solved = self._solved or _Solution(estimate_map(self._initial_estimate(stations)))
            posed = self._trajectory(solved.estimate, stations)
            path_xy = self._path_xy(posed) if self.settings.segments.driven else np.zeros((0, 2))
            found = survey(solved.estimate, solved.prior, path_xy)
            learned = {
                **calibration(solved.estimate, found.solution),
                "right_angles": found.right_angles(),
                "undetermined": list(posed.undetermined),
            }
            gaps = found.gaps(path_xy)
            return FeatureMap(
                method="joint",
                parameters={**parameters, "found": learned},
                walls=found.walls(gaps),
                corners=found.corners(),
                cylinders=found.cylinders(),
                openings=openings_of(gaps),
                unobserved=unobserved_of(gaps),
                sweeps=sweeps,
                poses=posed.poses,
                pose_covariances=posed.covariances,
            )

    def prior(self) -> MarginalPrior | None:
        """Return what is known after all sweeps so far, with which another mapper can go on; None without echoes."""
        if not self._has_echoes:
            return None
        if not self._sweeps:
            return self._marginal_prior
        with _one_thread():
            stations = self._stations()
            solved = self._solve(stations)
            known = without_sonar(solved.estimate, solved.prior)
            return replace(known, path_xy=self._path_xy(self._trajectory(solved.estimate, stations)))

    def trajectory(self) -> tuple[Trajectory, EchoModel]:
        """Return the poses of all sweeps so far, at least one with pings, and the estimated sonar; make no map."""
        with _one_thread():
            stations = self._stations()
            estimate = self._solve(stations).estimate
            return self._trajectory(estimate, stations), estimate.model

    def misses(self, sweeps: Sequence[Sweep]) -> Callable[[Sequence[Wall]], FloatArray]:
        """Return how probable it is that some sweeps do not detect walls, for the sonar as estimated so far.

        Parameters
        ----------
        sweeps : sequence of Sweep
            At the poses of the map, not at the recorded ones.

        Returns
        -------
        callable
            Returns, for a sequence of n walls, or pieces of walls, the log probability that the stations of the sweeps
            do not detect each of them, shape (n,) [nats]; each station counts for -12 at most.
        """
        if not sweeps:
            return lambda walls: np.zeros(len(walls))
        parts = [measurements_of(sweep, self.rig) for sweep in sweeps]
        pings = np.array([len(part.readings) for part in parts])
        stations = group_sweeps(np.array([sweep.station for sweep in sweeps]), pings, self.settings.stations)
        measurements = without_repeats(at_stations(join_measurements(parts), stations))
        with _one_thread():
            estimate = self._solve(self._stations()).estimate
        if estimate.servo is not None:
            measurements = turned_by(measurements, error=estimate.servo, before=AS_RECORDED)
        return partial(_missed, measurements, estimate.likelihood.tables, estimate.noise)

    @property
    def _has_echoes(self) -> bool:
        return not self._marginal_prior.is_empty or any(len(part.readings) for part in self._measurements)

    def _solve(self, stations: Stations) -> "_Solution":
        self._solved = self._solved or _Solution(estimate_map(self._initial_estimate(stations)))
        return self._solved

    def _initial_estimate(self, stations: Stations) -> Estimate:
        record_window(self._first_station)
        measurements = without_repeats(at_stations(join_measurements(self._measurements), stations))
        return initial_estimate(self.rig, measurements, stations.poses, self.settings, self._marginal_prior)

    def _trajectory(self, estimate: Estimate, stations: Stations) -> Trajectory:
        return joined([*self._done, self._posed(estimate, stations)])

    def _path_xy(self, trajectory: Trajectory) -> FloatArray:
        """Return the path of the robot, shape (p, 2) [m]; a row of NaN separates recordings."""
        return np.vstack([self._marginal_prior.path_xy, trajectory.poses[self._earlier :, :2]])

    def _let_go(self, stations: Stations, count: int) -> None:
        """Marginalise the ``count`` oldest stations and drop their pings."""
        estimate, gone = self._solve(stations).estimate, int((stations.numbers < count).sum())
        self._marginal_prior = marginalise(estimate, count)
        self._done.append(self._posed(estimate, stations).first(gone))
        del self._sweeps[:gone], self._measurements[:gone]
        self._first_station += count
        self._solved = None

    def _resume(self, pose: FloatArray) -> None:
        """Marginalise all stations, and go on from a pose [m, m, rad] that is known roughly."""
        if self._sweeps:
            stations, known = self._stations(), self.prior()
            with _one_thread():
                self._let_go(stations, len(stations.poses))
            self._marginal_prior = known or self._marginal_prior
        self._marginal_prior = resumed(self._marginal_prior, pose, self.settings.segments)
        self._earlier = len(self._indices)
        self._next_start = None

    def _posed(self, estimate: Estimate, stations: Stations) -> Trajectory:
        return posed(estimate, stations, self._given(), np.array(self._indices[-len(self._sweeps) :]))

    def _stations(self) -> Stations:
        pings = np.array([len(each.readings) for each in self._measurements])
        return group_sweeps(self._given(), pings, self.settings.stations)

    def _given(self) -> FloatArray:
        return np.array([sweep.station for sweep in self._sweeps]).reshape(-1, 3)


@dataclass(frozen=True)
class _Solution:
    """The estimate from all stations of the window, and what remains of it once they are marginalised."""

    estimate: Estimate

    @cached_property
    def prior(self) -> MarginalPrior:
        """Landmarks with the histories and the information of all stations."""
        return marginalise(self.estimate, len(self.estimate.measured_poses))


def _one_thread() -> threadpool_limits:
    """Limit BLAS to one thread: on matrices this small, threads cost more than they save."""
    return threadpool_limits(limits=1, user_api="blas")


def _missed(measurements: Measurements, tables: SonarTables, noise: float, walls: Sequence[Wall]) -> FloatArray:
    """Return the log probability that stations do not detect walls, shape (n,) [nats]."""
    found = np.zeros(len(walls))
    for number, wall in enumerate(walls):
        low, high = np.sort(wall.endpoints_xy @ directions(wall.normal_angle + np.pi / 2)).tolist()
        reflector = np.array([Kind.WALL, wall.normal_angle, wall.offset, wall.reflection_loss])
        found[number] = missed(measurements, score_pings(measurements, tables, reflector, noise), (low, high))
    return found

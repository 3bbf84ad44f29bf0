"""The estimate: landmarks, sonar, noise and poses as an immutable value, and the steps that refine it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.arrays import BoolArray, FloatArray
from echoplan.joint.arcs import Arc, find_arcs
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood_cache import LikelihoodCache
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.optimisation.attenuation import shadowed
from echoplan.joint.optimisation.effective_sample_size import effective_sample_ratio, shared_rounding_sigma
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.optimisation.manhattan import ManhattanPrior
from echoplan.joint.optimisation.optimiser import Priors, Problem, optimise
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses, odometry_prior
from echoplan.joint.optimisation.range_factors import as_arrays
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.sonar_model import estimated_sonar, walking
from echoplan.joint.optimisation.values import Values
from echoplan.joint.pose_status import PoseModel, PoseStatus
from echoplan.joint.search.boxes import with_boxes
from echoplan.joint.search.model_moves import reclassified
from echoplan.joint.search.multipath_walls import without_multipath_walls
from echoplan.joint.search.search import Search
from echoplan.joint.settings import EstimateSettings
from echoplan.model import Odometry
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import AS_RECORDED, ServoError, turned_by

__all__ = ["Estimate", "initial_noise"]

# Least range error to which a maker adjusts a module [m].
_FINEST = 0.001
# Newton decrement (squared step in standard deviations) below which alternation has converged.
_SETTLED = 1e-5
# Most iterations of the initial map and of the class selection.
_MAX_REPEATS = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Estimate:
    """Landmarks, sonar, noise and poses as estimated so far; each step returns a new value."""

    settings: EstimateSettings
    # Prior from all marginalised stations, and the part of it within range of the current stations.
    marginal_prior: MarginalPrior
    active_prior: MarginalPrior
    # Resolution of the coarsest sensor [m]; half aperture within which sensors detect [rad].
    resolution: float
    half_aperture: float
    # Odometry noise that the rig specifies, if any.
    rig_odometry: Odometry | None
    # The sonar as expected before any ping, and as estimated.
    prior: EchoModel
    model: EchoModel
    # Pings of s stations at the recorded and at the estimated poses, with calibrated servo angles; their arcs.
    recorded: Measurements
    measurements: Measurements
    arcs: Sequence[Arc]
    # Poses as recorded and as estimated, shape (s, 3) [m, m, rad].
    measured_poses: FloatArray
    poses: FloatArray
    # Standard deviations of a reading, and of the error that readings of one landmark from one station share [m].
    noise: float
    bias_sigma: float
    features: Sequence[Hypothesis]
    trusts_specified_odometry: bool = True
    # Servo gain and offset if they are calibrated (else None), and the values from which calibration starts.
    servo: ServoError | None = None
    first_servo: ServoError = AS_RECORDED
    # Last solution, and the prior of its poses; None if poses were fixed.
    solution: Solution | None = None
    pose_prior: PosePrior | None = None
    # Model of the pose errors, and the decision about the poses with its reason.
    pose_model: PoseModel = PoseModel.FIXED
    pose_status: PoseStatus = field(default_factory=PoseStatus)
    # Manhattan prior as it was selected; `manhattan_prior` has its members among the current landmarks.
    selected_manhattan_prior: ManhattanPrior | None = None
    # Whether figure of merit and beam are variables; whether detections constrain headings (heading factors).
    is_calibrated: bool = False
    has_heading_factors: bool = False
    # Means of the priors of figure of merit [dB] and log ka.
    beam_prior: tuple[float, float] | None = None
    # Log evidence before shared errors were estimated, if they were [nats].
    log_evidence_without_bias: float | None = None
    # Ratio of the effective sample size to the weight of the readings.
    effective_sample_ratio: float = 1.0
    likelihoods: LikelihoodCache = field(default_factory=LikelihoodCache)

    @property
    def known(self) -> list[Hypothesis]:
        """Landmarks that are known from marginalised stations, from which a search starts."""
        return [*self.active_prior.features, *self.marginal_prior.pending]

    @property
    def likelihood(self) -> PingLikelihood:
        """Likelihood of the pings at the current poses, sonar and noise."""
        return self.likelihoods.of(self.measurements, self.model, noise=self.noise)

    @property
    def odometry_noise(self) -> Odometry | None:
        """Odometry noise that the rig specifies; None if it does not or if the specification is not trusted."""
        return self.rig_odometry if self.trusts_specified_odometry else None

    @property
    def latency(self) -> float:
        """Latency of the servo [s]."""
        return self.solution.latency if self.solution else self.marginal_prior.latency

    @property
    def first_noise(self) -> float:
        """Standard deviation of a reading before the noise is estimated [m]."""
        return initial_noise(self.settings, self.resolution)

    @property
    def rounding(self) -> float:
        """Standard deviation of the rounding error of a reading [m], a lower bound of the noise."""
        return self.resolution / math.sqrt(12.0)

    @property
    def offset_sigma(self) -> float:
        """Prior standard deviation of the range offset [m]: makers adjust a module to within one reading step."""
        return max(self.resolution, _FINEST) / math.sqrt(12.0)

    @property
    def has_odometry_model(self) -> bool:
        """Whether pose errors accumulate as errors of odometry do, according to the current pose prior."""
        return self.pose_prior is not None and self.pose_prior.relative

    @property
    def manhattan_prior(self) -> ManhattanPrior | None:
        """Manhattan prior with its members among the current landmarks; None without members."""
        members: BoolArray = np.array([each.is_square for each in self.features], dtype=bool)
        prior = self.selected_manhattan_prior
        return prior._replace(members=members) if prior is not None and members.any() else None

    def with_manhattan_prior(self, manhattan_prior: ManhattanPrior | None) -> "Estimate":
        """Return the estimate with a Manhattan prior (or none), whose members are marked on the landmarks."""
        members = np.zeros(len(self.features), dtype=bool) if manhattan_prior is None else manhattan_prior.members
        features = [replace(each, is_square=bool(e)) for each, e in zip(self.features, members, strict=True)]
        return replace(self, selected_manhattan_prior=manhattan_prior, features=features)

    @property
    def is_along_axes(self) -> bool:
        """Whether the Manhattan prior aligns walls with the axes of the map."""
        return self.manhattan_prior is not None and self.manhattan_prior.along_axes

    @property
    def has_servo(self) -> bool:
        """Whether any sensor rotated during its pings."""
        return bool(np.any(self.recorded.rates))

    def calibrate(self, servo: ServoError) -> "Estimate":
        """Make servo gain and offset variables, starting from the given values, and find the arcs again."""
        turned = _with_servo(self, servo)
        return replace(
            turned,
            first_servo=servo,
            has_heading_factors=True,
            arcs=find_arcs(turned.recorded, resolution=self.resolution, settings=self.settings.arcs),
            measurements=at_poses(turned.recorded, self.measured_poses, self.poses),
        )

    def restart_servo(self) -> "Estimate":
        """Reset servo gain and offset to their starting values, as estimates from wrong poses are wrong."""
        return self if self.servo is None else _with_servo(self, self.first_servo)

    def initialise(self) -> "Estimate":
        """Make a first map with one round of search, and repeat it while the range scale changes noticeably."""
        now = self
        for _ in range(_MAX_REPEATS):
            scale = now.model.range_scale
            now = now.search(rounds=1).optimise(now.first_noise)
            if abs(now.model.range_scale - scale) < now.settings.scale_step:
                break
        return now

    def explain(self) -> "Estimate":
        """Search landmarks and optimise; in the first window estimate the sonar from them, and search again."""
        now = self
        if self.marginal_prior.is_empty:
            first = self.first_noise
            now = (
                now.search()
                .optimise(first)
                .rescore(first)
                .estimate_figure_of_merit()
                .optimise(0.75 * first)
                .estimate_noise()
            )
        now = now.search()
        now = now.optimise(now.noise).prune_and_reclassify()
        return now.optimise(now.noise).rescore(now.noise)

    def alternate(self, noise: float, priors: PosePrior | None, rounds: int) -> "Estimate":
        """Alternate optimisation and rescoring until poses and detections converge, at most ``rounds`` times."""
        now = self
        for _ in range(rounds):
            detected = _detections(now)
            now = now.with_solution(optimise(*now.problem(noise, priors)), priors).rescore(noise)
            is_settled = now.solution is not None and now.solution.newton_decrement < _SETTLED
            if is_settled and np.array_equal(detected, _detections(now)):
                break
        return now

    def refine_calibration(self) -> "Estimate":
        """Optimise figure of merit and beam, too, unless poses drift: their errors would pass for weak echoes."""
        if self.has_odometry_model:
            return self
        now = replace(self, is_calibrated=True)
        if self.settings.walk == "fitted" and self.marginal_prior.is_empty:
            model = walking(self.model, self.solution, self.noise)
            prior = replace(self.prior, walk=model.walk, walk_gain=model.walk_gain)
            now = replace(now, model=model, prior=prior)
        # With marginalised stations one round suffices: their landmarks and sonar have converged before.
        return now.alternate(now.noise, now.pose_prior, 3 if now.marginal_prior.is_empty else 1)

    def prune_and_reclassify(self) -> "Estimate":
        """Select the best class of each landmark, and remove landmarks that fail the acceptance test."""
        search = self.landmark_search()
        return self._settle(search, with_boxes(search, search.rescored(self.features)))

    def _settle(self, search: Search, features: list[Hypothesis]) -> "Estimate":
        return replace(self, features=search.settled(reclassified(search.likelihood, features, search.acceptance)))

    def reselect_classes(self) -> "Estimate":
        """Repeat class selection and optimisation until no class changes."""
        now = self
        for _ in range(_MAX_REPEATS):
            kinds, search = [each.kind for each in now.features], now.landmark_search()
            now = now._settle(search, search.rescored(now.features))
            if [each.kind for each in now.features] == kinds:
                break
            now = now.optimise(now.noise, now.pose_prior).rescore(now.noise)
        return now

    def remove_multipath_walls(self) -> "Estimate":
        """Remove walls that multipath explains as well; run it last, as wrong poses make real walls look so."""
        search = self.landmark_search()
        kept = without_multipath_walls(search.likelihood, self.features, search.acceptance)
        if len(kept) == len(self.features):
            return self
        return replace(self, features=kept).optimise(self.noise, self.pose_prior).rescore(self.noise)

    def search(self, *, rounds: int | None = None) -> "Estimate":
        """Search landmarks that explain the pings, starting from the current ones; ``rounds`` limits the search."""
        return replace(self, features=self.landmark_search(rounds=rounds).run(self.features))

    def rescore(self, noise: float) -> "Estimate":
        """Compute the log-likelihood ratios of the landmarks at a noise [m]."""
        now = replace(self, noise=noise)
        return replace(now, features=now.landmark_search().rescored(self.features))

    def optimise(self, noise: float, poses: PosePrior | None = None) -> "Estimate":
        """Optimise landmarks and sonar, and the poses if a prior of them is given, at a noise [m]."""
        return self.with_solution(optimise(*self.problem(noise, poses)), poses)

    def problem(self, noise: float, poses: PosePrior | None) -> Problem:
        """Return the problem for ``optimise``: landmarks and sonar, and the poses if a prior of them is given."""
        start = self.values(self.features, np.zeros((0, 3)) if poses is None else self.poses)
        return Problem(
            measurements=self.measurements if poses is None else self.recorded,
            start=start,
            # The priors depend on whether poses drift in this optimisation.
            priors=replace(self, pose_prior=poses).priors(noise, poses),
            settings=self.settings.optimiser,
            known=self.active_prior.reordered(self.features, start.layout),
        )

    def values(self, features: Sequence[Hypothesis], poses: FloatArray) -> Values:
        """Return landmarks, with their attenuation from each station, calibration and poses for the optimiser."""
        may_be_soft = np.array([each.may_be_soft and not self.model.cone for each in features], dtype=bool)
        arrays = as_arrays(features, len(self.measured_poses))
        return Values(
            features=shadowed(self.measurements, self.model.tabulated(), arrays, may_be_soft),
            model=self.model,
            latency=self.latency,
            servo=self.servo or AS_RECORDED,
            poses=poses,
        )

    def with_solution(self, solution: Solution, poses: PosePrior | None) -> "Estimate":
        """Return the estimate after an optimisation, with the pings at the poses and servo angles of the solution."""
        features = [replace(each, reflector=row) for each, row in zip(self.features, solution.reflectors, strict=True)]
        now = replace(self, solution=solution, pose_prior=poses, model=solution.model, features=features)
        if poses is not None:
            now = replace(now, poses=solution.poses)
        if now.servo is not None:
            now = _with_servo(now, solution.servo)
        if poses is None and now.servo is None:
            return now
        return replace(now, measurements=at_poses(now.recorded, now.measured_poses, now.poses))

    def odometry(self) -> PosePrior:
        """Return the prior of the steps between the poses."""
        priors = odometry_prior(self.measured_poses, self.settings.pose_errors, self.odometry_noise)
        if self.active_prior.rest > len(SONAR_UNKNOWNS):
            # The marginal prior contains the first pose of the window.
            priors.sigmas[0] = np.inf
        return priors

    def priors(self, noise: float, poses: PosePrior | None) -> Priors:
        """Return the priors of the optimisation for a noise [m] and a prior of the poses (None: poses are fixed)."""
        settings, drifting = self.settings.optimiser, self.has_odometry_model and not self.marginal_prior.is_known_map
        # Drifting poses cannot determine the scale of the map, so the range scale keeps the narrow prior of the sensor.
        is_scale_known = drifting or not math.isnan(self.recorded.temperature)
        return Priors(
            noise=noise,
            offset_sigma=self.offset_sigma,
            walk_gain=self.prior.walk_gain,
            range_scale=self.prior.range_scale,
            scale_sigma=settings.scale_sigma_with_thermometer if is_scale_known else settings.scale_sigma,
            has_servo=self.has_servo,
            drifting=drifting,
            poses=poses,
            effective_sample_ratio=self.effective_sample_ratio,
            bias_sigma=self.shared_rounding(noise) if poses is None or poses.relative else self.bias_sigma,
            beam_prior=self.beam_prior if self.is_calibrated else None,
            manhattan_prior=self.manhattan_prior,
            bearings=self.has_heading_factors,
            servo=self.servo,
        )

    def shared_rounding(self, noise: float, icc: float = 0.0) -> float:
        """Return the standard deviation of the rounding error that readings of one distance share [m].

        Readings scatter by ``noise`` [m], with an intraclass correlation ``icc`` within a station.
        """
        before = (1.0 - icc) * noise**2 - self.rounding**2
        return shared_rounding_sigma(self.resolution, math.sqrt(max(before, 0.0)))

    def estimate_figure_of_merit(self) -> "Estimate":
        """Estimate figure of merit and beam from detections and non-detections; for ray cones, the cone angle."""
        fitted = estimated_sonar(self.measurements, self.model, self.features, prior_mean=self.prior.figure_of_merit)
        if fitted is self.model:
            return self
        return replace(self, model=fitted, beam_prior=(fitted.figure_of_merit, math.log(fitted.ka)))

    def estimate_noise(self) -> "Estimate":
        """Estimate the noise from the residuals, within its limits."""
        sigma = self.solution.robust_sigma if self.solution else math.nan
        if math.isnan(sigma):
            return self
        most = min(sigma, self.settings.max_sigma)
        return replace(self, noise=max(most, self.settings.min_sigma, self.rounding))

    def inlier_mask(self, features: Sequence[Hypothesis]) -> BoolArray:
        """Return which pings the landmarks or their multipath explain, shape (n,)."""
        explained: BoolArray = self.likelihood.log_densities(features) > self.likelihood.floor + math.log(20.0)
        return explained

    def information_inflation(self) -> float:
        """Return the factor by which readings are underweighted where poses are fixed, else 1.

        With fixed poses, errors of the sonar model are common to all readings of a landmark. The weights of readings
        stay low, and this factor only corrects the covariance.
        """
        return self.estimate_effective_sample_ratio() if self.pose_prior is None else 1.0

    def estimate_effective_sample_ratio(self) -> float:
        """Return the ratio of the effective sample size to the weight of the readings; 1 without a solution."""
        if (found := self.solution) is None:
            return 1.0
        return effective_sample_ratio(self.measurements, found.owners, found.residuals, noise=self.noise)

    def landmark_search(self, *, rounds: int | None = None) -> Search:
        """Return the search for landmarks that explain the pings; ``rounds`` limits it."""
        settings = self.settings.search
        if rounds is not None:
            settings = settings.model_copy(update={"max_rounds": rounds})
        return Search(self.likelihood, self.arcs, half_aperture=self.half_aperture, settings=settings)


def initial_noise(settings: EstimateSettings, resolution: float) -> float:
    """Return the initial standard deviation of a reading [m]: the setting, or more if readings are coarse."""
    return max(settings.initial_sigma, 0.9 * resolution)


def _detections(estimate: Estimate) -> BoolArray:
    """Return which stations (columns) detect which landmarks (rows)."""
    detected: BoolArray = np.array([each.llr_by_station for each in estimate.features]) > 0.0
    return detected


def _with_servo(estimate: Estimate, servo: ServoError) -> Estimate:
    """Return the estimate with another servo gain and offset, and the recorded bearings turned accordingly."""
    recorded = turned_by(estimate.recorded, error=servo, before=estimate.servo or AS_RECORDED)
    return replace(estimate, recorded=recorded, servo=servo)

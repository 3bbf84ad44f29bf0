"""An account of everything that was heard: features, sonar, noise and poses, better with every step."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.arrays import BoolArray, FloatArray
from echoplan.joint.arcs import find_arcs
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.marginal_prior import Course, Memory
from echoplan.joint.optimisation.attenuation import shadowed
from echoplan.joint.optimisation.effective_sample_size import independence, rounding_in_common
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.optimisation.manhattan import Squareness
from echoplan.joint.optimisation.optimiser import Priors, adjust
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses, continued, odometry_prior
from echoplan.joint.optimisation.range_factors import Features, as_arrays
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.sonar_model import expected_sonar, half_aperture_of, learned_sonar, walking
from echoplan.joint.optimisation.values import State
from echoplan.joint.search.boxes import with_boxes
from echoplan.joint.search.model_moves import reclassified
from echoplan.joint.search.multipath_walls import without_multipath_walls
from echoplan.joint.search.search import Search
from echoplan.joint.settings import AccountSettings
from echoplan.model import Odometry, Rig
from echoplan.preprocessing.measurements import Measurements, step_of
from echoplan.preprocessing.servo import AS_RECORDED, ServoError, turned_by

__all__ = ["Account"]

# No module is set right to less than this [m].
_FINEST = 0.001
# An adjustment is at rest once all that moves in a round does not move farther: the square, in deviations.
_SETTLED = 1e-5
# So often a first look may be taken, and second thoughts may be had.
_GLANCES = 3
# Features this far beyond the reach of the stations may still matter [m].
_AROUND = 0.5


class Account:
    """An account of everything heard: features, sonar, noise and poses, better with every step.

    Parameters
    ----------
    rig : Rig
        What heard it.
    measurements : Measurements
        The pings of s stations at hand.
    given : ndarray, shape (s, 3)
        Poses of these, as recorded [m, m, rad].
    settings : AccountSettings
        Settings of all stages.
    memory : Memory, optional
        What is known from stations before.
    """

    def __init__(
        self,
        rig: Rig,
        measurements: Measurements,
        given: FloatArray,
        settings: AccountSettings,
        memory: Memory | None = None,
    ) -> None:
        self.settings = settings
        self.memory = memory or Memory()
        self.resolution = max(sensor.resolution for sensor in rig.sensors)
        self.half_aperture = half_aperture_of(rig)
        # A table that says nothing is none.
        self._odometry = None if rig.odometry == Odometry() else rig.odometry
        self.trusts_specified_odometry = self.memory.trusts_specified_odometry
        self.prior = expected_sonar(rig, measurements, self.memory.model, walk=settings.walk)
        self.recorded = measurements
        # Gain and offset of the servo where it is calibrated; then the pings are turned accordingly.
        self.servo: ServoError | None = None
        self._first_servo = self.memory.servo or AS_RECORDED
        if self.memory.servo is not None:
            self._turn_servo(self.memory.servo)
        self.arcs = find_arcs(self.recorded, resolution=self.resolution, settings=settings.arcs)
        self.given, self.poses = given, continued(given, self.memory.poses)
        self.measurements = at_poses(self.recorded, given, self.poses)
        self.at_hand = self.memory.near(self.measurements.centers, _AROUND + measurements.max_range)
        self.model = self.memory.model or self.prior
        self.noise = self.first_noise if self.memory.is_empty else self.memory.noise
        self.features: list[Hypothesis] = self.known
        self.adjusted: Solution | None = None
        self.pose_prior: PosePrior | None = None
        self.course, self.verdict = Course.TRUSTED, "used as recorded, as asked for"
        self._square: Squareness | None = None
        self.is_polished, self.asks_bearings = False, self.servo is not None
        self.pair_sigma, self.loudness = settings.pose_errors.pair_sigma, self.memory.loudness
        # What it was worth before readings counted for less; none as long as they count in full [nats].
        self.penalised_llr: float | None = None
        self.independence = self.memory.independence
        self._explanation: tuple[tuple[Measurements, EchoModel, float], PingLikelihood] | None = None

    @property
    def known(self) -> list[Hypothesis]:
        """Features to start from."""
        return [*self.at_hand.features, *self.memory.pending]

    @property
    def explanation(self) -> PingLikelihood:
        """What explains the pings; the same as long as these, the sonar and the noise stay, for it remembers ghosts."""
        cause = (self.measurements, self.model, self.noise)
        if self._explanation is None or any(a is not b for a, b in zip(cause, self._explanation[0], strict=True)):
            before, hearing = self._explanation and self._explanation[1], self.model.tabulated()
            self._explanation = cause, PingLikelihood(self.measurements, hearing, self.noise, before=before)
        return self._explanation[1]

    @property
    def wheels(self) -> Odometry | None:
        """How far the rig says that steps lead astray, as far as it is believed."""
        return self._odometry if self.trusts_specified_odometry else None

    @property
    def step(self) -> float:
        """Turn from one ping to the next [rad]."""
        return step_of(self.measurements)

    @property
    def latency(self) -> float:
        """By how much the servo lags behind what was recorded [s]."""
        return self.adjusted.latency if self.adjusted else self.memory.latency

    @property
    def first_noise(self) -> float:
        """Standard deviation of readings before anything is known [m]; coarse steps alone make them scatter."""
        return max(self.settings.first_noise, 0.9 * self.resolution)

    @property
    def rounding(self) -> float:
        """Standard deviation of the error of rounding [m]: no noise is less."""
        return self.resolution / math.sqrt(12.0)

    @property
    def offset_sigma(self) -> float:
        """How well a maker sets a module right: within a step of its readings [m]."""
        return max(self.resolution, _FINEST) / math.sqrt(12.0)

    @property
    def drifts(self) -> bool:
        """Whether errors of the poses add up, as far as is known by now."""
        return self.pose_prior is not None and self.pose_prior.relative

    @property
    def squareness(self) -> Squareness | None:
        """What is believed of right angles between the features as they are now."""
        members: BoolArray = np.array([each.is_square for each in self.features], dtype=bool)
        return self._square._replace(members=members) if self._square is not None and members.any() else None

    @squareness.setter
    def squareness(self, pose_prior: Squareness | None) -> None:
        """Believe that some of the features stand square, and no others; each of them carries it from then on."""
        self._square = pose_prior
        members = np.zeros(len(self.features), dtype=bool) if pose_prior is None else pose_prior.members
        self.features = [replace(each, is_square=bool(e)) for each, e in zip(self.features, members, strict=True)]

    @property
    def is_along_axes(self) -> bool:
        """Whether walls are believed to stand along the axes of the map."""
        return self.squareness is not None and self.squareness.along_axes

    @property
    def has_servo(self) -> bool:
        """Whether anything turned while it listened."""
        return bool(np.any(self.recorded.rates))

    def calibrate(self, servo: ServoError) -> None:
        """Calibrate the servo: start from this gain and this offset, and let adjustments estimate them."""
        self._first_servo = servo
        self._turn_servo(servo)
        self.asks_bearings = True
        self.arcs = find_arcs(self.recorded, resolution=self.resolution, settings=self.settings.arcs)
        self.measurements = at_poses(self.recorded, self.given, self.poses)

    def restart_servo(self) -> None:
        """Let the servo be as it was before anything was explained: what poses in error made of it is wrong."""
        if self.servo is not None:
            self._turn_servo(self._first_servo)

    def _turn_servo(self, servo: ServoError) -> None:
        self.recorded = turned_by(self.recorded, error=servo, before=self.servo or AS_RECORDED)
        self.servo = servo

    def initialise(self) -> None:
        """Take a first look; and another where the air turns out to be warmer or colder than the modules assume."""
        for _ in range(_GLANCES):
            scale = self.model.range_scale
            self.search(rounds=1)
            self.adjust(self.first_noise)
            if abs(self.model.range_scale - scale) < self.settings.scale_step:
                break

    def explain(self) -> None:
        """Explain everything, learn the sonar from it, and explain it again."""
        if self.memory.is_empty:
            first = self.first_noise
            self.search()
            self.adjust(first)
            self.rescore(first)
            self.estimate_figure_of_merit()
            self.adjust(0.75 * first)
            self.estimate_noise()
        self.search()
        self.adjust(self.noise)
        self.prune_and_reclassify()
        self.adjust(self.noise)
        self.rescore(self.noise)

    def alternate(self, noise: float, priors: PosePrior | None, rounds: int) -> None:
        """Adjust features, sonar and poses until all stays the same, who hears what too, but no more than so often."""
        for _ in range(rounds):
            detected = self._detected()
            self.adjust(noise, priors)
            self.rescore(noise)
            if (
                self.adjusted is not None
                and self.adjusted.left < _SETTLED
                and np.array_equal(detected, self._detected())
            ):
                break

    def _detected(self) -> BoolArray:
        """Tell which features which stations hear, shape (f, s)."""
        measurements: BoolArray = np.array([each.llr_by_station for each in self.features]) > 0.0
        return measurements

    def refine_calibration(self) -> None:
        """Adjust loudness and beam as well, where poses do not drift: readings made late would pass for faint ones."""
        if not self.drifts:
            self.is_polished = True
            if self.settings.walk == "fitted" and self.memory.is_empty:
                self.model = walking(self.model, self.adjusted, self.noise)
                self.prior = replace(self.prior, walk=self.model.walk, walk_gain=self.model.walk_gain)
            # What is remembered of them came to rest before.
            self.alternate(self.noise, self.pose_prior, 3 if self.memory.is_empty else 1)

    def prune_and_reclassify(self) -> None:
        """Take features for what they are best taken for, and drop those that do not stand up."""
        search = self._search()
        self._settle(search, with_boxes(search, search.rescored(self.features)))

    def _settle(self, search: Search, features: list[Hypothesis]) -> None:
        self.features = search.settled(reclassified(search.explanation, features, search.acceptance))

    def reselect_classes(self) -> None:
        """Take features for something else as long as that explains more, now that all are where they belong."""
        for _ in range(_GLANCES):
            kinds, search = [each.kind for each in self.features], self._search()
            self._settle(search, search.rescored(self.features))
            if [each.kind for each in self.features] == kinds:
                break
            self.adjust(self.noise, self.pose_prior)
            self.rescore(self.noise)

    def clear(self) -> None:
        """Leave out walls that may be echoes by way of others; while poses are in error, real walls look like those."""
        search = self._search()
        kept = without_multipath_walls(search.explanation, self.features, search.acceptance)
        if len(kept) < len(self.features):
            self.features = kept
            self.adjust(self.noise, self.pose_prior)
            self.rescore(self.noise)

    def search(self, *, rounds: int | None = None) -> None:
        """Find the features that explain the pings, from those known; of stations still to come one round will do."""
        self.features = self._search(rounds=rounds).run(self.features)

    def rescore(self, noise: float) -> None:
        """Collect fresh evidence for the features."""
        self.noise = noise
        self.features = self._search().rescored(self.features)

    def adjust(self, noise: float, poses: PosePrior | None = None) -> None:
        """Adjust features and sonar, and poses if they may be off."""
        measurements = self.measurements if poses is None else self.recorded
        self.pose_prior = poses
        state = State(
            features=self.with_attenuation(self.features),
            model=self.model,
            latency=self.latency,
            servo=self.servo or AS_RECORDED,
            poses=self.poses if poses is not None else np.zeros((0, 3)),
        )
        known = self.at_hand.about(self.features, state.layout)
        self.adjusted = adjust(measurements, state, self.priors(noise, poses), self.settings.adjustment, known=known)
        self.model = self.adjusted.model
        self.features = [
            replace(each, reflector=row) for each, row in zip(self.features, self.adjusted.reflectors, strict=True)
        ]
        self._move()

    def _move(self) -> None:
        """Let the pings be where poses and servo are after an adjustment, if these are free."""
        assert self.adjusted is not None
        if self.pose_prior is not None:
            self.poses = self.adjusted.poses
        if self.servo is not None:
            self._turn_servo(self.adjusted.servo)
        if self.pose_prior is not None or self.servo is not None:
            self.measurements = at_poses(self.recorded, self.given, self.poses)

    def with_attenuation(self, features: Sequence[Hypothesis]) -> Features:
        """Turn features into arrays, with how much of each the stations hear."""
        return shadowed(self.measurements, self.model.tabulated(), as_arrays(features, len(self.given)))

    def odometry(self) -> PosePrior:
        """Believe in the steps of the robot."""
        priors = odometry_prior(self.given, self.settings.pose_errors, self.wheels)
        if self.at_hand.rest > len(SONAR_UNKNOWNS):
            # Where the first pose at hand is, the memory tells.
            priors.sigmas[0] = np.inf
        return priors

    def priors(self, noise: float, poses: PosePrior | None) -> Priors:
        """Tell what is believed of the sonar and the poses before the pings are asked."""
        settings, drifting = self.settings.adjustment, self.drifts or (poses is not None and poses.relative)
        # Where the way itself is uncertain it cannot tell the scale of the map: that is left to the sonar's maker.
        is_told = drifting or not math.isnan(self.recorded.temperature)
        return Priors(
            noise=noise,
            offset_sigma=self.offset_sigma,
            walk_gain=self.prior.walk_gain,
            range_scale=self.prior.range_scale,
            scale_sigma=settings.told_scale_sigma if is_told else settings.scale_sigma,
            has_servo=self.has_servo,
            drifting=drifting,
            poses=poses,
            independence=self.independence,
            pair_sigma=self.common_rounding(noise) if poses is None or poses.relative else self.pair_sigma,
            loudness=self.loudness if self.is_polished else None,
            squareness=self.squareness,
            bearings=self.asks_bearings,
            servo=self.servo,
        )

    def common_rounding(self, noise: float, common: float = 0.0) -> float:
        """Return the standard deviation of the common rounding error of readings of one distance [m].

        They scatter by the noise, of which a share is common to a station.
        """
        before = (1.0 - common) * noise**2 - self.rounding**2
        return rounding_in_common(self.resolution, math.sqrt(max(before, 0.0)))

    def estimate_figure_of_merit(self) -> None:
        """Take figure of merit and beam from who heard what; of rays, the cone."""
        fitted = learned_sonar(self.measurements, self.model, self.features, pose_prior=self.prior.figure_of_merit)
        if fitted is not self.model:
            self.model, self.loudness = fitted, (fitted.figure_of_merit, math.log(fitted.ka))

    def estimate_noise(self) -> None:
        """Take the noise from what is left of the readings."""
        scatter = self.adjusted.scatter if self.adjusted else math.nan
        if not math.isnan(scatter):
            self.noise = max(min(scatter, self.settings.greatest_noise), self.settings.least_noise, self.rounding)

    def explained(self, features: Sequence[Hypothesis]) -> BoolArray:
        """Tell which pings features or their ghosts explain."""
        explained: BoolArray = self.explanation.log_densities(features) > self.explanation.floor + math.log(20.0)
        return explained

    def refreshed(self) -> list[Hypothesis]:
        """Collect fresh evidence for the features, without keeping it."""
        return self._search().rescored(self.features)

    def information_inflation(self) -> float:
        """Tell how many times more the readings tell than they are let count for, where poses are trusted.

        There all that the model of the sonar lacks pulls at features alike, however many readings say so: their weights
        stay low.  Where poses are corrected they count in full.
        """
        return self.found_independence() if self.pose_prior is None else 1.0

    def found_independence(self) -> float:
        """Tell how far pings count by themselves, by what is left of them."""
        if self.adjusted is None:
            return 1.0
        return independence(self.measurements, self.adjusted.owners, self.adjusted.residuals, noise=self.noise)

    def _search(self, *, rounds: int | None = None) -> Search:
        settings = self.settings.search
        if rounds is not None:
            settings = settings.model_copy(update={"rounds": rounds})
        return Search(self.explanation, self.arcs, half_aperture=self.half_aperture, settings=settings)

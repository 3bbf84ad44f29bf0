"""The marginal prior: what remains of marginalised stations, so that a recording may have any length.

Landmarks keep the statistics of those stations. Their readings remain as a Gaussian prior of landmarks and sonar, with
the poses eliminated. Nothing else is kept, so memory grows with the map and not with the recording.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel
from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.factors import InformationPrior, LinearFactor, normal_equations
from echoplan.joint.optimisation.layout import Layout
from echoplan.joint.optimisation.values import Values
from echoplan.joint.pose_status import PoseModel, PoseStatus
from echoplan.joint.search.corner_echoes import CornerEcho, Echoes
from echoplan.preprocessing.servo import ServoError

__all__ = ["MarginalPrior", "marginalise_poses", "places_of"]


# Information on no unknown.
_NOTHING = InformationPrior(np.zeros(0, dtype=np.int64), np.zeros((0, 0)), np.zeros(0))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class MarginalPrior:
    """What is known from marginalised stations."""

    # Landmarks that these stations detected, with their track histories.
    features: Sequence[Hypothesis] = ()
    # Landmarks that only stations of the window detected.
    pending: Sequence[Hypothesis] = ()
    # Information on the parameters of ``features``, the sonar, and the first pose of the window if it is a variable: in
    # this order.
    summary: InformationPrior = _NOTHING
    # Echoes of the corners of two walls, by the track numbers of both.
    echoes: Mapping[tuple[int, int], CornerEcho] = field(default_factory=dict)
    # Estimated poses of the stations of the window that were in the previous window, too [m, m, rad], shape (k, 3).
    poses: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    pose_model: PoseModel = PoseModel.FIXED
    # The decision about the poses, with its reason.
    pose_status: PoseStatus = field(default_factory=PoseStatus)
    model: EchoModel | None = None
    # Latency of the servo [s].
    latency: float = 0.0
    # Gain and offset of the servo; None if it is not calibrated.
    servo: ServoError | None = None
    # Standard deviation of a reading [m].
    noise: float = np.nan
    # Estimated figure of merit [dB] and log ka.
    beam_prior: tuple[float, float] | None = None
    # Ratio of the effective sample size to the weight of the readings.
    effective_sample_ratio: float = 1.0
    # Whether the odometry noise is as the rig specifies.
    trusts_specified_odometry: bool = True
    # Standard deviations of the first pose of the window by odometry alone [m, m, rad], shape (3,).
    dead_reckoned: FloatArray = field(default_factory=lambda: np.zeros(3))
    # Number of track numbers assigned so far.
    issued: int = 0
    # Whether the landmarks are those of a map that was made before, which determines the scale.
    is_known_map: bool = False
    # Range scale of earlier recordings; NaN if there are none.
    range_scale: float = np.nan
    # Path of the robot in earlier recordings [m], shape (p, 2); a row of NaN ends each.
    path_xy: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def is_empty(self) -> bool:
        """Whether no station was marginalised yet."""
        return not len(self.summary.columns)

    @property
    def recordings(self) -> int:
        """Number of earlier recordings."""
        return int(np.isnan(self.path_xy[:, 0]).sum())

    def near(self, centers_xy: FloatArray, reach: float) -> "MarginalPrior":
        """Return the prior of the landmarks within ``reach`` [m] of any of the stations, shape (s, 2) [m].

        The other landmarks are marginalised out.
        """
        return self._of([each for each in self.features if _distance(each, centers_xy) < reach])

    def beyond(self, part: "MarginalPrior") -> list[Hypothesis]:
        """Return the landmarks that a part of this prior does not contain."""
        numbers = {each.history.number for each in part.features}
        return [each for each in self.features if each.history.number not in numbers]

    def reordered(self, features: Sequence[Hypothesis], layout: Layout) -> InformationPrior | None:
        """Return the prior of the variables of an optimisation, by their positions in its layout; None if it is empty.

        Landmarks of this prior that are not among ``features`` are marginalised out, and so is the pose if the layout
        has none.
        """
        if self.is_empty:
            return None
        part = self._of(features)
        numbers = {each.history.number: place for place, each in enumerate(features)}
        own = [places_of(layout, numbers[each.history.number]) for each in part.features]
        # With fixed poses the layout has no pose, so the first one is marginalised out.
        rest = np.arange(layout.sonar, layout.size)[: part.rest]
        summary = part.summary.marginalised_onto(np.arange(_sizes(part.features) + len(rest)))
        return summary._replace(columns=np.concatenate([*own, rest]).astype(np.int64))

    @property
    def rest(self) -> int:
        """Number of variables besides the parameters of landmarks."""
        return len(self.summary.columns) - _sizes(self.features)

    def corner_echoes_of(self, features: Sequence[Hypothesis]) -> Echoes:
        """Return the echoes of corners between landmarks of this prior, by their positions in ``features``."""
        places = {each.history.number: place for place, each in enumerate(features)}
        pairs = {
            (min(places[one], places[other]), max(places[one], places[other])): echo
            for (one, other), echo in self.echoes.items()
            if one in places and other in places
        }
        return Echoes.of(features, pairs)

    def _of(self, features: Sequence[Hypothesis]) -> "MarginalPrior":
        """Return the prior of some of the landmarks; the others are marginalised out."""
        wanted, places, kept, start = {each.history.number for each in features}, [], [], 0
        for each in self.features:
            size = len(each.parameters)
            if each.history.number in wanted:
                kept.append(each)
                places.append(np.arange(start, start + size))
            start += size
        places.append(np.arange(start, len(self.summary.columns)))
        return replace(self, features=kept, summary=self.summary.marginalised_onto(np.concatenate(places)))


def marginalise_poses(
    state: Values, rows: Sequence[LinearFactor], known: InformationPrior | None, poses: int
) -> InformationPrior:
    """Eliminate the first ``poses`` poses from the normal equations (Schur complement).

    Landmarks, sonar and the remaining poses keep the information of the factors, which are linearised at ``state``, and
    of the previous prior ``known``, whose columns are positions in the same layout.
    """
    layout = state.layout
    information, vector = normal_equations(rows, layout.size)
    vector += information @ state.values
    if known is not None:
        information[np.ix_(known.columns, known.columns)] += known.information
        vector[known.columns] += known.vector
    first, last = layout.pose, layout.pose + 3 * min(poses, layout.poses)
    kept = np.concatenate([np.arange(first), np.arange(last, layout.size)])
    return InformationPrior(np.arange(layout.size), information, vector).marginalised_onto(kept)


def places_of(layout: Layout, feature: int) -> IntArray:
    """Return the positions of the parameters of a landmark in the vector of all variables."""
    return np.arange(layout.size)[layout.feature(feature)]


def _sizes(features: Sequence[Hypothesis]) -> int:
    return sum(len(each.parameters) for each in features)


def _distance(feature: Hypothesis, centers_xy: FloatArray) -> float:
    """Return the least distance of a landmark from any of some points, shape (s, 2) [m]."""
    if not feature.is_wall:
        away: FloatArray = np.hypot(*(centers_xy - feature.reflector[1:3]).T)
        return float(np.abs(away - feature.reflector[3]).min())
    normal, along = directions(feature.line[0]), directions(feature.line[0] + np.pi / 2)
    places = centers_xy @ along
    beside = places - np.clip(places, *feature.extent)
    return float(np.hypot(feature.line[1] - centers_xy @ normal, beside).min())

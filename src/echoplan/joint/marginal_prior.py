"""MarginalPrior: what stays of stations whose pings were let go, so that a map can grow without end.

Features keep what was said of them; the readings keep what they said of features and sonar, as information with the
poses eliminated.  Nothing else stays, so memory grows with the map and not with the way.
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
from echoplan.joint.search.specular_points import CornerEcho, Echoes
from echoplan.preprocessing.servo import ServoError

__all__ = ["MarginalPrior", "marginalise_poses", "places_of"]


def _nothing() -> InformationPrior:
    return InformationPrior(np.zeros(0, dtype=np.int64), np.zeros((0, 0)), np.zeros(0))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class MarginalPrior:
    """What is known from stations that were let go.

    Parameters
    ----------
    features : sequence of Hypothesis, optional
        All features that they heard, with their pasts.
    pending : sequence of Hypothesis, optional
        Features that only stations at hand heard.
    summary : InformationPrior, optional
        What they said of the parameters of the features, of the sonar, and of the first pose at hand if it is free:
        in this order.
    echoes : mapping of tuple of int to CornerEcho, optional
        What they heard of the corners of two walls, by the numbers of both.
    poses : ndarray, shape (k, 3), optional
        Poses of the stations that are at hand and were heard before [m, m, rad].
    pose_model : PoseModel, optional
        How they came about.
    pose_status : PoseStatus, optional
        Why.
    model : EchoModel, optional
        The sonar.
    latency : float, optional
        Of the servo [s].
    servo : ServoError, optional
        Its gain and offset, where it is calibrated.
    noise : float, optional
        Standard deviation of readings [m].
    beam_prior : tuple of float, optional
        Figure of merit [dB] and logarithm of the beam's ka as told by who heard what.
    effective_sample_ratio : float, optional
        How many times more readings count than their weights say.
    trusts_specified_odometry : bool, optional
        Whether steps lead no farther astray than the rig tells.
    dead_reckoned : ndarray, shape (3,), optional
        What odometry alone leaves open of the first pose at hand, as standard deviations [m, m, rad].
    issued : int, optional
        How many numbers features have been given.
    """

    features: Sequence[Hypothesis] = ()
    pending: Sequence[Hypothesis] = ()
    summary: InformationPrior = field(default_factory=_nothing)
    echoes: Mapping[tuple[int, int], CornerEcho] = field(default_factory=dict)
    poses: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    pose_model: PoseModel = PoseModel.FIXED
    pose_status: PoseStatus = field(default_factory=PoseStatus)
    model: EchoModel | None = None
    latency: float = 0.0
    servo: ServoError | None = None
    noise: float = np.nan
    beam_prior: tuple[float, float] | None = None
    effective_sample_ratio: float = 1.0
    trusts_specified_odometry: bool = True
    dead_reckoned: FloatArray = field(default_factory=lambda: np.zeros(3))
    issued: int = 0

    @property
    def is_empty(self) -> bool:
        """Whether nothing was let go yet."""
        return not len(self.summary.columns)

    def near(self, centers_xy: FloatArray, reach: float) -> "MarginalPrior":
        """Keep what stations may hear.

        Parameters
        ----------
        centers_xy : ndarray, shape (s, 2)
            The stations [m].
        reach : float
            How far they hear [m].

        Returns
        -------
        MarginalPrior
            Of the features within reach of any of them, whatever the others are.
        """
        return self._of([each for each in self.features if _distance(each, centers_xy) < reach])

    def beyond(self, part: "MarginalPrior") -> list[Hypothesis]:
        """List the features that are not in a part of this."""
        active_prior = {each.history.number for each in part.features}
        return [each for each in self.features if each.history.number not in active_prior]

    def reordered(self, features: Sequence[Hypothesis], layout: Layout) -> InformationPrior | None:
        """Tell what is known of unknowns that are to be adjusted.

        Parameters
        ----------
        features : sequence of Hypothesis
            The features; what is known of others is left aside.
        layout : Layout
            What stands where: the features in their order, sonar and poses.

        Returns
        -------
        InformationPrior or None
            By the places of the unknowns; None if nothing is known.
        """
        if self.is_empty:
            return None
        part = self._of(features)
        numbers = {each.history.number: place for place, each in enumerate(features)}
        own = [places_of(layout, numbers[each.history.number]) for each in part.features]
        # Where poses are trusted, what was said of the first one is left aside.
        rest = np.arange(layout.sonar, layout.size)[: part.rest]
        summary = part.summary.marginalised_onto(np.arange(_sizes(part.features) + len(rest)))
        return summary._replace(columns=np.concatenate([*own, rest]).astype(np.int64))

    @property
    def rest(self) -> int:
        """How many unknowns there are beside those of the features."""
        return len(self.summary.columns) - _sizes(self.features)

    def corner_echoes_of(self, features: Sequence[Hypothesis]) -> Echoes:
        """Tell what was heard of corners, by the places of features in a list.

        Parameters
        ----------
        features : sequence of Hypothesis
            Features of this memory.

        Returns
        -------
        Echoes
            Of their pairs, and the corners among them.
        """
        places = {each.history.number: place for place, each in enumerate(features)}
        pairs = {
            (min(places[one], places[other]), max(places[one], places[other])): detected
            for (one, other), detected in self.echoes.items()
            if one in places and other in places
        }
        return Echoes.of(features, pairs)

    def _of(self, features: Sequence[Hypothesis]) -> "MarginalPrior":
        """Keep what is known of some features: the others are eliminated."""
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
    """Sum up what rows and older knowledge say of features and sonar, and of the pose that comes next.

    Parameters
    ----------
    state : Values
        Where everything is; the rows are linearised there.
    rows : sequence of LinearFactor
        Of the readings and poses that are let go.
    known : InformationPrior or None
        What was known before, by the places of the same unknowns.
    poses : int
        How many of the poses are let go; those after them stay.

    Returns
    -------
    InformationPrior
        With those poses eliminated.
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
    """Tell where the parameters of a feature stand.

    Parameters
    ----------
    layout : Layout
        What stands where.
    feature : int
        Its number.

    Returns
    -------
    ndarray of int
        Their places.
    """
    return np.arange(layout.size)[layout.feature(feature)]


def _sizes(features: Sequence[Hypothesis]) -> int:
    return sum(len(each.parameters) for each in features)


def _distance(feature: Hypothesis, centers_xy: FloatArray) -> float:
    """Least distance of a feature from any of some places [m]."""
    if not feature.is_wall:
        away: FloatArray = np.hypot(*(centers_xy - feature.reflector[1:3]).T)
        return float(away.min())
    normal, along = directions(feature.line[0]), directions(feature.line[0] + np.pi / 2)
    places = centers_xy @ along
    beside = places - np.clip(places, *feature.extent)
    return float(np.hypot(feature.line[1] - centers_xy @ normal, beside).min())

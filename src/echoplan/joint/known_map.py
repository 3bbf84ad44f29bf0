"""A map that was made before, as the prior of an estimate: its landmarks with their covariances."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, wrap
from echoplan.joint.landmarks import LANDMARKS
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_PING_SCORES
from echoplan.joint.likelihood.track_history import TrackHistory
from echoplan.joint.map_extraction.endpoint_views import OFFSETS
from echoplan.joint.map_extraction.segment import Segment
from echoplan.joint.map_extraction.segments import SegmentSettings, find_segments
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.optimisation.factors import InformationPrior
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.pose_status import PoseModel, PoseReason, PoseStatus
from echoplan.model import ClassProbabilities, CornerKind, FeatureMap, Wall

__all__ = ["known_landmarks", "prior_of_map", "resumed", "views_of"]

# Log-likelihood ratio of a landmark of the map [nats]: it stays even if it is not detected again.
_CERTAIN_LLR = 1e4
# Least standard deviation of a parameter of a landmark [m or rad]: some methods write maps without uncertainties.
_MIN_SIGMA = 1e-4
# Log-likelihood ratio that earlier recordings leave to a landmark [nats]: two stations that miss it entirely, with 12
# nats each, take it below the 12 with which a landmark is accepted.
_PERSISTENT_LLR = 36.0
# Log-likelihood ratio of a wall at the foot of a station from which the station detected it [nats].
_CLEAR_LLR = 5.0
# Angle and distance between the line of a landmark and a wall that is part of it [rad, m], and how far past the ends of
# a wall specular points may lie, as these ends are uncertain [m].
_SAME_ANGLE, _SAME_OFFSET, _PAST_END = 0.1, 0.05, 0.1
# Standard deviations of a first pose that scan matching found [m, m, rad].
_FIRST_SIGMAS = np.array([0.05, 0.05, np.radians(3.0)])


def known_landmarks(feature_map: FeatureMap) -> tuple[list[Hypothesis], list[FloatArray]]:
    """Return the walls, detected corners and cylinders of a map as landmarks, and the covariances of their parameters.

    Walls on one line, such as both sides of a door, are one landmark. Corners at which only walls cross are none.
    """
    rows = [*_lines(feature_map.walls)]
    for corner in feature_map.corners:
        if corner.pings:
            kind = Kind.CORNER if corner.kind is CornerKind.CONCAVE else Kind.EDGE
            rows.append((np.array([kind, *corner.position_xy, 0.0]), (0.0, 0.0), corner.covariance))
    rows += [
        (np.array([Kind.CYLINDER, *each.center_xy, each.radius]), (0.0, 0.0), each.covariance)
        for each in feature_map.cylinders
    ]
    landmarks = [_landmark(number, row[0], extent=row[1]) for number, row in enumerate(rows, start=1)]
    return landmarks, [covariance for _, _, covariance in rows]


def prior_of_map(feature_map: FeatureMap, pose: FloatArray, *, noise: float) -> MarginalPrior:
    """Return the prior of an estimate that goes on in a map, from a first pose that scan matching found.

    ``pose`` has shape (3,) [m, m, rad]; ``noise`` is the standard deviation of a reading [m].
    Covariances between landmarks are not in the file of a map: they count as zero.
    """
    landmarks, covariances = known_landmarks(feature_map)
    floored = [each + _MIN_SIGMA**2 * np.eye(len(each)) for each in covariances]
    nothing = np.zeros((len(SONAR_UNKNOWNS), len(SONAR_UNKNOWNS)))
    information = block_diag(*map(np.linalg.inv, floored), nothing, np.diag(_FIRST_SIGMAS**-2.0))
    values = np.concatenate([*(each.parameters for each in landmarks), np.zeros(len(SONAR_UNKNOWNS)), pose])
    return MarginalPrior(
        features=landmarks,
        summary=InformationPrior(np.arange(len(values)), information, information @ values),
        poses=pose[None],
        pose_model=PoseModel.ODOMETRY,
        pose_status=PoseStatus(reason=PoseReason.ODOMETRY),
        noise=noise,
        issued=len(landmarks),
        is_known_map=True,
    )


def resumed(prior: MarginalPrior, pose: FloatArray, settings: SegmentSettings) -> MarginalPrior:
    """Return the prior of an estimate that goes on with another recording, all stations so far being marginalised.

    Landmarks keep their histories and their joint information, the servo its gain and offset. But a landmark may have
    been moved since: however often it was detected, two stations that miss it remove it. Only a line with several walls
    stays: a station before the gap between two of them seems to miss it. Sonar and latency begin anew, except for the
    range scale: a drive cannot determine it once the robot leaves what is known, so the air counts as equally warm.
    ``pose`` is the first one of the recording, shape (3,) [m, m, rad]; ``settings`` are those of wall segments.
    """
    count = sum(len(each.parameters) for each in prior.features)
    known = prior.summary.marginalised_onto(np.arange(count))
    nothing = np.zeros((len(SONAR_UNKNOWNS), len(SONAR_UNKNOWNS)))
    information = np.diag(_FIRST_SIGMAS**-2.0)
    return MarginalPrior(
        features=_persistent(prior, settings),
        summary=InformationPrior(
            np.arange(count + len(nothing) + 3),
            block_diag(known.information, nothing, information),
            np.concatenate([known.vector, np.zeros(len(nothing)), information @ pose]),
        ),
        echoes=prior.echoes,
        poses=pose[None],
        pose_model=PoseModel.ODOMETRY,
        pose_status=PoseStatus(reason=PoseReason.ODOMETRY),
        servo=prior.servo,
        noise=prior.noise,
        issued=prior.issued,
        range_scale=prior.range_scale if prior.model is None else prior.model.range_scale,
        path_xy=np.vstack([prior.path_xy, np.full((1, 2), np.nan)]),
    )


def without_walls(prior: MarginalPrior, walls: Sequence[Wall]) -> MarginalPrior:
    """Return the prior without what was detected of some walls, since these are there no more.

    A landmark of which nothing else was detected is left without evidence, so that the next search removes it.
    """
    features = list(prior.features)
    for wall in walls:
        features = [_without_piece(each, wall) if _is_part(wall, each) else each for each in features]
    return replace(prior, features=features)


def _is_part(wall: Wall, landmark: Hypothesis) -> bool:
    """Return True if a wall lies on the line of a landmark."""
    if not landmark.is_wall:
        return False
    turned, away = wrap(wall.normal_angle - landmark.line[0]), wall.offset - landmark.line[1]
    return bool(abs(turned) < _SAME_ANGLE and abs(away) < _SAME_OFFSET)


def _without_piece(landmark: Hypothesis, wall: Wall) -> Hypothesis:
    """Return a landmark without the evidence about a wall on its line."""
    history, places = landmark.history, wall.endpoints_xy @ directions(landmark.line[0] + np.pi / 2)
    low, high = places.min() - _PAST_END, places.max() + _PAST_END
    line = history.line.chosen((history.line.feet < low) | (history.line.feet > high))
    feet = history.feet[(history.feet < low) | (history.feet > high)]
    history = replace(history, line=line, feet=feet)
    if not (line.log_ratios[:, :, 0] > 0.0).all(axis=1).any():
        history = replace(history, llr=0.0, best_llr=0.0, supporting=0)
    return replace(landmark, llr=history.llr, history=history)


def views_of(prior: MarginalPrior) -> FloatArray:
    """Return lines of sight along which stations detected walls, shape (v, 2, 2) [m]: station and foot on the wall."""
    views = [np.zeros((0, 2, 2))]
    for wall in (each for each in prior.features if each.is_wall):
        seen = wall.history.line
        # The first column is of a wall that goes on past the foot.
        clear = seen.log_ratios[:, :, 0].min(axis=1, initial=np.inf) > _CLEAR_LLR
        normal = directions(wall.line[0])
        feet = wall.line[1] * normal + seen.feet[:, None] * np.array([-normal[1], normal[0]])
        views.append(np.stack([seen.centers_xy, feet], axis=1)[clear])
    return np.concatenate(views)


def _persistent(prior: MarginalPrior, settings: SegmentSettings) -> list[Hypothesis]:
    """Return the landmarks, of which those that are one piece may have been moved since they were detected."""
    segments = find_segments(prior.features, prior.corner_echoes_of(prior.features), prior.path_xy, settings)
    parts: dict[int, list[Segment]] = {}
    for each in segments:
        parts.setdefault(each.owner, []).append(each)
    return [
        _movable(each) if _is_one_piece(each, parts.get(number, [])) else each
        for number, each in enumerate(prior.features)
    ]


def _is_one_piece(landmark: Hypothesis, segments: Sequence[Segment]) -> bool:
    """Return True if a landmark is no wall, or one segment that reaches as far as its line was detected.

    By diffraction, a wall is detected a little past its ends: ``OFFSETS`` ends where that is impossible.
    """
    if not landmark.is_wall:
        return True
    low, high = landmark.extent
    return len(segments) == 1 and max(segments[0].low - low, high - segments[0].high) < OFFSETS[-1]


def _movable(landmark: Hypothesis) -> Hypothesis:
    """Return a landmark with a log-likelihood ratio that two stations outweigh."""
    llr = min(landmark.llr, _PERSISTENT_LLR)
    history = replace(landmark.history, llr=llr, best_llr=min(landmark.history.best_llr, llr / 2.0))
    return replace(landmark, llr=llr, history=history)


def _lines(walls: tuple[Wall, ...]) -> Iterator[tuple[FloatArray, tuple[float, float], FloatArray]]:
    """Yield reflector, extent and covariance of each line with walls."""
    lines: dict[tuple[float, float], list[Wall]] = {}
    for wall in walls:
        lines.setdefault((wall.normal_angle, wall.offset), []).append(wall)
    for (normal_angle, offset), own in lines.items():
        along = directions(normal_angle + np.pi / 2)
        places = np.concatenate([wall.endpoints_xy @ along for wall in own])
        reflector = np.array([Kind.WALL, normal_angle, offset, own[0].reflection_loss])
        yield reflector, (float(places.min()), float(places.max())), own[0].covariance


def _landmark(number: int, reflector: FloatArray, *, extent: tuple[float, float]) -> Hypothesis:
    """Return a landmark that counts as detected by more stations than any that a recording adds."""
    feature_class = LANDMARKS[Kind(int(reflector[0]))].feature_class
    history = TrackHistory(
        number=number,
        llr=_CERTAIN_LLR,
        best_llr=_CERTAIN_LLR / 2.0,
        supporting=3,
        extent=extent,
        probabilities=ClassProbabilities(**{feature_class: 1.0}),
        certainty=_CERTAIN_LLR,
    )
    return Hypothesis(
        reflector=reflector,
        ping_scores=NO_PING_SCORES,
        llr_by_station=np.zeros(0),
        llr=_CERTAIN_LLR,
        extent=extent,
        history=history,
    )

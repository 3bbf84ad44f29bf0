"""Legacy: what stations leave behind when their pings are let go, and the map that all of them together make."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.joint.estimate import Account
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_EVIDENCE
from echoplan.joint.likelihood.track_history import LineEvidence, Past
from echoplan.joint.map_extraction.corners import find_vertices
from echoplan.joint.map_extraction.endpoint_views import line_evidence
from echoplan.joint.map_extraction.map_builder import Survey
from echoplan.joint.map_extraction.segment import CELL
from echoplan.joint.map_extraction.segments import find_segments
from echoplan.joint.marginal_prior import Memory, summarised
from echoplan.joint.optimisation.factors import Summary
from echoplan.joint.optimisation.manhattan import learn_squareness
from echoplan.joint.optimisation.optimiser import adjust, facing_rows, reading_rows
from echoplan.joint.optimisation.pose_factors import PoseBeliefs, pose_rows
from echoplan.joint.optimisation.range_factors import as_arrays
from echoplan.joint.optimisation.values import State
from echoplan.joint.search.alternatives import class_probabilities
from echoplan.joint.search.occlusion import hiding
from echoplan.joint.search.ray_paths import Paths, free_views, trace_paths
from echoplan.joint.search.specular_points import CornerEcho, corner_echoes
from echoplan.joint.trace import Decision, Reason, record_event
from echoplan.joint.trajectory import reckoned
from echoplan.model import ClassProbabilities, FeatureClass
from echoplan.preprocessing.ping_arrays import chosen_soundings
from echoplan.preprocessing.servo import AS_RECORDED

__all__ = ["leave", "survey"]

# Of all places along a wall within one cell, so many are worth keeping [m].
_CELL, _KEPT = 0.01, 4
# A feature whose own class is less probable is none.
_UNLIKELY = 0.05
# Where feet of a wall are farther apart than this, sound may have gone through between them [m].
_WIDE_GAP = 0.4


def survey(account: Account, path_xy: FloatArray) -> Survey:
    """Draw all that was ever found.

    Parameters
    ----------
    account : Account
        Of the stations at hand, with the memory of all before them.
    path_xy : ndarray, shape (p, 2)
        The way of the robot from the first station on [m].

    Returns
    -------
    Survey
        What is there, adjusted once more to all that is known.
    """
    memory, settings = leave(account, len(account.given)), account.settings
    found = [each for each in memory.features if _is_there(each)]
    for each in memory.features:
        if not _is_there(each):
            record_event(Decision.REMOVED, each, reason=Reason.INCONSISTENT)
    state = State(
        features=as_arrays(found, 0),
        model=account.model,
        latency=memory.latency,
        servo=memory.servo or AS_RECORDED,
    )
    nothing = chosen_soundings(account.recorded, np.zeros(len(account.recorded.readings), dtype=bool))
    beliefs = account.beliefs(account.noise, None)._replace(squareness=None, understated=account.understated())
    known = memory.about(found, state.unknowns)
    adjusted = adjust(nothing, state, beliefs, settings.adjustment, known=known)
    square = learn_squareness(adjusted.reflectors, adjusted.unknowns, adjusted.covariance, settings.squareness)
    if square is not None:
        # Where way-points put the axes is told while they are still known one by one.
        square = square._replace(along_axes=account.is_along_axes)
        adjusted = adjust(nothing, state, beliefs._replace(squareness=square), settings.adjustment, known=known)
    features = [replace(each, reflector=row) for each, row in zip(found, adjusted.reflectors, strict=True)]
    echoes = memory.echoes_of(features)
    segments = find_segments(features, echoes, path_xy, settings.segments)
    # What the model of the sonar lacks does not average out over many stations.
    lacking = settings.adjustment
    best = min(beliefs.offset_sigma, lacking.offset_floor)
    return Survey(
        features=features,
        adjusted=replace(adjusted, offset_sigma=best, model_error=lacking.model_error),
        segments=segments,
        vertices=find_vertices(segments, echoes, settings.vertices),
        squareness=square,
        settings=settings.survey,
        path_xy=path_xy,
    )


def _is_there(feature: Hypothesis) -> bool:
    """Return True if a feature probably is of its class, and most of the stations that should detect it did.

    A few stations can always be found that a false feature explains a little better, and the more of them, the longer
    a recording is.  So most stations that detected it must have done so past all walls, and, but for points, which
    return little sound, most that should have detected it must have done so.  A wall through which half as many pings
    passed as it reflected is none, nor is a feature that explains no ping best.
    """
    past = feature.past
    if _own_probability(feature) < _UNLIKELY:
        return False
    if past.speaking - past.hidden < past.hidden or 2 * past.passed >= past.pings:
        return False
    return feature.kind not in (Kind.WALL, Kind.CYLINDER) or past.speaking >= past.missing


def _own_probability(feature: Hypothesis) -> float:
    """Return the probability of the class that a feature is taken for."""
    own = {Kind.WALL: FeatureClass.WALL, Kind.CYLINDER: FeatureClass.CYLINDER}.get(feature.kind, FeatureClass.CORNER)
    probability: float = getattr(feature.past.probabilities, own)
    return probability


def leave(account: Account, count: int) -> Memory:
    """Let the first stations go, and keep what they said.

    Parameters
    ----------
    account : Account
        Of the stations at hand, explained and adjusted.
    count : int
        How many stations to let go.

    Returns
    -------
    Memory
        All that is known without the pings of the stations that stay.
    """
    gone = account.recorded.stations < count
    features = _with_pasts(account, _going(account, gone, count))
    known = [each for each in features if each.is_known]
    everything = [*account.memory.beyond(account.at_hand), *known]
    echoes = dict(account.memory.echoes)
    for (one, other), heard in corner_echoes(account.explanation, account.features, count).items():
        if heard != CornerEcho() and features[one].is_known and features[other].is_known:
            pair = (features[one].past.number, features[other].past.number)
            key = min(pair), max(pair)
            echoes[key] = echoes.get(key, CornerEcho()).joined(heard)
    return Memory(
        features=[_bare(each) for each in everything],
        pending=[each for each in features if not each.is_known],
        summary=_summary(account, everything, gone, count),
        echoes=echoes,
        poses=account.poses[count:],
        course=account.course,
        verdict=account.verdict,
        model=account.model,
        latency=account.latency,
        servo=account.servo,
        noise=account.noise,
        loudness=account.loudness,
        independence=account.independence,
        believes_rig=account.believes_rig,
        reckoned=_reckoned(account, count),
        issued=account.memory.issued + len(known),
    )


def _reckoned(account: Account, count: int) -> FloatArray:
    """Tell what odometry alone leaves open of the first pose that stays."""
    if account.believed is None or not account.believed.relative or count >= len(account.given):
        return np.zeros(3)
    return np.sqrt(np.diag(reckoned(account)[count]))


def _summary(account: Account, everything: list[Hypothesis], gone: BoolArray, count: int) -> Summary:
    """Sum up what the readings of the stations that go said, with their poses eliminated."""
    believed = _believed(account, count)
    state = State(
        features=account.as_heard(everything),
        model=account.model,
        latency=account.latency,
        servo=account.servo or AS_RECORDED,
        poses=np.zeros((0, 3)) if believed is None else account.poses[: len(believed.given)],
    )
    heard = chosen_soundings(account.recorded if believed else account.soundings, gone)
    heard = heard._replace(centers=heard.centers[: len(believed.given)]) if believed else heard
    beliefs = account.beliefs(account.noise, believed)
    rows = [reading_rows(heard, state, beliefs, account.settings.adjustment)]
    rows.append(facing_rows(heard, state, beliefs))
    if believed:
        rows.append(pose_rows(believed, state.poses, state.unknowns.pose))
    return summarised(state, rows, account.memory.about(everything, state.unknowns), count)


def _believed(account: Account, count: int) -> PoseBeliefs | None:
    """Believe in the poses that go, and in the step to the next."""
    if account.believed is None:
        return None
    kept = count + 1 if account.believed.relative else count
    return account.believed._replace(given=account.believed.given[:kept], sigmas=account.believed.sigmas[:kept])


class _Going(NamedTuple):
    """How many stations go; which pings are theirs, by which ways these came, what was in them, and whose they are."""

    size: int
    pings: BoolArray
    paths: Paths
    hidden: BoolArray
    passed: BoolArray
    owners: IntArray
    stations: IntArray
    lines: dict[int, LineEvidence]


def _going(account: Account, gone: BoolArray, count: int) -> _Going:
    assert account.adjusted is not None
    paths = trace_paths(account.explanation, account.features, step=account.step)
    hides = hiding(paths, account.features, gap=_WIDE_GAP)
    return _Going(
        size=count,
        pings=gone,
        paths=paths.chosen(gone),
        hidden=hides.hidden[gone],
        passed=hides.passed[:, gone],
        owners=account.adjusted.owners[gone],
        stations=account.soundings.stations[gone],
        lines=_lines(account, count),
    )


def _lines(account: Account, count: int) -> dict[int, LineEvidence]:
    """Collect what the first stations say of where the line of each wall is wall."""
    features, left_out = account.features, account.explanation.levels_without(account.features)
    return {
        number: line_evidence(account.explanation, each, count, levels)
        for number, (each, levels) in enumerate(zip(features, left_out, strict=True))
        if each.is_wall
    }


def _with_pasts(account: Account, going: _Going) -> list[Hypothesis]:
    """Add what the stations that go said to the pasts of the features that they heard."""
    radius_cost, issued = account.settings.search.radius_cost, account.memory.issued
    classes = class_probabilities(account.explanation, account.features, radius_cost=radius_cost)
    features = []
    for number, (each, probabilities) in enumerate(zip(account.features, classes, strict=True)):
        if each.is_known or (each.gains[: going.size] > 0.0).any():
            issued += not each.is_known
            past = each.past if each.is_known else replace(each.past, number=issued)
            past = _certain(_sounded(past, number, account, going), each, probabilities)
            features.append(replace(each, past=_counted(past, number, account, going)))
        else:
            features.append(each)
    return features


def _counted(past: Past, number: int, account: Account, going: _Going) -> Past:
    """Add how many stations and pings spoke for a feature, and how many against it."""
    each, count = account.features[number], going.size
    gains, free = each.gains[:count], free_views(each, account.soundings, step=account.step)[:count]
    clear = gains > account.settings.survey.clear_station
    through = _mostly(going.hidden, going.paths.owners == number, going.stations, count)
    return replace(
        past,
        total=past.total + float(gains.sum()),
        best=max(past.best, float(gains.max(initial=0.0))),
        speaking=past.speaking + int(clear.sum()),
        missing=past.missing + int((free & ~clear).sum()),
        hidden=past.hidden + int((through & clear).sum()),
        passed=past.passed + int(going.passed[number].sum()),
        pings=past.pings + int((going.owners == number).sum()),
    )


def _mostly(which: BoolArray, own: BoolArray, stations: IntArray, count: int) -> BoolArray:
    """Tell of which stations most of their own pings are among some."""
    most: BoolArray = 2 * np.bincount(stations[own & which], minlength=count) > np.bincount(
        stations[own], minlength=count
    )
    return most


def _sounded(past: Past, number: int, account: Account, going: _Going) -> Past:
    """Add where sound came back from a wall, went through its line, or should have come back and did not."""
    wall, paths = account.features[number], going.paths
    if not wall.is_wall:
        return past
    return replace(
        past,
        extent=wall.extent,
        feet=_joined(past.feet, paths.feet(number, wall.line)),
        crossings=_joined(past.crossings, paths.crossings(number, wall.line)),
        line=_thinned(past.line.joined(going.lines[number])),
    )


def _certain(past: Past, feature: Hypothesis, probabilities: ClassProbabilities) -> Past:
    """Keep the class as it was told by those who heard most of the feature."""
    certainty = feature.total - feature.past.total
    return replace(past, probabilities=probabilities, certainty=certainty) if certainty > past.certainty else past


def _joined(before: FloatArray, now: FloatArray) -> FloatArray:
    """Join places along a line [m]: of many in one cell a few are kept, if some of them were there before."""
    if not len(before):
        return np.sort(now)
    places = np.sort(np.concatenate([before, now]))
    kept: FloatArray = places[_first_of_cells(places, _CELL)]
    return kept


def _thinned(line: LineEvidence) -> LineEvidence:
    """Keep a few stations of each cell, so that memory grows with the map and not with the recording."""
    ordered = line.chosen(np.argsort(line.feet, kind="stable"))
    return ordered.chosen(_first_of_cells(ordered.feet, CELL))


def _first_of_cells(places: FloatArray, size: float) -> BoolArray:
    cells = np.floor(places / size)
    first: BoolArray = np.arange(len(places)) - np.searchsorted(cells, cells) < _KEPT
    return first


def _bare(feature: Hypothesis) -> Hypothesis:
    """Leave out all that belongs to pings at hand."""
    return replace(feature, evidence=NO_EVIDENCE, gains=np.zeros(0), total=feature.past.total, is_square=False)

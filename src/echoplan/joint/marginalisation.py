"""Marginalisation of the oldest stations, and the map of all stations together."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_PING_SCORES
from echoplan.joint.likelihood.track_history import LineEvidence, TrackHistory
from echoplan.joint.map_extraction.corners import find_vertices
from echoplan.joint.map_extraction.endpoint_views import line_evidence
from echoplan.joint.map_extraction.map_builder import MapBuilder
from echoplan.joint.map_extraction.round_walls import lies_on
from echoplan.joint.map_extraction.segment import CELL
from echoplan.joint.map_extraction.segments import find_segments
from echoplan.joint.marginal_prior import MarginalPrior, marginalise_poses
from echoplan.joint.optimisation.factors import InformationPrior, normal_equations
from echoplan.joint.optimisation.manhattan import estimate_right_angles
from echoplan.joint.optimisation.optimiser import consider_parameters, heading_factors, optimise, range_factors
from echoplan.joint.optimisation.pose_factors import PosePrior, pose_factors
from echoplan.joint.optimisation.priors import sonar_prior
from echoplan.joint.optimisation.range_factors import as_arrays
from echoplan.joint.optimisation.values import Values
from echoplan.joint.search.alternatives import class_probabilities
from echoplan.joint.search.corner_echoes import CornerEcho, corner_echoes
from echoplan.joint.search.occlusion import hiding
from echoplan.joint.search.ray_paths import Paths, trace_paths, unoccluded_stations
from echoplan.joint.trace import Decision, Reason, record_event
from echoplan.joint.trajectory import dead_reckoned
from echoplan.preprocessing.measurements import select_measurements, step_of
from echoplan.preprocessing.servo import AS_RECORDED

__all__ = ["marginalise", "survey", "without_sonar"]

# Cell along a wall [m], and number of places kept per cell, which bounds the memory.
_CELL, _KEPT = 0.01, 4
# Probability of its class below which a landmark is not drawn.
_UNLIKELY = 0.05
# Distance of neighbouring specular points of a wall above which sound may pass between them [m].
_WIDE_GAP = 0.4


def survey(estimate: Estimate, marginal_prior: MarginalPrior, path_xy: FloatArray) -> MapBuilder:
    """Return the builder of the map of all stations so far, after one more optimisation of all that is known.

    ``marginal_prior`` is what remains of the estimate once all its stations are marginalised; ``path_xy`` is the path
    of the robot from the first station on, shape (p, 2) [m].
    """
    settings = estimate.settings
    found = [each for each in marginal_prior.features if _is_there(each)]
    for each in marginal_prior.features:
        if not _is_there(each):
            record_event(Decision.REMOVED, each, reason=Reason.INCONSISTENT)
    state = _values(estimate, found, marginal_prior)
    nothing = select_measurements(estimate.recorded, np.zeros(len(estimate.recorded.readings), dtype=bool))
    priors = estimate.priors(estimate.noise, None)._replace(
        manhattan_prior=None, information_inflation=estimate.information_inflation()
    )
    known = marginal_prior.reordered(found, state.layout)
    solution = optimise(nothing, state, priors, settings.optimiser, known=known)
    manhattan_prior = estimate_right_angles(
        solution.reflectors, solution.layout, solution.covariance, settings.manhattan
    )
    if manhattan_prior is not None:
        # Alignment with the axes was decided with the absolute poses, which are eliminated by now.
        manhattan_prior = manhattan_prior._replace(along_axes=estimate.is_along_axes)
        priors = priors._replace(manhattan_prior=manhattan_prior)
        solution = optimise(nothing, state, priors, settings.optimiser, known=known)
    features = [replace(each, reflector=row) for each, row in zip(found, solution.reflectors, strict=True)]
    echoes = marginal_prior.corner_echoes_of(features)
    round_ones = [each for each in features if each.kind is Kind.ROUND]
    segments = [
        each for each in find_segments(features, echoes, path_xy, settings.segments) if not lies_on(each, round_ones)
    ]
    # Errors of the sonar model do not average out over many stations: they bound the covariances from below.
    lacking = settings.optimiser
    best = min(priors.offset_sigma, lacking.min_offset_sigma)
    return MapBuilder(
        features=features,
        solution=replace(solution, offset_sigma=best, model_error=lacking.model_error),
        segments=segments,
        vertices=find_vertices(segments, echoes, settings.corners),
        manhattan_prior=manhattan_prior,
        settings=settings.map,
        ties=settings.optimiser.corner_factors,
        path_xy=path_xy,
    )


def _values(estimate: Estimate, features: Sequence[Hypothesis], marginal_prior: MarginalPrior) -> Values:
    """Return landmarks and calibration after all stations were marginalised."""
    return Values(
        features=as_arrays(features, 0),
        model=estimate.model,
        latency=marginal_prior.latency,
        servo=marginal_prior.servo or AS_RECORDED,
    )


def _is_there(feature: Hypothesis) -> bool:
    """Return True if a landmark probably is of its class, and most of the stations that should detect it did.

    In a long recording, a false landmark always explains the pings of a few stations a little better. So most stations
    that detected it must have detected it past all walls. Most of those that should have detected it must have done so,
    except for corners and edges, which return little sound. A wall through which half as many pings passed as it
    reflected is false, and so is a landmark that is not the best explanation of any ping.
    """
    history = feature.history
    if getattr(history.probabilities, feature.type.feature_class) < _UNLIKELY:
        return False
    if history.supporting - history.hidden < history.hidden or 2 * history.passed >= history.pings:
        return False
    return not feature.type.is_surface or history.supporting >= history.missing


def marginalise(estimate: Estimate, count: int) -> MarginalPrior:
    """Marginalise the first ``count`` stations of an estimate."""
    gone = estimate.recorded.stations < count
    features = _with_pasts(estimate, _going(estimate, gone, count))
    known = [each for each in features if each.is_known]
    everything = [*estimate.marginal_prior.beyond(estimate.active_prior), *known]
    echoes = dict(estimate.marginal_prior.echoes)
    for (one, other), echo in corner_echoes(estimate.likelihood, estimate.features, count).items():
        if echo != CornerEcho() and features[one].is_known and features[other].is_known:
            pair = (features[one].history.number, features[other].history.number)
            key = min(pair), max(pair)
            echoes[key] = echoes.get(key, CornerEcho()).joined(echo)
    bare = partial(replace, ping_scores=NO_PING_SCORES, llr_by_station=np.zeros(0), is_square=False)
    return MarginalPrior(
        features=[bare(each, llr=each.history.llr) for each in everything],
        pending=[each for each in features if not each.is_known],
        summary=_summary(estimate, everything, gone, count),
        echoes=echoes,
        poses=estimate.poses[count:],
        pose_model=estimate.pose_model,
        pose_status=estimate.pose_status,
        model=estimate.model,
        latency=estimate.latency,
        servo=estimate.servo,
        noise=estimate.noise,
        beam_prior=estimate.beam_prior,
        effective_sample_ratio=estimate.effective_sample_ratio,
        trusts_specified_odometry=estimate.trusts_specified_odometry,
        dead_reckoned=_dead_reckoned(estimate, count),
        issued=estimate.marginal_prior.issued + len(known),
        is_known_map=estimate.marginal_prior.is_known_map,
        range_scale=estimate.marginal_prior.range_scale,
        path_xy=estimate.marginal_prior.path_xy,
    )


def without_sonar(estimate: Estimate, marginal_prior: MarginalPrior) -> MarginalPrior:
    """Return the marginal prior of an estimate, all of whose stations were marginalised, without the sonar.

    The sonar is marginalised out together with its prior. Consider parameters are known by that prior only: on a drive,
    the readings would set the range scale to that of the odometry.
    """
    state = _values(estimate, marginal_prior.features, marginal_prior)
    priors, layout = estimate.priors(estimate.noise, estimate.pose_prior), state.layout
    own = sonar_prior(state, layout.sonar, priors, estimate.settings.optimiser)
    information, vector = normal_equations([own], layout.size)
    known = marginal_prior.summary.marginalised_onto(np.arange(layout.size))
    joint = known._replace(
        information=known.information + information, vector=known.vector + vector + information @ state.values
    )
    changes = consider_parameters(state, priors)
    places = np.array([*changes])
    means = state.values[places] + np.array([*changes.values()])
    joint = joint.considered(places, means, own.weights[places - layout.sonar])
    return replace(marginal_prior, summary=joint.marginalised_onto(np.arange(layout.sonar)))


def _dead_reckoned(estimate: Estimate, count: int) -> FloatArray:
    """Return the standard deviations of the first remaining pose by odometry alone [m, m, rad]."""
    if estimate.pose_prior is None or not estimate.pose_prior.relative or count >= len(estimate.measured_poses):
        return np.zeros(3)
    return np.sqrt(np.diag(dead_reckoned(estimate)[count]))


def _summary(estimate: Estimate, everything: list[Hypothesis], gone: BoolArray, count: int) -> InformationPrior:
    """Return the information of the readings and poses of the marginalised stations, with these poses eliminated."""
    pose_prior = _pose_prior(estimate, count)
    poses = np.zeros((0, 3)) if pose_prior is None else estimate.poses[: len(pose_prior.measured_poses)]
    state = estimate.values(everything, poses)
    measurements = select_measurements(estimate.recorded if pose_prior else estimate.measurements, gone)
    if pose_prior:
        measurements = measurements._replace(centers=measurements.centers[: len(pose_prior.measured_poses)])
    priors = estimate.priors(estimate.noise, pose_prior)
    rows = [range_factors(measurements, state, priors, estimate.settings.optimiser)]
    rows.append(heading_factors(measurements, state, priors))
    if pose_prior:
        rows.append(pose_factors(pose_prior, state.poses, state.layout.pose))
    return marginalise_poses(state, rows, estimate.marginal_prior.reordered(everything, state.layout), count)


def _pose_prior(estimate: Estimate, count: int) -> PosePrior | None:
    """Return the prior of the poses to be marginalised, with the step to the next one if poses drift."""
    if estimate.pose_prior is None:
        return None
    kept = count + 1 if estimate.pose_prior.relative else count
    return estimate.pose_prior._replace(
        measured_poses=estimate.pose_prior.measured_poses[:kept], sigmas=estimate.pose_prior.sigmas[:kept]
    )


class _Marginalised(NamedTuple):
    """Number of marginalised stations, and data of their pings.

    ``pings`` is a mask over all pings of the window; ``paths``, ``hidden``, ``passed`` (by landmark), ``owners`` and
    ``stations`` refer to the pings that it selects. ``lines`` holds the line evidence by index of the wall.
    """

    size: int
    pings: BoolArray
    paths: Paths
    hidden: BoolArray
    passed: BoolArray
    owners: IntArray
    stations: IntArray
    lines: dict[int, LineEvidence]


def _going(estimate: Estimate, gone: BoolArray, count: int) -> _Marginalised:
    assert estimate.solution is not None
    paths = trace_paths(estimate.likelihood, estimate.features, step=step_of(estimate.measurements))
    hides = hiding(paths, estimate.features, gap=_WIDE_GAP)
    left_out = estimate.likelihood.log_densities_without(estimate.features)
    return _Marginalised(
        size=count,
        pings=gone,
        paths=paths.chosen(gone),
        hidden=hides.hidden[gone],
        passed=hides.passed[:, gone],
        owners=estimate.solution.owners[gone],
        stations=estimate.measurements.stations[gone],
        lines={
            number: line_evidence(estimate.likelihood, each, count, log_densities)
            for number, (each, log_densities) in enumerate(zip(estimate.features, left_out, strict=True))
            if each.is_wall
        },
    )


def _with_pasts(estimate: Estimate, going: _Marginalised) -> list[Hypothesis]:
    """Add the data of the marginalised stations to the track histories of the landmarks that they detected."""
    radius_cost, prior = estimate.settings.search.radius_cost, estimate.marginal_prior
    issued, features = prior.issued, list[Hypothesis]()
    classes = class_probabilities(estimate.likelihood, estimate.features, radius_cost=radius_cost)
    for number, (each, probabilities) in enumerate(zip(estimate.features, classes, strict=True)):
        if each.is_known or (each.llr_by_station[: going.size] > 0.0).any():
            issued += not each.is_known
            history = each.history
            if not each.is_known:
                history = replace(history, number=issued, recording=prior.recordings)
            history = _with_specular_points(history, number, estimate, going)
            # Class probabilities are those of the window in which the landmark has the greatest log-likelihood ratio.
            if (certainty := each.llr - each.history.llr) > history.certainty:
                history = replace(history, probabilities=probabilities, certainty=certainty)
            features.append(replace(each, history=_counted(history, number, estimate, going)))
        else:
            features.append(each)
    return features


def _counted(history: TrackHistory, number: int, estimate: Estimate, going: _Marginalised) -> TrackHistory:
    """Add the numbers of stations and pings that support or contradict a landmark."""
    each, count = estimate.features[number], going.size
    llr_by_station = each.llr_by_station[:count]
    free = unoccluded_stations(each, estimate.measurements, step=step_of(estimate.measurements))[:count]
    clear = llr_by_station > estimate.settings.map.min_station_llr
    # Stations from which most pings of the landmark go through another one.
    own = going.paths.owners == number
    hidden = np.bincount(going.stations[own & going.hidden], minlength=count)
    through = 2 * hidden > np.bincount(going.stations[own], minlength=count)
    return replace(
        history,
        llr=history.llr + float(llr_by_station.sum()),
        best_llr=max(history.best_llr, float(llr_by_station.max(initial=0.0))),
        supporting=history.supporting + int(clear.sum()),
        missing=history.missing + int((free & ~clear).sum()),
        hidden=history.hidden + int((through & clear).sum()),
        passed=history.passed + int(going.passed[number].sum()),
        pings=history.pings + int((going.owners == number).sum()),
    )


def _with_specular_points(history: TrackHistory, number: int, estimate: Estimate, going: _Marginalised) -> TrackHistory:
    """Add specular points, crossings of the line by sound, and line evidence of a wall; bearings from a corner."""
    wall, paths = estimate.features[number], going.paths
    if wall.kind is Kind.ROUND:
        return replace(history, feet=_joined(history.feet, paths.bearings(number, wall.reflector[1:3])))
    if wall.kind is Kind.CORNER:
        here = replace(wall, llr_by_station=wall.llr_by_station[: going.size])
        bearings = here.detected_from(estimate.measurements.centers[: going.size])
        return replace(history, feet=_joined(history.feet, bearings))
    if not wall.is_wall:
        return history
    line = history.line.joined(going.lines[number])
    line = line.chosen(np.argsort(line.feet, kind="stable"))
    return replace(
        history,
        extent=wall.extent,
        feet=_joined(history.feet, paths.feet(number, wall.line)),
        crossings=_joined(history.crossings, paths.crossings(number, wall.line)),
        # A few stations per cell are kept, so that memory grows with the map and not with the recording.
        line=line.chosen(_first_of_cells(line.feet, CELL)),
    )


def _joined(before: FloatArray, now: FloatArray) -> FloatArray:
    """Join places along a line [m]; once there were some before, a few per cell are kept."""
    if not len(before):
        return np.sort(now)
    places = np.sort(np.concatenate([before, now]))
    kept: FloatArray = places[_first_of_cells(places, _CELL)]
    return kept


def _first_of_cells(places: FloatArray, size: float) -> BoolArray:
    cells = np.floor(places / size)
    first: BoolArray = np.arange(len(places)) - np.searchsorted(cells, cells) < _KEPT
    return first

"""Right angles and heading factors while waypoints are refined."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.mapper import JointSettings
from echoplan.joint.optimisation.manhattan import ManhattanPrior
from echoplan.joint.optimisation.optimiser import Priors
from echoplan.joint.optimisation.pose_factors import PosePrior, waypoint_prior
from echoplan.joint.pose_correction import annealing
from echoplan.joint.pose_correction.annealing import anneal, impose_right_angles, refine, with_best_calibration
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.settings import PoseMode
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.sources import open_source


@pytest.fixture(scope="module")
def square() -> Estimate:
    """Return the estimate of a square room along the axes, every wall of which several stations detect."""
    source = open_source("sim:square")
    sweeps = list(source)
    detected = join_measurements([measurements_of(sweep, source.rig) for sweep in sweeps])
    poses = np.array([sweep.map_from_base[0] for sweep in sweeps])
    return estimate_map(initial_estimate(source.rig, detected, poses, JointSettings(poses=PoseMode.TRUST)))


@pytest.mark.parametrize(("detected_by", "along_axes"), [(1, True), (2, True), (3, False), (5, False)])
def test_walls_of_many_stations_are_not_aligned_with_the_axes(
    square: Estimate, detected_by: int, *, along_axes: bool
) -> None:
    estimate, llr_by_station = square, np.where(np.arange(len(square.measured_poses)) < detected_by, 50.0, 0.0)
    estimate = replace(estimate, features=[replace(each, llr_by_station=llr_by_station) for each in square.features])
    estimate = impose_right_angles(estimate)
    assert estimate.manhattan_prior is not None
    assert estimate.is_along_axes == along_axes


@pytest.mark.parametrize("few", [True, False])
def test_waypoints_are_refined_along_the_axes_if_walls_rest_on_few_stations(
    square: Estimate, monkeypatch: pytest.MonkeyPatch, *, few: bool
) -> None:
    estimate, manhattan_priors = square, list[ManhattanPrior | None]()
    priors = Estimate.priors

    def noted(self: Estimate, noise: float, poses: PosePrior | None) -> Priors:
        given = priors(self, noise, poses)
        manhattan_priors.append(given.manhattan_prior)
        return given

    monkeypatch.setattr(Estimate, "priors", noted)
    monkeypatch.setattr(annealing, "rest_on_few_stations", lambda *_: few)
    estimate = refine(estimate, waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors))
    at_first = manhattan_priors[0]
    assert (at_first is not None and at_first.along_axes) == few


def test_heading_factors_are_added_after_the_beam_is_calibrated(
    square: Estimate, monkeypatch: pytest.MonkeyPatch
) -> None:
    estimate, has_headings = square, list[bool]()
    priors = Estimate.priors

    def noted(self: Estimate, noise: float, poses: PosePrior | None) -> Priors:
        found = priors(self, noise, poses)
        has_headings.append(found.bearings)
        return found

    monkeypatch.setattr(Estimate, "priors", noted)
    estimate = replace(estimate, has_heading_factors=False)
    refine(estimate, waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors))
    assert not has_headings[0]
    assert has_headings[-1]


def test_the_effective_sample_size_is_estimated_from_the_readings(square: Estimate) -> None:
    start = 0.001
    estimate = replace(square, effective_sample_ratio=start)
    estimate = refine(estimate, waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors))
    assert estimate.effective_sample_ratio > 10.0 * start


@pytest.mark.parametrize(("likelihoods", "best"), [([5.0, 1.0, 2.0], 0), ([1.0, 3.0, 2.0], 1), ([1.0, 2.0, 3.0], 2)])
def test_the_most_likely_of_several_calibrations_is_kept(
    square: Estimate, monkeypatch: pytest.MonkeyPatch, likelihoods: list[float], best: int
) -> None:
    """They swing from one to the next, and a later one may explain less."""
    seen = list[Estimate]()

    def likely(estimate: Estimate) -> float:
        if all(each is not estimate for each in seen):
            seen.append(estimate)
        number = next(place for place, each in enumerate(seen) if each is estimate)
        return likelihoods[min(number, 2)] if number <= 2 else 0.0

    monkeypatch.setattr(annealing, "log_evidence", likely)
    monkeypatch.setattr(annealing, "_CALIBRATED", 0.0)
    found = with_best_calibration(square)
    assert seen[0] is square
    assert len(seen) > 2
    assert found is seen[best]


def test_annealing_adds_heading_factors_after_the_beam_is_calibrated(
    square: Estimate, monkeypatch: pytest.MonkeyPatch
) -> None:
    estimate, asked = square, list[tuple[bool, float]]()
    priors = Estimate.priors

    def noted(self: Estimate, noise: float, poses: PosePrior | None) -> Priors:
        given = priors(self, noise, poses)
        asked.append((given.bearings, noise))
        return given

    monkeypatch.setattr(Estimate, "priors", noted)
    estimate = anneal(
        estimate, waypoint_prior(estimate.measured_poses, estimate.settings.pose_errors), estimate.measured_poses
    )
    bearings, noises = np.array([each for each, _ in asked]), np.array([each for _, each in asked])
    # Heading factors are used from the second coarse-to-fine pass on.
    first = int(np.flatnonzero(np.diff(noises) > 0.0)[0]) + 1
    assert not bearings[:first].any()
    assert bearings[first:].all()

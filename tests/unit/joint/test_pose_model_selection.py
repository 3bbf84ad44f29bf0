"""Selection of the pose model, with fake estimates whose consistency and log evidence are given."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from echoplan.joint import pose_model_selection
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.optimisation.pose_factors import PosePrior, odometry_prior, waypoint_prior
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.pose_status import PoseModel, PoseReason, PoseStatus
from echoplan.joint.settings import EstimateSettings, PoseMode
from echoplan.model import Odometry


@dataclass(frozen=True, eq=False)
class FakeEstimate:
    """Estimate that records the steps applied to it and is inconsistent from the recorded poses."""

    measured_poses: np.ndarray
    poses: np.ndarray
    settings: EstimateSettings = field(default_factory=EstimateSettings)
    marginal_prior: MarginalPrior = field(default_factory=MarginalPrior)
    odometry_noise: Odometry | None = None
    pose_model: PoseModel = PoseModel.FIXED
    pose_status: PoseStatus = field(default_factory=PoseStatus)
    settled: int = 0
    is_measured: bool = False
    is_along_axes: bool = False
    noise: float = 0.002
    solution: int = 0
    log_evidence_without_bias: float | None = None
    is_held_down: bool = False
    bias_sigma: float = 0.01
    offset_sigma: float = 0.003
    # Standard deviations of the shared error at which the estimate was optimised.
    alternated: tuple[float, ...] = ()
    trusts_specified_odometry: bool = True
    known: tuple[()] = ()
    features: tuple[()] = ()
    arcs: tuple[None] = (None,)
    asked: tuple[str, ...] = ()

    def _asked(self, name: str) -> "FakeEstimate":
        return replace(self, asked=(*self.asked, name))

    def initialise(self) -> "FakeEstimate":
        return self._asked("initialise")

    def explain(self) -> "FakeEstimate":
        return self._asked("explain")

    def reselect_classes(self) -> "FakeEstimate":
        return self._asked("reselect_classes")

    def remove_multipath_walls(self) -> "FakeEstimate":
        return self._asked("remove_multipath_walls")

    def refine_calibration(self) -> "FakeEstimate":
        return self._asked("refine_calibration")

    def odometry(self) -> PosePrior:
        return odometry_prior(
            self.measured_poses,
            self.settings.pose_errors,
            self.odometry_noise if self.trusts_specified_odometry else None,
        )

    def alternate(self, noise: float, priors: PosePrior, rounds: int) -> "FakeEstimate":
        assert not priors.relative
        return replace(self, solution=self.solution + rounds, alternated=(*self.alternated, self.bias_sigma))

    def estimate_noise(self) -> "FakeEstimate":
        return self._asked("estimate_noise")


def fake_estimate(stations: int, **changes: Any) -> FakeEstimate:
    """Return an estimate with a number of stations."""
    measured_poses = np.full((stations, 3), 0.1234)
    return FakeEstimate(measured_poses, measured_poses, **changes)


def refine(estimate: FakeEstimate, priors: PosePrior) -> FakeEstimate:
    """Count the refinements of an estimate."""
    return replace(estimate, settled=estimate.settled + 1)


def anneal(estimate: FakeEstimate, priors: PosePrior, start: np.ndarray) -> FakeEstimate:
    """Return poses that converged a little beside the start."""
    assert not priors.relative
    return replace(estimate, poses=start + 0.01, settled=ANNEALED)


def with_right_angles(estimate: FakeEstimate, priors: PosePrior) -> FakeEstimate:
    """Find walls along the axes if waypoints were measured from such walls."""
    assert not priors.relative
    return replace(estimate, is_along_axes=True) if estimate.is_measured else estimate


# Number of refinements that marks annealed poses.
ANNEALED = 100
# Log evidence by pose model [nats].
STEPS_FIRST = {PoseModel.FIXED: 0.0, PoseModel.ABSOLUTE: 10.0, PoseModel.ODOMETRY: 20.0}
HAND_FIRST = {PoseModel.FIXED: 0.0, PoseModel.ODOMETRY: 10.0, PoseModel.ABSOLUTE: 20.0}
NEITHER = {PoseModel.FIXED: 30.0, PoseModel.ODOMETRY: 10.0, PoseModel.ABSOLUTE: 20.0}


def recording_step(estimates: list[Any]) -> Callable[..., Any]:
    """Return a step that records its first argument and changes nothing."""

    def step(estimate: Any, *_: Any) -> Any:
        estimates.append(estimate)
        return estimate

    return step


def moving_stations(by: float) -> Callable[..., Any]:
    """Return a step that moves and turns all stations [m, rad]."""
    return lambda estimate, *_: replace(estimate, poses=estimate.poses + by)


def replace_steps(monkeypatch: pytest.MonkeyPatch, **answers: Any) -> None:
    """Replace the steps of the selection by ones that change nothing, or by the given ones."""
    tracking: dict[str, Any] = {
        "register_in_order": lambda estimate, priors, expected: estimate,
        "without_greatest_error": lambda estimate, priors: None,
        "with_estimated_waypoint_noise": lambda estimate: waypoint_prior(
            estimate.measured_poses, estimate.settings.pose_errors
        ),
        "rearranged": lambda estimate, order: estimate,
        "without_wheel_slip": lambda estimate, priors: None,
        "relocalised": lambda estimate, priors, station: None,
        "refine": refine,
        "with_best_calibration": lambda estimate: estimate,
        "contradicts_odometry": lambda estimate: False,
        "find_servo": lambda estimate: None,
        "anneal": anneal,
        "with_right_angles": with_right_angles,
    }
    for name, answer in (tracking | answers).items():
        monkeypatch.setattr(pose_model_selection, name, answer)


def selected(
    monkeypatch: pytest.MonkeyPatch,
    *,
    agree: set[PoseModel],
    scattered: set[PoseModel] | None = None,
    log_evidence_without_bias: dict[PoseModel, float] | None = None,
    stations: int = 5,
    odometry_noise: Odometry | None = None,
    others: dict[str, Any] | None = None,
    marginal_prior: MarginalPrior | None = None,
    poses: PoseMode = PoseMode.AUTO,
    measured: bool = False,
) -> Any:
    """Select the pose model, given which models are consistent or share no walls, and their log evidence."""
    values = log_evidence_without_bias or HAND_FIRST
    answers: dict[str, Any] = {
        "inlier_ratio": lambda estimate: 0.5,
        "agrees": lambda estimate: estimate.pose_model in agree,
        "log_evidence": lambda estimate: values[estimate.pose_model],
        "is_inconsistent": lambda estimate: True,
        "are_weakly_connected": lambda estimate: estimate.pose_model in (scattered or set()),
        "has_duplicated_walls": lambda estimate: False,
        "estimate_shared_bias": lambda estimate, priors: estimate,
    }
    replace_steps(monkeypatch, **(answers | (others or {})))
    estimate = fake_estimate(
        stations,
        odometry_noise=odometry_noise,
        marginal_prior=marginal_prior or MarginalPrior(),
        settings=EstimateSettings(poses=poses),
        is_measured=measured,
    )
    return estimate_map(estimate)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("log_evidence_without_bias", "expected"),
    [(STEPS_FIRST, PoseModel.ODOMETRY), (HAND_FIRST, PoseModel.ABSOLUTE), (NEITHER, PoseModel.FIXED)],
)
@pytest.mark.parametrize("agree", [{PoseModel.ODOMETRY}, {PoseModel.FIXED, PoseModel.ODOMETRY}, set(PoseModel)])
def test_the_pose_model_with_the_greatest_log_evidence_is_selected(
    monkeypatch: pytest.MonkeyPatch,
    agree: set[PoseModel],
    log_evidence_without_bias: dict[PoseModel, float],
    expected: PoseModel,
) -> None:
    assert (
        selected(monkeypatch, agree=agree, log_evidence_without_bias=log_evidence_without_bias).pose_model is expected
    )


def test_absolute_poses_are_compared_before_shared_errors_are_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    # With shared errors, readings have low weights and hardly distinguish pose models.
    others = {
        "log_evidence": lambda estimate: HAND_FIRST[estimate.pose_model] - 15.0 * estimate.is_held_down,
        "estimate_shared_bias": lambda estimate, priors: replace(estimate, is_held_down=True),
    }
    assert selected(monkeypatch, agree=set(PoseModel), others=others).pose_model is PoseModel.ABSOLUTE


def test_shared_errors_are_estimated_from_readings_at_full_weight(monkeypatch: pytest.MonkeyPatch) -> None:
    given = list[Any]()
    others = {"estimate_shared_bias": recording_step(given)}
    selected(monkeypatch, agree=set(PoseModel), others=others)
    assert given
    for each in given:
        assert each.alternated[-1] == each.bias_sigma == each.offset_sigma
        assert each.asked[-1] == "estimate_noise"


@pytest.mark.parametrize("gain", [-20.0, 20.0])
def test_proposed_poses_are_refined_and_kept_if_they_are_clearly_more_likely(
    monkeypatch: pytest.MonkeyPatch, gain: float
) -> None:
    def likely(estimate: Any) -> float:
        is_moved = bool((estimate.poses[1:, 1] == 7.0).all())
        return STEPS_FIRST[estimate.pose_model] + gain * is_moved

    def moved(estimate: Any, _: Any) -> Any:
        poses = estimate.poses.copy()
        poses[1:, 1] = 7.0
        return None if (poses == estimate.poses).all() else replace(estimate, poses=poses)

    found = selected(
        monkeypatch, agree=set(PoseModel), others={"without_greatest_error": moved, "log_evidence": likely}
    )
    assert found.pose_model is PoseModel.ODOMETRY
    assert (found.poses[1:, 1] == 7.0).all() == (gain > 0.0)


def test_stations_that_were_registered_in_another_order_are_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    placed = list[np.ndarray]()

    def aligned(poses: np.ndarray, measured_poses: np.ndarray) -> np.ndarray:
        placed.append(poses[:, 0])
        return poses

    others = {
        "spanning_tree_order": lambda places_xy: [3, 1, 4, 0, 2],
        "rearranged": lambda estimate, order: replace(estimate, poses=np.outer(order, np.ones(3))),
        "aligned": aligned,
    }
    selected(monkeypatch, agree=set(), others=others)
    assert [each.tolist() for each in placed] == [[0.0, 1.0, 2.0, 3.0, 4.0]]


def test_inconsistent_poses_in_whole_centimetres_are_always_corrected(monkeypatch: pytest.MonkeyPatch) -> None:
    others = {"are_quantised": lambda measured_poses: True}
    assert (
        selected(monkeypatch, agree=set(PoseModel), log_evidence_without_bias=NEITHER, others=others).pose_model
        is PoseModel.ABSOLUTE
    )


@pytest.mark.parametrize("duplicated", [True, False])
def test_independent_pose_errors_exclude_odometry(monkeypatch: pytest.MonkeyPatch, *, duplicated: bool) -> None:
    others: dict[str, Any] = {
        "log_odds_absolute_vs_odometry": lambda measured_poses, poses: 9.0,
        "has_duplicated_walls": lambda estimate: duplicated,
    }
    found = selected(monkeypatch, agree={PoseModel.ODOMETRY}, log_evidence_without_bias=STEPS_FIRST, others=others)
    assert found.pose_model is PoseModel.ABSOLUTE


@pytest.mark.parametrize("duplicated", [True, False])
@pytest.mark.parametrize(("errors", "expected"), [(-12.0, PoseModel.ODOMETRY), (-8.0, PoseModel.ABSOLUTE)])
def test_accumulating_pose_errors_exclude_waypoints_unless_the_echoes_outweigh_them(
    monkeypatch: pytest.MonkeyPatch, errors: float, expected: PoseModel, *, duplicated: bool
) -> None:
    # The log evidence of absolute poses is 10 nats greater than that of odometry.
    others: dict[str, Any] = {
        "log_odds_absolute_vs_odometry": lambda measured_poses, poses: errors,
        "has_duplicated_walls": lambda estimate: duplicated,
    }
    found = selected(monkeypatch, agree={PoseModel.ODOMETRY}, log_evidence_without_bias=HAND_FIRST, others=others)
    assert found.pose_model is expected


@pytest.mark.parametrize("duplicated", [True, False])
@pytest.mark.parametrize(("errors", "round_", "expected"), [(-50, False, 0), (-30, False, 1), (-50, True, 1)])
def test_absolute_poses_are_not_tried_if_errors_clearly_accumulate(
    monkeypatch: pytest.MonkeyPatch, errors: float, expected: int, *, duplicated: bool, round_: bool
) -> None:
    thought = list[Any]()
    others: dict[str, Any] = {
        "log_odds_absolute_vs_odometry": lambda measured_poses, poses: errors,
        "are_quantised": lambda measured_poses: round_,
        "has_duplicated_walls": lambda estimate: duplicated,
        "rearranged": recording_step(thought),
        "register_in_order": moving_stations(0.1),
    }
    found = selected(monkeypatch, agree={PoseModel.ODOMETRY}, log_evidence_without_bias=STEPS_FIRST, others=others)
    assert found.pose_model is PoseModel.ODOMETRY
    assert len(thought) == expected


@pytest.mark.parametrize(("errors", "expected"), [(-3.0, PoseModel.ABSOLUTE), (-9.0, PoseModel.ODOMETRY)])
def test_poses_at_round_numbers_are_waypoints_unless_errors_clearly_accumulate(
    monkeypatch: pytest.MonkeyPatch, errors: float, expected: PoseModel
) -> None:
    others: dict[str, Any] = {
        "log_odds_absolute_vs_odometry": lambda measured_poses, poses: errors,
        "are_quantised": lambda measured_poses: True,
    }
    found = selected(monkeypatch, agree={PoseModel.ODOMETRY}, log_evidence_without_bias=STEPS_FIRST, others=others)
    assert found.pose_model is expected


@pytest.mark.parametrize(
    ("log_evidence_without_bias", "expected"),
    [(STEPS_FIRST, PoseModel.ODOMETRY), (HAND_FIRST, PoseModel.ODOMETRY), (NEITHER, PoseModel.FIXED)],
)
def test_a_rig_with_odometry_noise_has_no_waypoints(
    monkeypatch: pytest.MonkeyPatch, log_evidence_without_bias: dict[PoseModel, float], expected: PoseModel
) -> None:
    found = selected(
        monkeypatch,
        agree={PoseModel.FIXED},
        log_evidence_without_bias=log_evidence_without_bias,
        odometry_noise=Odometry(along=0.02),
    )
    assert found.pose_model is expected
    is_needed = expected is not PoseModel.FIXED
    assert found.pose_status.is_odometry_specified
    assert found.pose_status.reason is (PoseReason.ODOMETRY if is_needed else PoseReason.NO_CORRECTION_NEEDED)


@pytest.mark.parametrize(
    ("agree", "strained", "farther"),
    [({PoseModel.ODOMETRY}, False, False), ({PoseModel.ODOMETRY}, True, True), (set(), False, True)],
)
# Six times the noise along the path costs 7 nats for four steps, and 5 must remain.
@pytest.mark.parametrize(("more", "enough"), [(15.0, True), (10.0, False)])
def test_the_odometry_noise_may_exceed_the_specification(
    monkeypatch: pytest.MonkeyPatch, agree: set[PoseModel], more: float, *, strained: bool, farther: bool, enough: bool
) -> None:
    def log_evidence(estimate: Any) -> float:
        return STEPS_FIRST[estimate.pose_model] + more * (not estimate.trusts_specified_odometry)

    others = {"contradicts_odometry": lambda estimate: strained, "log_evidence": log_evidence}
    found = selected(monkeypatch, agree=agree, odometry_noise=Odometry(along=0.02), others=others)
    assert found.pose_model is PoseModel.ODOMETRY
    assert found.trusts_specified_odometry != (farther and enough)
    assert found.pose_status.exceeds_specification == (farther and enough)


@pytest.mark.parametrize(
    ("log_evidence_without_bias", "expected"),
    [(STEPS_FIRST, PoseModel.ODOMETRY), (HAND_FIRST, PoseModel.ABSOLUTE), (NEITHER, PoseModel.FIXED)],
)
def test_a_requested_correction_selects_the_pose_model_itself(
    monkeypatch: pytest.MonkeyPatch, log_evidence_without_bias: dict[PoseModel, float], expected: PoseModel
) -> None:
    others: dict[str, Any] = {"is_inconsistent": lambda estimate: False}
    agree = {PoseModel.FIXED, PoseModel.ODOMETRY}
    found = selected(
        monkeypatch,
        agree=agree,
        log_evidence_without_bias=log_evidence_without_bias,
        poses=PoseMode.CORRECT,
        others=others,
    )
    assert found.pose_model is expected
    many = EstimateSettings().max_waypoints + 1
    found = selected(
        monkeypatch,
        agree=agree,
        log_evidence_without_bias=HAND_FIRST,
        poses=PoseMode.CORRECT,
        stations=many,
        others=others,
    )
    assert found.pose_model is PoseModel.ODOMETRY


@pytest.mark.parametrize("poses", [PoseMode.AUTO, PoseMode.CORRECT])
def test_the_absolute_pose_model_is_kept_after_marginalisation(
    monkeypatch: pytest.MonkeyPatch, poses: PoseMode
) -> None:
    marginal_prior = MarginalPrior(
        summary=MarginalPrior().summary._replace(columns=np.arange(4)), pose_model=PoseModel.ABSOLUTE
    )
    found = selected(
        monkeypatch,
        agree={PoseModel.ODOMETRY},
        log_evidence_without_bias=HAND_FIRST,
        marginal_prior=marginal_prior,
        poses=poses,
    )
    assert found.pose_model is PoseModel.ABSOLUTE


@pytest.mark.parametrize(
    ("agree", "reason"),
    [({PoseModel.FIXED}, PoseReason.NO_CORRECTION_NEEDED), (set(), PoseReason.NO_BETTER_POSES)],
)
@pytest.mark.parametrize("odometry_noise", [None, Odometry(along=0.02)])
def test_a_correction_without_effect_has_a_reason(
    monkeypatch: pytest.MonkeyPatch, agree: set[PoseModel], reason: PoseReason, odometry_noise: Odometry | None
) -> None:
    found = selected(
        monkeypatch,
        agree=agree,
        log_evidence_without_bias=NEITHER,
        poses=PoseMode.CORRECT,
        odometry_noise=odometry_noise,
    )
    assert found.pose_model is PoseModel.FIXED
    assert found.pose_status.reason is reason
    assert found.pose_status.inlier_ratio == 0.5


@pytest.mark.parametrize(
    ("log_evidence_without_bias", "expected", "why"),
    [
        (STEPS_FIRST, PoseModel.ODOMETRY, PoseReason.DUPLICATED_WALLS),
        (HAND_FIRST, PoseModel.ABSOLUTE, PoseReason.INCONSISTENT),
    ],
)
def test_absolute_poses_are_tried_if_walls_are_duplicated(
    monkeypatch: pytest.MonkeyPatch,
    log_evidence_without_bias: dict[PoseModel, float],
    expected: PoseModel,
    why: PoseReason,
) -> None:
    found = selected(
        monkeypatch,
        agree={PoseModel.ODOMETRY},
        log_evidence_without_bias=log_evidence_without_bias,
        others={"has_duplicated_walls": lambda estimate: True},
    )
    assert found.pose_model is expected
    assert found.pose_status.reason is why
    assert found.pose_status.inlier_ratio == (0.5 if why is PoseReason.INCONSISTENT else None)


@pytest.mark.parametrize("best", [2, 1, ANNEALED], ids=["tracked and refined", "registered", "annealed"])
def test_the_best_of_several_starts_of_absolute_poses_is_selected(monkeypatch: pytest.MonkeyPatch, best: int) -> None:
    def log_evidence(estimate: Any) -> float:
        if estimate.pose_model is not PoseModel.ABSOLUTE:
            return 0.0
        return 20.0 if estimate.settled == best else 10.0

    found = selected(monkeypatch, agree={PoseModel.ODOMETRY}, others={"log_evidence": log_evidence})
    assert found.settled == best


@pytest.mark.parametrize(("scattered", "others"), [(set(), 0), ({PoseModel.ABSOLUTE}, 1)])
def test_further_starts_are_tried_if_stations_share_no_walls(
    monkeypatch: pytest.MonkeyPatch, scattered: set[PoseModel], others: int
) -> None:
    placed = list[Any]()
    selected(monkeypatch, agree=set(PoseModel), scattered=scattered, others={"rearranged": recording_step(placed)})
    assert len(placed) == others


@pytest.mark.parametrize("measured", [True, False])
def test_absolute_poses_are_refined_again_if_walls_are_along_the_axes(
    monkeypatch: pytest.MonkeyPatch, *, measured: bool
) -> None:
    assert len(selected(monkeypatch, agree=set(), measured=measured).alternated) == (4 if measured else 2)


def test_further_starts_are_tried_if_the_first_is_worse_than_odometry(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Absolute poses that start from a wrong odometry solution may be wrong, too.
    def log_evidence(estimate: Any) -> float:
        return 30.0 if estimate.settled == ANNEALED else {**STEPS_FIRST, PoseModel.ABSOLUTE: 10.0}[estimate.pose_model]

    found = selected(monkeypatch, agree=set(PoseModel), others={"log_evidence": log_evidence})
    assert found.settled == ANNEALED


@pytest.mark.parametrize(("remembers", "expected"), [(True, 0), (False, 1)])
def test_stations_are_not_reordered_after_marginalisation(
    monkeypatch: pytest.MonkeyPatch, *, remembers: bool, expected: int
) -> None:
    placed = list[Any]()
    nothing = MarginalPrior().summary
    marginal_prior = MarginalPrior(summary=nothing._replace(columns=np.arange(4))) if remembers else MarginalPrior()
    selected(
        monkeypatch,
        agree={PoseModel.ABSOLUTE},
        others={"rearranged": recording_step(placed)},
        marginal_prior=marginal_prior,
    )
    assert len(placed) == expected


def test_many_stations_are_no_waypoints(monkeypatch: pytest.MonkeyPatch) -> None:
    many = EstimateSettings().max_waypoints + 1
    assert (
        selected(monkeypatch, agree=set(), log_evidence_without_bias=HAND_FIRST, stations=many).pose_model
        is PoseModel.ODOMETRY
    )


@pytest.mark.parametrize(
    ("log_evidence_without_bias", "expected"),
    [(STEPS_FIRST, PoseModel.ODOMETRY), (NEITHER, PoseModel.FIXED)],
    ids=["more", "less"],
)
def test_many_stations_are_corrected_only_with_more_log_evidence(
    monkeypatch: pytest.MonkeyPatch, log_evidence_without_bias: dict[PoseModel, float], expected: PoseModel
) -> None:
    many = EstimateSettings().max_waypoints + 1
    assert (
        selected(
            monkeypatch, agree=set(), log_evidence_without_bias=log_evidence_without_bias, stations=many
        ).pose_model
        is expected
    )


def test_duplicated_walls_of_many_stations_are_corrected_without_a_comparison(monkeypatch: pytest.MonkeyPatch) -> None:
    others = {"has_duplicated_walls": lambda estimate: True}
    many = EstimateSettings().max_waypoints + 1
    found = selected(monkeypatch, agree=set(), log_evidence_without_bias=NEITHER, stations=many, others=others)
    assert found.pose_model is PoseModel.ODOMETRY


def test_poses_of_two_stations_are_not_corrected(monkeypatch: pytest.MonkeyPatch) -> None:
    assert selected(monkeypatch, agree=set(), stations=2).pose_model is PoseModel.FIXED


def test_steps_are_proposed_while_the_log_evidence_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    # Tracking refines the poses once.
    log_evidence_without_bias = [0.0, 0.0, 20.0, 40.0, 42.0, 90.0]
    estimate = fake_estimate(5, settings=EstimateSettings(poses=PoseMode.CORRECT, max_waypoints=0))
    replace_steps(
        monkeypatch,
        agrees=lambda estimate: True,
        log_evidence=lambda estimate: log_evidence_without_bias[estimate.settled],
        register_in_order=moving_stations(1.0),
        without_greatest_error=lambda estimate, priors: estimate,
    )
    best: Any = estimate_map(estimate)  # type: ignore[arg-type]
    assert best.settled == 3


@pytest.mark.parametrize(("explained", "moved", "tried"), [(True, 0.1, False), (True, 0.01, True), (False, 0.1, True)])
def test_recorded_poses_are_tried_unless_odometry_explains_the_echoes_and_moved_stations(
    monkeypatch: pytest.MonkeyPatch, *, explained: bool, moved: float, tried: bool
) -> None:
    found = selected(
        monkeypatch,
        agree={PoseModel.ODOMETRY} if explained else set(),
        log_evidence_without_bias=NEITHER,
        odometry_noise=Odometry(),
        others={"register_in_order": moving_stations(moved)},
    )
    assert found.pose_model is (PoseModel.FIXED if tried else PoseModel.ODOMETRY)


def test_multipath_walls_are_removed_after_class_selection_and_before_calibration(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    replace_steps(monkeypatch, has_duplicated_walls=lambda estimate: False)
    estimate: Any = fake_estimate(5, settings=EstimateSettings(poses=PoseMode.TRUST))
    found: Any = estimate_map(estimate)
    steps = ("initialise", "explain", "reselect_classes", "remove_multipath_walls", "refine_calibration")
    assert found.asked == steps

"""Which poses are tried, as the echoes agree from those recorded and from those of odometry."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from echoplan.joint import pose_model_selection
from echoplan.joint.marginal_prior import Course, Memory
from echoplan.joint.optimisation.pose_factors import PosePrior, odometry_prior, waypoint_prior
from echoplan.joint.pose_model_selection import explained
from echoplan.joint.settings import AccountSettings, PoseMode
from echoplan.model import Odometry


@dataclass(frozen=True, eq=False)
class Doubtful:
    """An account that is explained by saying so, doubtful from the poses as recorded."""

    given: np.ndarray
    poses: np.ndarray
    settings: AccountSettings = field(default_factory=AccountSettings)
    memory: Memory = field(default_factory=Memory)
    wheels: Odometry | None = None
    course: Course = Course.TRUSTED
    verdict: str = ""
    settled: int = 0
    is_measured: bool = False
    is_along_axes: bool = False
    is_placed: bool = False
    noise: float = 0.002
    adjusted: int = 0
    penalised_llr: float | None = None
    is_held_down: bool = False
    trusts_specified_odometry: bool = True
    known: tuple[()] = ()
    features: tuple[()] = ()
    arcs: tuple[None] = (None,)
    asked: tuple[str, ...] = ()

    def _asked(self, name: str) -> "Doubtful":
        return replace(self, asked=(*self.asked, name))

    def initialise(self) -> "Doubtful":
        return self._asked("glance")

    def explain(self) -> "Doubtful":
        return self._asked("explain")

    def reselect_classes(self) -> "Doubtful":
        return self._asked("reconsider")

    def clear(self) -> "Doubtful":
        return self._asked("clear")

    def refine_calibration(self) -> "Doubtful":
        return self._asked("polish")

    def odometry(self) -> PosePrior:
        return odometry_prior(
            self.given, self.settings.pose_errors, self.wheels if self.trusts_specified_odometry else None
        )

    def alternate(self, noise: float, priors: PosePrior, rounds: int) -> "Doubtful":
        assert not priors.relative
        return replace(self, adjusted=self.adjusted + rounds)


def doubtful(stations: int, **changes: Any) -> Doubtful:
    """An account of so many stations."""
    given = np.full((stations, 3), 0.1234)
    return Doubtful(given, given, **changes)


def settle(account: Doubtful, priors: PosePrior) -> Doubtful:
    """Count how often an account was settled."""
    return replace(account, settled=account.settled + 1)


def converge(account: Doubtful, priors: PosePrior, start: np.ndarray) -> Doubtful:
    """Come to rest a little beside the start."""
    assert not priors.relative
    return replace(account, poses=start + 0.01, settled=NUDGED)


def stand_square(account: Doubtful, priors: PosePrior) -> Doubtful:
    """Find walls along the axes where way-points were measured from such."""
    assert not priors.relative
    return replace(account, is_along_axes=account.is_measured)


# Settled more often than anything is, to tell poses that were nudged from those that were reset.
NUDGED = 100
# What explains how much, in this order.
STEPS_FIRST = {Course.TRUSTED: 0.0, Course.NUDGED: 10.0, Course.TRACKED: 20.0}
HAND_FIRST = {Course.TRUSTED: 0.0, Course.TRACKED: 10.0, Course.NUDGED: 20.0}
NEITHER = {Course.TRUSTED: 30.0, Course.TRACKED: 10.0, Course.NUDGED: 20.0}


def noted(accounts: list[Any]) -> Callable[[Any], Any]:
    """Stand in for a step that keeps what it was given and changes nothing."""

    def step(account: Any) -> Any:
        accounts.append(account)
        return account

    return step


def told(monkeypatch: pytest.MonkeyPatch, **answers: Any) -> None:
    """Let tracking find nothing better, and questions about accounts be answered so."""
    tracking: dict[str, Any] = {
        "track": lambda account, priors: account,
        "learned_waypoints": lambda account: waypoint_prior(account.given, account.settings.pose_errors),
        "place": lambda account: account,
        "without_slip": lambda account, priors: None,
        "relocalised": lambda account, priors, station: None,
        "settle": settle,
        "is_strained": lambda account: False,
        "find_servo": lambda account: None,
        "converge": converge,
        "stand_square": stand_square,
    }
    for name, answer in (tracking | answers).items():
        monkeypatch.setattr(pose_model_selection, name, answer)


def best_of(
    monkeypatch: pytest.MonkeyPatch,
    *,
    agree: set[Course],
    scattered: set[Course] | None = None,
    penalised_llr: dict[Course, float] | None = None,
    stations: int = 5,
    wheels: Odometry | None = None,
    others: dict[str, Any] | None = None,
    memory: Memory | None = None,
    poses: PoseMode = PoseMode.AUTO,
    measured: bool = False,
) -> Any:
    """Explain an account where others agree or scatter, and are worth more or less, by how their poses came about."""
    values = penalised_llr or HAND_FIRST
    answers: dict[str, Any] = {
        "agreement": lambda account: 0.5,
        "agrees": lambda account: account.course in agree,
        "evidence": lambda account: values[account.course],
        "is_inconsistent": lambda account: True,
        "is_scattered": lambda account: account.course in (scattered or set()),
        "has_duplicated_walls": lambda account: False,
        "learn_common_error": lambda account, priors: account,
        "without_common_error": lambda account, priors: account,
    }
    told(monkeypatch, **(answers | (others or {})))
    account = doubtful(
        stations,
        wheels=wheels,
        memory=memory or Memory(),
        settings=AccountSettings(poses=poses),
        is_measured=measured,
    )
    return explained(account)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("penalised_llr", "expected"),
    [(STEPS_FIRST, Course.TRACKED), (HAND_FIRST, Course.NUDGED), (NEITHER, Course.TRUSTED)],
)
@pytest.mark.parametrize("agree", [{Course.TRACKED}, {Course.TRUSTED, Course.TRACKED}, set(Course)])
def test_the_evidence_tells_steps_from_way_points_set_by_hand(
    monkeypatch: pytest.MonkeyPatch, agree: set[Course], penalised_llr: dict[Course, float], expected: Course
) -> None:
    assert best_of(monkeypatch, agree=agree, penalised_llr=penalised_llr).course is expected


def test_way_points_are_worth_what_they_explain_while_readings_count_in_full(monkeypatch: pytest.MonkeyPatch) -> None:
    # Held down by an error that stations have in common, readings hardly tell of any poses that they are better.
    others = {
        "evidence": lambda account: HAND_FIRST[account.course] - 15.0 * account.is_held_down,
        "without_common_error": lambda account, priors: replace(account, is_held_down=False),
        "learn_common_error": lambda account, priors: replace(account, is_held_down=True),
    }
    assert best_of(monkeypatch, agree=set(Course), others=others).course is Course.NUDGED


def test_marks_in_whole_centimetres_are_never_exact_where_they_are_doubtful(monkeypatch: pytest.MonkeyPatch) -> None:
    others = {"are_round": lambda given: True}
    assert best_of(monkeypatch, agree=set(Course), penalised_llr=NEITHER, others=others).course is Course.NUDGED


@pytest.mark.parametrize("torn", [True, False])
def test_errors_that_scatter_about_the_steps_are_none_of_odometry(
    monkeypatch: pytest.MonkeyPatch, *, torn: bool
) -> None:
    others: dict[str, Any] = {"scatter": lambda given, poses: 9.0, "has_duplicated_walls": lambda account: torn}
    found = best_of(monkeypatch, agree={Course.TRACKED}, penalised_llr=STEPS_FIRST, others=others)
    assert found.course is Course.NUDGED


@pytest.mark.parametrize("torn", [True, False])
@pytest.mark.parametrize(("errors", "expected"), [(-12.0, Course.TRACKED), (-8.0, Course.NUDGED)])
def test_errors_that_add_up_are_none_of_way_points_unless_echoes_say_so_more_clearly(
    monkeypatch: pytest.MonkeyPatch, errors: float, expected: Course, *, torn: bool
) -> None:
    # Way-points explain 10 nats more than steps do.
    others: dict[str, Any] = {"scatter": lambda given, poses: errors, "has_duplicated_walls": lambda account: torn}
    found = best_of(monkeypatch, agree={Course.TRACKED}, penalised_llr=HAND_FIRST, others=others)
    assert found.course is expected


@pytest.mark.parametrize("torn", [True, False])
@pytest.mark.parametrize(("errors", "round_", "expected"), [(-50, False, 0), (-30, False, 1), (-50, True, 1)])
def test_where_errors_add_up_beyond_doubt_way_points_are_not_even_thought_of(
    monkeypatch: pytest.MonkeyPatch, errors: float, expected: int, *, torn: bool, round_: bool
) -> None:
    thought = list[Any]()
    others: dict[str, Any] = {
        "scatter": lambda given, poses: errors,
        "are_round": lambda given: round_,
        "has_duplicated_walls": lambda account: torn,
        "place": noted(thought),
    }
    found = best_of(monkeypatch, agree={Course.TRACKED}, penalised_llr=STEPS_FIRST, others=others)
    assert found.course is Course.TRACKED
    assert len(thought) == expected


@pytest.mark.parametrize(("errors", "expected"), [(-3.0, Course.NUDGED), (-9.0, Course.TRACKED)])
def test_round_numbers_are_way_points_unless_errors_clearly_add_up(
    monkeypatch: pytest.MonkeyPatch, errors: float, expected: Course
) -> None:
    others: dict[str, Any] = {"scatter": lambda given, poses: errors, "are_round": lambda given: True}
    found = best_of(monkeypatch, agree={Course.TRACKED}, penalised_llr=STEPS_FIRST, others=others)
    assert found.course is expected


@pytest.mark.parametrize(
    ("penalised_llr", "expected"),
    [(STEPS_FIRST, Course.TRACKED), (HAND_FIRST, Course.TRACKED), (NEITHER, Course.TRUSTED)],
)
def test_a_rig_that_tells_how_steps_go_astray_has_no_way_points(
    monkeypatch: pytest.MonkeyPatch, penalised_llr: dict[Course, float], expected: Course
) -> None:
    found = best_of(monkeypatch, agree={Course.TRUSTED}, penalised_llr=penalised_llr, wheels=Odometry(along=0.02))
    assert found.course is expected
    is_needed = expected is not Course.TRUSTED
    assert found.verdict.startswith("corrected, as the rig tells" if is_needed else "no correction was needed")


@pytest.mark.parametrize(
    ("agree", "strained", "farther"),
    [({Course.TRACKED}, False, False), ({Course.TRACKED}, True, True), (set(), False, True)],
)
# That steps may be off by six times more along the way costs 7 nats with four of them, and 5 must be left.
@pytest.mark.parametrize(("more", "enough"), [(15.0, True), (10.0, False)])
def test_steps_may_lead_farther_astray_than_the_rig_tells(
    monkeypatch: pytest.MonkeyPatch, agree: set[Course], more: float, *, strained: bool, farther: bool, enough: bool
) -> None:
    def evidence(account: Any) -> float:
        return STEPS_FIRST[account.course] + more * (not account.trusts_specified_odometry)

    others = {"is_strained": lambda account: strained, "evidence": evidence}
    found = best_of(monkeypatch, agree=agree, wheels=Odometry(along=0.02), others=others)
    assert found.course is Course.TRACKED
    assert found.trusts_specified_odometry != (farther and enough)
    assert found.verdict.endswith("and farther than the rig tells") == (farther and enough)


@pytest.mark.parametrize(
    ("penalised_llr", "expected"),
    [(STEPS_FIRST, Course.TRACKED), (HAND_FIRST, Course.NUDGED), (NEITHER, Course.TRUSTED)],
)
def test_who_asks_for_better_poses_need_not_say_whether_steps_led_astray_or_a_hand(
    monkeypatch: pytest.MonkeyPatch, penalised_llr: dict[Course, float], expected: Course
) -> None:
    others: dict[str, Any] = {"is_inconsistent": lambda account: False}
    agree = {Course.TRUSTED, Course.TRACKED}
    found = best_of(monkeypatch, agree=agree, penalised_llr=penalised_llr, poses=PoseMode.CORRECT, others=others)
    assert found.course is expected
    many = AccountSettings().by_hand + 1
    found = best_of(
        monkeypatch, agree=agree, penalised_llr=HAND_FIRST, poses=PoseMode.CORRECT, stations=many, others=others
    )
    assert found.course is Course.TRACKED


@pytest.mark.parametrize("poses", [PoseMode.AUTO, PoseMode.CORRECT])
def test_way_points_that_were_set_by_hand_stay_so_when_the_first_are_only_remembered(
    monkeypatch: pytest.MonkeyPatch, poses: PoseMode
) -> None:
    memory = Memory(summary=Memory().summary._replace(columns=np.arange(4)), course=Course.NUDGED)
    found = best_of(monkeypatch, agree={Course.TRACKED}, penalised_llr=HAND_FIRST, memory=memory, poses=poses)
    assert found.course is Course.NUDGED


@pytest.mark.parametrize(
    ("agree", "said"), [({Course.TRUSTED}, "no correction was needed"), (set(), "left as recorded: only 50 %")]
)
@pytest.mark.parametrize("wheels", [None, Odometry(along=0.02)])
def test_who_asks_in_vain_is_told_why(
    monkeypatch: pytest.MonkeyPatch, agree: set[Course], said: str, wheels: Odometry | None
) -> None:
    found = best_of(monkeypatch, agree=agree, penalised_llr=NEITHER, poses=PoseMode.CORRECT, wheels=wheels)
    assert found.course is Course.TRUSTED
    assert said in found.verdict


@pytest.mark.parametrize(
    ("penalised_llr", "expected", "why"),
    [
        (STEPS_FIRST, Course.TRACKED, "most walls were there twice"),
        (HAND_FIRST, Course.NUDGED, "only 50 % of the echoes fit together"),
    ],
)
def test_where_walls_are_torn_apart_way_points_are_thought_of_too(
    monkeypatch: pytest.MonkeyPatch, penalised_llr: dict[Course, float], expected: Course, why: str
) -> None:
    found = best_of(
        monkeypatch,
        agree={Course.TRACKED},
        penalised_llr=penalised_llr,
        others={"has_duplicated_walls": lambda account: True},
    )
    assert found.course is expected
    assert why in found.verdict


@pytest.mark.parametrize("best", ["led", "placed", "nudged"])
def test_way_points_start_from_several_places_and_what_explains_most_is_taken(
    monkeypatch: pytest.MonkeyPatch, best: str
) -> None:
    def evidence(account: Any) -> float:
        if account.course is not Course.NUDGED:
            return 0.0
        start = "nudged" if account.settled == NUDGED else "placed" if account.is_placed else "led"
        return 20.0 if start == best else 10.0

    others = {"evidence": evidence, "place": lambda account: replace(account, is_placed=True)}
    found = best_of(monkeypatch, agree={Course.TRACKED}, others=others)
    assert (found.settled == NUDGED, found.is_placed) == (best == "nudged", best == "placed")


@pytest.mark.parametrize(("scattered", "others"), [(set(), 0), ({Course.NUDGED}, 1)])
def test_where_pings_agree_from_the_steps_and_as_recorded_others_are_tried_if_nothing_holds_stations_together(
    monkeypatch: pytest.MonkeyPatch, scattered: set[Course], others: int
) -> None:
    placed = list[Any]()
    best_of(monkeypatch, agree=set(Course), scattered=scattered, others={"place": noted(placed)})
    assert len(placed) == others


@pytest.mark.parametrize("measured", [True, False])
def test_walls_along_the_axes_tell_which_way_stations_faced(monkeypatch: pytest.MonkeyPatch, *, measured: bool) -> None:
    assert (best_of(monkeypatch, agree=set(), measured=measured).adjusted > 0) == measured


def test_where_steps_explain_more_than_what_was_reset_from_them_way_points_are_nudged_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Steps that led astray leave way-points that start there astray, too.
    def evidence(account: Any) -> float:
        return 30.0 if account.settled == NUDGED else {**STEPS_FIRST, Course.NUDGED: 10.0}[account.course]

    found = best_of(monkeypatch, agree=set(Course), others={"evidence": evidence})
    assert found.settled == NUDGED


@pytest.mark.parametrize(("remembers", "expected"), [(True, 0), (False, 1)])
def test_stations_that_others_are_remembered_with_keep_their_order(
    monkeypatch: pytest.MonkeyPatch, *, remembers: bool, expected: int
) -> None:
    placed = list[Any]()
    nothing = Memory().summary
    memory = Memory(summary=nothing._replace(columns=np.arange(4))) if remembers else Memory()
    best_of(monkeypatch, agree={Course.NUDGED}, others={"place": noted(placed)}, memory=memory)
    assert len(placed) == expected


def test_no_hand_set_so_many_way_points(monkeypatch: pytest.MonkeyPatch) -> None:
    many = AccountSettings().by_hand + 1
    assert best_of(monkeypatch, agree=set(), penalised_llr=HAND_FIRST, stations=many).course is Course.TRACKED


@pytest.mark.parametrize(
    ("penalised_llr", "expected"), [(STEPS_FIRST, Course.TRACKED), (NEITHER, Course.TRUSTED)], ids=["more", "less"]
)
def test_many_stations_are_moved_only_where_that_explains_more(
    monkeypatch: pytest.MonkeyPatch, penalised_llr: dict[Course, float], expected: Course
) -> None:
    many = AccountSettings().by_hand + 1
    assert best_of(monkeypatch, agree=set(), penalised_llr=penalised_llr, stations=many).course is expected


def test_two_stations_have_nothing_to_hold_a_pose_against(monkeypatch: pytest.MonkeyPatch) -> None:
    assert best_of(monkeypatch, agree=set(), stations=2).course is Course.TRUSTED


def test_poses_settle_as_long_as_that_explains_more(monkeypatch: pytest.MonkeyPatch) -> None:
    penalised_llr = [0.0, 20.0, 40.0, 42.0, 90.0]
    account = doubtful(5, settings=AccountSettings(poses=PoseMode.CORRECT, by_hand=0))
    told(
        monkeypatch,
        agrees=lambda account: False,
        evidence=lambda account: penalised_llr[account.settled],
        has_duplicated_walls=lambda account: True,
    )
    best: Any = explained(account)  # type: ignore[arg-type]
    assert best.settled == 2


def test_phantoms_are_sought_once_features_are_what_they_are_and_the_sonar_is_polished_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told(monkeypatch, has_duplicated_walls=lambda account: False)
    account: Any = doubtful(5, settings=AccountSettings(poses=PoseMode.TRUST))
    assert explained(account).asked == ("glance", "explain", "reconsider", "clear", "polish")  # type: ignore[attr-defined]

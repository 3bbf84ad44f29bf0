"""Which poses are tried, as the echoes agree from those recorded and from those of odometry."""

from typing import Any

import numpy as np
import pytest

from echoplan.mapping import explaining
from echoplan.mapping.explaining import explained
from echoplan.mapping.memory import Course, Memory
from echoplan.mapping.poses import PoseBeliefs
from echoplan.mapping.settings import AccountSettings, PoseMode


class Doubtful:
    """An account that is explained by saying so, doubtful from the poses as recorded."""

    def __init__(self, stations: int) -> None:
        self.settings = AccountSettings(poses=PoseMode.AUTO)
        self.memory = Memory()
        self.given = self.poses = np.zeros((stations, 3))
        self.course, self.verdict, self.settled = Course.TRUSTED, "", 0
        self.known = self.features = ()

    def glance(self) -> None:
        pass

    explain = clear = polish = glance

    def odometry(self) -> None:
        pass

    def settle(self, beliefs: PoseBeliefs) -> None:
        self.settled += 1

    def correct(self, beliefs: PoseBeliefs, start: np.ndarray) -> None:
        assert not beliefs.relative
        self.poses = start + 0.01


def told(monkeypatch: pytest.MonkeyPatch, **answers: Any) -> None:
    """Let tracking find nothing better, and questions about accounts be answered so."""
    tracking: dict[str, Any] = {
        "track": lambda account, beliefs: None,
        "without_slip": lambda account, beliefs: None,
        "elsewhere": lambda account, beliefs, station: None,
    }
    for name, answer in (tracking | answers).items():
        monkeypatch.setattr(explaining, name, answer)


def course(
    monkeypatch: pytest.MonkeyPatch,
    *,
    agree: set[Course],
    scattered: set[Course],
    stations: int = 5,
    others: dict[str, Any] | None = None,
) -> Course:
    """Tell how the best poses came about, if accounts agree or scatter by how theirs did."""
    worth = {Course.TRUSTED: 0.0, Course.TRACKED: 10.0, Course.NUDGED: 20.0}
    answers: dict[str, Any] = {
        "agreement": lambda account: 0.5,
        "agrees": lambda account: account.course in agree,
        "evidence": lambda account: worth[account.course],
        "is_doubtful": lambda account: True,
        "is_scattered": lambda account: account.course in scattered,
        "is_torn": lambda account: False,
    }
    told(monkeypatch, **(answers | (others or {})))
    return explained(Doubtful(stations)).course  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("agree", "scattered", "expected"),
    [
        (set(), set(), Course.NUDGED),
        ({Course.TRUSTED}, set(), Course.TRUSTED),
        ({Course.TRUSTED}, {Course.TRUSTED}, Course.NUDGED),
        ({Course.TRACKED}, set(), Course.TRACKED),
        ({Course.TRACKED}, {Course.TRACKED}, Course.NUDGED),
        ({Course.TRUSTED, Course.TRACKED}, {Course.TRUSTED}, Course.TRACKED),
    ],
)
def test_way_points_are_nudged_unless_walls_that_many_heard_agree(
    monkeypatch: pytest.MonkeyPatch, agree: set[Course], scattered: set[Course], expected: Course
) -> None:
    assert course(monkeypatch, agree=agree, scattered=scattered) is expected


@pytest.mark.parametrize("torn", [True, False])
def test_way_points_that_scatter_about_the_steps_are_nudged_for_their_frame_is_that_of_all(
    monkeypatch: pytest.MonkeyPatch, *, torn: bool
) -> None:
    others: dict[str, Any] = {"adds_up": lambda given, poses: False, "is_torn": lambda account: torn}
    found = course(monkeypatch, agree={Course.TRUSTED, Course.TRACKED}, scattered=set(), others=others)
    assert found is Course.NUDGED


def test_no_hand_set_so_many_way_points(monkeypatch: pytest.MonkeyPatch) -> None:
    many = AccountSettings().by_hand + 1
    assert course(monkeypatch, agree=set(), scattered=set(), stations=many) is Course.TRACKED
    assert course(monkeypatch, agree={Course.TRUSTED}, scattered={Course.TRUSTED}, stations=many) is Course.TRUSTED


def test_two_stations_have_nothing_to_hold_a_pose_against(monkeypatch: pytest.MonkeyPatch) -> None:
    assert course(monkeypatch, agree=set(), scattered=set(), stations=2) is Course.TRUSTED


def test_poses_settle_as_long_as_that_explains_more(monkeypatch: pytest.MonkeyPatch) -> None:
    account, worth = Doubtful(5), [0.0, 20.0, 40.0, 42.0, 90.0]
    account.settings = AccountSettings(poses=PoseMode.CORRECT)
    told(
        monkeypatch,
        agrees=lambda account: False,
        evidence=lambda account: worth[account.settled],
        is_torn=lambda account: True,
    )
    best: Any = explained(account)  # type: ignore[arg-type]
    assert best.settled == 2

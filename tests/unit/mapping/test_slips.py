"""A robot whose wheels slipped once in a hall in which nothing tells how far along it is but a pillar."""

import copy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.classification.hypotheses import Hypothesis
from echoplan.geometry import compose
from echoplan.io import builtin_rig
from echoplan.mapping import explaining
from echoplan.mapping.account import Account
from echoplan.mapping.explaining import explained
from echoplan.mapping.poses import displaced
from echoplan.mapping.settings import AccountSettings, PoseMode
from echoplan.mapping.slips import without_slip
from echoplan.model import Pillar, Polyline, Route, World
from echoplan.preprocessing.soundings import Soundings, join_soundings, soundings_of
from echoplan.simulation import Simulation, SimulationSettings

HALL = World(
    name="hall",
    polylines=(Polyline(points_xy=np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 3.0], [0.0, 3.0]]), closed=True),),
    pillars=(Pillar(center_xy=np.array([4.2, 1.6]), radius=0.25),),
)
WAY = np.array(
    [
        [1.8, 1.2, 0.1],
        [2.1, 1.9, 0.6],
        [1.9, 1.0, 0.4],
        [2.0, 1.6, 1.0],
        [3.1, 1.2, 0.2],
        [3.0, 2.2, 1.5],
        [3.1, 0.7, 2.6],
    ]
)
STEP, SLIP = 4, np.array([0.13, 0.0, 0.0])


@cache
def heard() -> Soundings:
    simulation = Simulation(
        world=HALL,
        rig=builtin_rig("rotary-array"),
        route=Route(map_from_base=WAY),
        settings=SimulationSettings(),
        seed=1,
    )
    return join_soundings([soundings_of(sweep, simulation.rig) for sweep in simulation])


@cache
def account(*, slips: bool) -> Account:
    """What was made of it, from the way as it was, or as if from one step on all were farther along the hall."""
    given = np.concatenate([WAY[:STEP], compose(SLIP, WAY[STEP:])]) if slips else WAY
    settings = AccountSettings(poses=PoseMode.CORRECT)
    account = Account(builtin_rig("rotary-array"), displaced(heard(), WAY, given), given, settings)
    if not slips:
        account.settle(account.odometry())
        return account
    account.model, account.noise = right().model, right().noise
    account.features = [part for each in right().features for part in parted(each)]
    return account


def right() -> Account:
    return account(slips=False)


def parted(feature: Hypothesis) -> list[Hypothesis]:
    """Two pillars instead of one; walls along the hall are the same from everywhere."""
    if feature.is_wall:
        return [feature]
    before, after = np.arange(len(WAY)) < STEP, np.arange(len(WAY)) >= STEP
    there = feature.reflector + np.array([0.0, *SLIP[:2], 0.0])
    return [
        replace(feature, gains=feature.gains * before),
        replace(feature, gains=feature.gains * after, reflector=there),
    ]


def test_a_slip_that_makes_two_pillars_of_one_is_taken_back() -> None:
    slipped = account(slips=True)
    poses = without_slip(slipped, slipped.odometry())
    assert poses is not None
    assert poses[:STEP] == pytest.approx(WAY[:STEP])
    assert np.hypot(*(poses - WAY)[:, :2].T).max() < 0.02


def test_where_nothing_seems_there_twice_no_step_is_doubted() -> None:
    assert without_slip(right(), right().odometry()) is None


def test_what_a_slip_tore_apart_is_one_again_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explaining, "track", Account.settle)
    monkeypatch.setattr(explaining, "agrees", lambda _: False)
    found = explained(copy.copy(account(slips=True)))
    assert sum(not each.is_wall for each in found.features) == 1
    assert np.hypot(*(found.poses - WAY)[:, :2].T).max() < 0.02
    assert found.verdict.endswith("a slip was taken back")

import math

import numpy as np
import pytest

from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.range_factors import Features
from echoplan.joint.optimisation.values import Values
from echoplan.preprocessing.servo import ServoError
from helpers.expectations import SONAR, corner, cylinder, wall

SERVO = ServoError(0.95, 0.07)


def state() -> Values:
    rows = np.array([wall(0.2, 1.5), cylinder(0.4, 1.0, 0.1), corner(2.0, 1.5)])
    extents = np.zeros((3, 2))
    none = np.zeros((3, 2))
    features = Features(
        reflectors=rows, extents=extents, attenuations=none, bias_variances=none, ends=edges_of(rows, extents)
    )
    poses = np.array([[0.0, 0.0, 0.1], [1.0, 0.5, -0.2]])
    return Values(features=features, model=SONAR, latency=0.003, servo=SERVO, poses=poses)


def test_values_follow_the_layout() -> None:
    now = state()
    layout, values = now.layout, now.values
    assert len(values) == layout.size == 2 + 3 + 2 + 9 + 6
    assert values[layout.feature(1)].tolist() == [0.4, 1.0, 0.1]
    sonar = [SONAR.range_offset, SONAR.walk_gain, SONAR.range_scale, 0.003, *SERVO]
    sonar += [SONAR.figure_of_merit, math.log(SONAR.ka), SONAR.walk_exponent]
    assert values[layout.sonar : layout.pose].tolist() == sonar
    assert values[layout.pose :].reshape(-1, 3).tolist() == now.poses.tolist()


def test_a_small_step_is_added_to_every_value() -> None:
    now, step = state(), np.linspace(0.0, 0.002, 22)
    assert now.retracted(step).values == pytest.approx(now.values + step)


def test_a_step_is_limited_to_five_centimetres() -> None:
    moved = state().retracted(np.ones(22))
    assert moved.features.reflectors[0, 1:3] == pytest.approx([0.25, 1.55])
    assert moved.poses == pytest.approx(state().poses + 0.05)
    assert moved.servo == pytest.approx(np.array(SERVO) + 0.05)


def test_a_long_step_is_shortened_in_its_direction() -> None:
    step = np.zeros(22)
    step[:2], step[-3:] = [0.02, 0.2], [0.1, -0.02, 0.01]
    moved = state().retracted(step)
    assert moved.features.reflectors[0, 1:3] == pytest.approx([0.205, 1.55])
    assert moved.poses[1] == pytest.approx(state().poses[1] + [0.05, -0.01, 0.005])


def test_the_step_of_a_wall_is_limited_at_its_middle_and_not_at_the_origin() -> None:
    # At 3 m along the wall 0.02 rad are 6 cm of offset: the middle of its extent does not move.
    now = state()
    extents = np.array([[2.5, 3.5], [0.0, 0.0], [0.0, 0.0]])
    now = Values(features=now.features._replace(extents=extents), model=SONAR, poses=now.poses)
    step = np.zeros(22)
    step[:2] = [0.02, 0.06]
    assert now.retracted(step).features.reflectors[0, 1:3] == pytest.approx([0.22, 1.56])


@pytest.mark.parametrize(("step", "radius"), [(-1.0, 0.05), (1.0, 0.15)])
def test_steps_of_radii_are_limited(step: float, radius: float) -> None:
    moved = state().retracted(np.full(22, step))
    assert moved.features.reflectors[1, 3] == pytest.approx(radius)


def test_radii_are_at_least_one_centimetre() -> None:
    now = state()
    for _ in range(5):
        now = now.retracted(np.full(22, -1.0))
    assert now.features.reflectors[1, 3] == pytest.approx(0.01)

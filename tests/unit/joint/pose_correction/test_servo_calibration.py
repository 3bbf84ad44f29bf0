"""Arcs of all stations lie on the same planes only with the right servo gain and offset."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.joint.pose_correction.servo_calibration import find_servo
from echoplan.joint.settings import EstimateSettings
from echoplan.preprocessing.measurements import Measurements, select_measurements
from echoplan.preprocessing.servo import AS_RECORDED, ServoError, turned_by
from helpers.expectations import ROOM, cylinder, listening, pings_of
from helpers.scenes import rig

STATIONS = [(-0.9, -0.6), (0.7, -0.9), (1.0, 0.8), (-0.6, 1.1), (0.2, 0.1)]
GIVEN = np.column_stack([STATIONS, np.zeros(len(STATIONS))])
POST = cylinder(1.3, -0.3, 0.1)[None]


def detected() -> Measurements:
    """Return pings of a sensor that turns from -90 to 90 degrees, with another heading at each station."""
    silent = listening(STATIONS, step=np.radians(2.0), rates=[0.5] * len(STATIONS))
    pings = pings_of(silent, np.concatenate([ROOM, POST]))
    headings = np.radians([0.0, 60.0, 150.0, -110.0, -30.0])[pings.stations]
    angles = np.angle(np.exp(1j * (pings.bearings - headings)))
    return select_measurements(pings._replace(angles=angles), np.abs(angles) < np.pi / 2)


def estimate(error: ServoError) -> Estimate:
    """Return the initial estimate with servo angles that have an error."""
    true = detected()
    recorded = true._replace(angles=(true.angles - error.offset) / error.gain)
    return initial_estimate(rig(), turned_by(recorded, error=AS_RECORDED, before=error), GIVEN, EstimateSettings())


@pytest.mark.parametrize(
    "error", [ServoError(0.92, np.radians(5.0)), ServoError(1.08, np.radians(-4.0)), ServoError(1.0, np.radians(8.0))]
)
def test_servo_gain_and_offset_are_found_from_arcs_alone(error: ServoError) -> None:
    found = find_servo(estimate(error))
    assert found is not None
    assert found.gain == pytest.approx(error.gain, abs=0.06)
    assert found.offset == pytest.approx(error.offset, abs=np.radians(3.0))


def test_a_servo_that_turns_as_recorded_has_no_error() -> None:
    assert find_servo(estimate(AS_RECORDED)) is None


@pytest.mark.parametrize("known", [None, ServoError(0.95, 0.05)])
def test_heading_factors_are_used_if_the_servo_was_calibrated_before(known: ServoError | None) -> None:
    later = initial_estimate(rig(), detected(), GIVEN, EstimateSettings(), MarginalPrior(servo=known))
    assert later.servo == known
    assert later.has_heading_factors == (known is not None)


def test_fixed_sensors_have_no_servo() -> None:
    fixed = estimate(ServoError(1.0, 0.1))
    fixed = replace(fixed, recorded=fixed.recorded._replace(rates=np.zeros(len(fixed.recorded.rates))))
    assert find_servo(fixed) is None


def test_too_few_arcs_give_no_servo_error() -> None:
    few = estimate(ServoError(0.92, 0.1))
    few = replace(few, arcs=few.arcs[:9])
    assert find_servo(few) is None

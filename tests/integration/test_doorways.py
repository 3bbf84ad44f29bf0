"""Drives by dead reckoning through the doorways of random flats."""

from itertools import islice

import numpy as np

from echoplan.geometry import compose, invert
from echoplan.methods import METHODS, map_sweeps
from library.days import flat_on_days


def test_stations_behind_a_doorway_that_were_registered_to_wrong_landmarks_are_put_right() -> None:
    # Pose tracking alone turns all stations behind the door by nine degrees.
    (drive, *_), _ = flat_on_days(3026)
    found = map_sweeps(METHODS["joint"].build(drive.rig), islice(drive, 24))
    errors = compose(invert(drive.truth.poses[:24]), found.poses)
    assert np.hypot(*errors[:, :2].T).max() < 0.03

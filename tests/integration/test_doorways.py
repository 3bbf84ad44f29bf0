"""Drives by dead reckoning through the doorways of random flats."""

from itertools import islice

import numpy as np

from echoplan.geometry import compose, invert
from echoplan.joint.localisation import localise
from echoplan.methods import METHODS, map_sweeps
from library.days import flat_on_days, in_frame_of_odometry


def test_stations_behind_a_doorway_that_were_registered_to_wrong_landmarks_are_put_right() -> None:
    # Pose tracking alone turns all stations behind the door by nine degrees.
    (drive, *_), _ = flat_on_days(3026)
    found = map_sweeps(METHODS["joint"].build(drive.rig), islice(drive, 24))
    errors = compose(invert(drive.truth.poses[:24]), found.poses)
    assert np.hypot(*errors[:, :2].T).max() < 0.03


def test_a_recording_that_begins_between_two_faces_of_a_partition_is_located() -> None:
    # The first station fits 10 cm beside its place, too, as do those of the opposite half of the room.
    (first, second, _), _ = flat_on_days(3052)
    known = map_sweeps(METHODS["joint"].build(first.rig), tuple(first))
    found = localise(in_frame_of_odometry(tuple(second), day=1)[:12], known, rig=second.rig)
    errors = compose(invert(second.truth.poses[:12]), found.poses)
    assert not found.kidnapped
    assert np.hypot(*errors[:, :2].T).max() < 0.05

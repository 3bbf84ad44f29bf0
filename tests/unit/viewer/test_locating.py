import math
from dataclasses import replace

import numpy as np

from echoplan.model import Localisation, Quality, StartPose, TrajectorySegment, Verdict
from echoplan.viewer import localisation_lines

GOOD = Quality(verdict=Verdict.GOOD)
START = (StartPose(pose=np.zeros(3), weight=1.0),)
FOUND = Localisation(
    sweeps=np.array([0, 2, 5]),
    poses=np.array([[0.8, 3.5, 0.0], [1.0, 3.5, 0.0], [4.45, 2.021, -math.pi / 2]]),
    covariances=np.tile(np.diag([0.001, 0.002, math.radians(0.1)]) ** 2, (3, 1, 1)),
    segments=(TrajectorySegment(first=0, starts=START),),
    inlier_ratio=0.984,
    jaccard_index=0.97,
)


def test_the_first_and_the_last_pose_are_printed_with_their_95_percent_intervals() -> None:
    assert localisation_lines(FOUND, GOOD) == (
        "Located: echoes and map agree to 97 %.",
        "First pose: x 0.800 ± 0.002 m, y 3.500 ± 0.004 m, yaw 0.00 ± 0.20°",
        "Last pose: x 4.450 ± 0.002 m, y 2.021 ± 0.004 m, yaw -90.00 ± 0.20°",
    )


def test_it_is_printed_between_which_sweeps_the_robot_was_carried_elsewhere() -> None:
    carried = replace(FOUND, segments=(*FOUND.segments, TrajectorySegment(first=5, starts=START)))
    assert "The robot was carried elsewhere between sweeps 2 and 5." in localisation_lines(carried, GOOD)


def test_reasons_and_the_next_step_follow_the_verdict() -> None:
    doubtful = Quality(verdict=Verdict.DOUBTFUL, reasons=("The map itself is doubtful.",), next_step="Map again.")
    assert localisation_lines(FOUND, doubtful)[:3] == (
        "Located, but doubtful: echoes and map agree to 97 %.",
        "The map itself is doubtful.",
        "Next step: Map again.",
    )

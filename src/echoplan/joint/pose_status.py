"""The decision about the poses and its reason, as codes and numbers; the viewer turns them into sentences."""

from dataclasses import dataclass
from enum import StrEnum

__all__ = ["PoseModel", "PoseReason", "PoseStatus"]


class PoseModel(StrEnum):
    """Model of the pose errors: none, independent poses, or odometry, whose errors accumulate."""

    FIXED = "fixed"
    ABSOLUTE = "absolute"
    ODOMETRY = "odometry"


class PoseReason(StrEnum):
    """Reason why poses are used as recorded (``TRUSTED`` to ``NO_BETTER_POSES``) or corrected."""

    TRUSTED = "trusted"
    CONSISTENT = "consistent"
    TOO_FEW_ECHOES = "too few echoes"
    NO_CORRECTION_NEEDED = "no correction needed"
    NO_BETTER_POSES = "no better poses"
    ODOMETRY = "odometry"
    DUPLICATED_WALLS = "duplicated walls"
    INCONSISTENT = "inconsistent"
    MORE_LIKELY = "more likely"


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseStatus:
    """Why poses are corrected or not."""

    reason: PoseReason = PoseReason.TRUSTED
    # Share of echoes that the map explains from the recorded poses, if this was the test.
    inlier_ratio: float | None = None
    # Whether the user requested a correction.
    is_requested: bool = False
    # Whether the rig specifies the noise of its odometry.
    is_odometry_specified: bool = False
    # Whether the odometry noise is greater than specified.
    exceeds_specification: bool = False
    # Whether a step was an outlier: wheel slip.
    has_slips: bool = False

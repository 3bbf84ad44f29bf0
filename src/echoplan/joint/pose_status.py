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
    """Why poses are corrected or not.

    Parameters
    ----------
    reason : PoseReason
        Test that decided.
    inlier_ratio : float, optional
        Share of echoes that the map explains from the recorded poses, if this was the test.
    is_requested : bool, optional
        Whether the user requested a correction.
    is_odometry_specified : bool, optional
        Whether the rig specifies the noise of its odometry.
    exceeds_specification : bool, optional
        Whether the odometry noise is greater than specified.
    has_slips : bool, optional
        Whether a step was an outlier: wheel slip.
    """

    reason: PoseReason = PoseReason.TRUSTED
    inlier_ratio: float | None = None
    is_requested: bool = False
    is_odometry_specified: bool = False
    exceeds_specification: bool = False
    has_slips: bool = False

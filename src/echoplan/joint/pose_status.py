"""What was done about the poses, and why: codes and numbers, of which the viewer makes sentences."""

from dataclasses import dataclass
from enum import StrEnum

__all__ = ["PoseModel", "PoseReason", "PoseStatus"]


class PoseModel(StrEnum):
    """Model of the errors of the poses: none, each pose by itself, or each step of the odometry."""

    FIXED = "fixed"
    ABSOLUTE = "absolute"
    ODOMETRY = "odometry"


class PoseReason(StrEnum):
    """Why poses are used as recorded (the first five) or corrected."""

    REQUESTED = "requested"
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
    """Why poses were corrected or not.

    Parameters
    ----------
    reason : PoseReason
        The test that decided.
    inlier_ratio : float, optional
        Share of echoes that the map explains from the poses as recorded, where this decided.
    is_requested : bool, optional
        Whether the user asked for a correction.
    is_odometry_specified : bool, optional
        Whether the rig specifies the noise of its odometry.
    exceeds_specification : bool, optional
        Whether errors of the odometry are larger than that.
    has_slips : bool, optional
        Whether a step was an outlier: a slip of a wheel.
    """

    reason: PoseReason = PoseReason.REQUESTED
    inlier_ratio: float | None = None
    is_requested: bool = False
    is_odometry_specified: bool = False
    exceeds_specification: bool = False
    has_slips: bool = False

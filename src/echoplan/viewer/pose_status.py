"""What was done about the poses, and why, in words."""

from collections.abc import Mapping
from typing import Any

from echoplan.joint.pose_status import PoseModel, PoseReason

__all__ = ["poses_in_words"]

_AS_RECORDED = {
    PoseReason.TRUSTED: "used as recorded, as requested",
    PoseReason.CONSISTENT: "used as recorded: {share} of the echoes fit together",
    PoseReason.TOO_FEW_ECHOES: "used as recorded: too few echoes to check them",
    PoseReason.NO_CORRECTION_NEEDED: "no correction was needed: the echoes fit together as well from the poses as "
    "recorded",
    PoseReason.NO_BETTER_POSES: "left as recorded: only {share} of the echoes fit together, and other poses explain no "
    "more",
}
_CORRECTED = {
    PoseReason.ODOMETRY: "",
    PoseReason.DUPLICATED_WALLS: ": too many walls were duplicated from the poses as recorded",
    PoseReason.INCONSISTENT: ": only {share} of the echoes fit together from the poses as recorded",
    PoseReason.MORE_LIKELY: ": {share} of the echoes fit together from the poses as recorded, but {model} explain them "
    "better",
}
_REMARKS = {
    "exceeds_specification": "; its errors are larger than specified",
    "has_slips": "; a wheel slipped",
}
_MODELS = {PoseModel.ODOMETRY: "errors of the odometry", PoseModel.ABSOLUTE: "pose errors of a few centimetres"}


def poses_in_words(status: Mapping[str, Any] | str) -> str:
    """Say what was done about the poses.

    Parameters
    ----------
    status : mapping of str to object, or str
        The status as in ``map.json``; versions before 0.1.0 wrote the sentence.

    Returns
    -------
    str
        The sentence, without a full stop.
    """
    if isinstance(status, str):
        return status
    ratio, reason = status.get("inlier_ratio"), PoseReason(status["reason"])
    words = {
        "share": "" if ratio is None else f"{100.0 * ratio:.0f} %",
        "model": _MODELS.get(PoseModel(status["model"]), ""),
    }
    if reason in _AS_RECORDED:
        return _AS_RECORDED[reason].format(**words)
    cause = ""
    if status["is_requested"]:
        cause = ", as requested"
    elif status["is_odometry_specified"]:
        cause = ", because the rig specifies errors of its odometry"
    parts = [
        "corrected by a few centimetres" if status["model"] == PoseModel.ABSOLUTE else "corrected",
        cause,
        _CORRECTED[reason].format(**words),
        *(words for flag, words in _REMARKS.items() if status[flag]),
    ]
    return "".join(parts)

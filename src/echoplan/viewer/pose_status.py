"""What was done about the poses, and why, in words."""

from collections.abc import Mapping
from typing import Any

__all__ = ["poses_in_words"]

_AS_RECORDED = {
    "requested": "used as recorded, as requested",
    "consistent": "used as recorded: {share} of the echoes fit together",
    "too few echoes": "used as recorded: too few echoes to check them",
    "no correction needed": "no correction was needed: the echoes fit together as well from the poses as recorded",
    "no better poses": "left as recorded: only {share} of the echoes fit together, and other poses explain no more",
}
_CORRECTED = {
    "odometry": "",
    "duplicated walls": ": from the poses as recorded, most walls were there twice",
    "inconsistent": ": only {share} of the echoes fit together from the poses as recorded",
    "more likely": ": {share} of the echoes fit together from the poses as recorded, but {model} explain them better",
}
_REMARKS = {
    "exceeds_specification": "; its errors are larger than specified",
    "has_slips": "; a wheel slipped",
}
_MODELS = {"odometry": "steps of the robot with errors", "absolute": "places a few centimetres elsewhere"}


def poses_in_words(status: Mapping[str, Any] | str) -> str:
    """Say what was done about the poses.

    Parameters
    ----------
    status : mapping of str to object, or str
        The status as in ``map.json``; earlier releases wrote the sentence itself.

    Returns
    -------
    str
        The sentence, without a full stop.
    """
    if isinstance(status, str):
        return status
    ratio, reason = status.get("inlier_ratio"), status["reason"]
    words = {"share": "" if ratio is None else f"{100.0 * ratio:.0f} %", "model": _MODELS.get(status["model"], "")}
    if reason in _AS_RECORDED:
        return _AS_RECORDED[reason].format(**words)
    parts = [
        "corrected by a few centimetres" if status["model"] == "absolute" else "corrected",
        _cause(status),
        _CORRECTED[reason].format(**words),
        *(words for flag, words in _REMARKS.items() if status[flag]),
    ]
    return "".join(parts)


def _cause(status: Mapping[str, Any]) -> str:
    if status["is_requested"]:
        return ", as requested"
    return ", because the rig specifies errors of its odometry" if status["is_odometry_specified"] else ""

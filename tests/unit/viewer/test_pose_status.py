from dataclasses import asdict

import pytest

from echoplan.joint.pose_status import PoseModel, PoseReason, PoseStatus
from echoplan.viewer.pose_status import poses_in_words


def sentence(model: PoseModel, reason: PoseReason, **details: object) -> str:
    status = PoseStatus(reason=reason, inlier_ratio=0.49, **details)  # type: ignore[arg-type]
    return poses_in_words({"model": model, **asdict(status)})


@pytest.mark.parametrize("reason", PoseReason)
@pytest.mark.parametrize("model", PoseModel)
def test_every_status_has_a_sentence(model: PoseModel, reason: PoseReason) -> None:
    words = sentence(model, reason)
    assert words
    assert not set("{}") & set(words)


def test_a_sentence_says_who_asked_and_what_odometry_did() -> None:
    asked = sentence(PoseModel.ODOMETRY, PoseReason.INCONSISTENT, is_requested=True, has_slips=True)
    assert asked == (
        "corrected, as requested: only 49 % of the echoes fit together from the poses as recorded; a wheel slipped"
    )
    specified = sentence(
        PoseModel.ODOMETRY, PoseReason.ODOMETRY, is_odometry_specified=True, exceeds_specification=True
    )
    assert specified == (
        "corrected, because the rig specifies errors of its odometry; its errors are larger than specified"
    )


def test_sentences_of_earlier_versions_are_kept() -> None:
    assert poses_in_words("used as recorded, as asked for") == "used as recorded, as asked for"

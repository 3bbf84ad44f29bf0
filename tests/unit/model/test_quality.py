"""Quality: a verdict with its reasons."""

from dataclasses import FrozenInstanceError

import pytest

from echoplan.model import Quality, Verdict


def test_a_verdict_is_written_as_its_word() -> None:
    assert [str(verdict) for verdict in Verdict] == ["good", "doubtful", "failed"]


def test_a_quality_does_not_change() -> None:
    quality = Quality(verdict=Verdict.GOOD)
    with pytest.raises(FrozenInstanceError):
        quality.verdict = Verdict.FAILED  # type: ignore[misc]

import pytest

from echoplan.cli.results import say_what_was_found
from echoplan.viewer import Plan
from helpers import maps
from helpers.drawings import gapped_map


def test_what_was_found_is_said_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    found = maps.drawn(*(maps.wall(*ends) for ends in maps.ROOM.walls_xy), poses=maps.ROOM.poses)
    say_what_was_found(Plan(feature_map=found))
    assert capsys.readouterr().out == "6 walls, 0 corners and 0 cylinders, detected from 2 stations.\n"


def test_openings_are_listed_with_their_widths(capsys: pytest.CaptureFixture[str]) -> None:
    say_what_was_found(Plan(feature_map=gapped_map()))
    printed = capsys.readouterr().out
    assert "0.900 ± 0.039" in printed
    assert "driven through" in printed
    assert "seen through" in printed

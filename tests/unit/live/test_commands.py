import json

import pytest

from echoplan.errors import InputError
from echoplan.live.commands import PlaceCommand, SaveCommand, parse_command


def test_a_place_is_read_in_metres_and_radians() -> None:
    text = '{"type": "place", "station": 2, "x": 1.5, "y": -2, "yaw": 0.5}'
    assert parse_command(text) == PlaceCommand(type="place", station=2, x=1.5, y=-2.0, yaw=0.5)


def test_a_command_without_details_is_read() -> None:
    assert parse_command(b'{"type": "save"}') == SaveCommand(type="save")


@pytest.mark.parametrize(
    "wrong",
    [
        "",
        "[]",
        "{",
        '{"type": "format"}',
        '{"type": "save", "path": "/etc"}',
        '{"type": "play", "playing": "yes"}',
        '{"type": "place", "x": NaN, "y": 0, "yaw": 0}',
        '{"type": "place", "x": 1e300, "y": 0, "yaw": 0}',
        '{"type": "place", "x": 0, "y": 0, "yaw": 0, "station": -1}',
        '{"type": "place", "x": 0, "y": 0, "yaw": 0, "station": 1.5}',
        '{"type": "place", "x": "0", "y": 0, "yaw": 0}',
        b"\xff",
        "[" * 4000,
    ],
)
def test_what_is_no_command_is_refused_in_one_line(wrong: str | bytes) -> None:
    with pytest.raises(InputError, match="reload the page") as caught:
        parse_command(wrong)
    assert "\n" not in str(caught.value)


def test_a_command_is_the_same_however_it_is_written() -> None:
    command = {"yaw": 0, "type": "place", "y": 0, "x": 1}
    assert parse_command(json.dumps(command)) == parse_command(json.dumps(command, indent=1, sort_keys=True))

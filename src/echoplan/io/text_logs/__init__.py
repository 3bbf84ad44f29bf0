"""Text logs of hobby projects: what a robot printed, read as a recording."""

from echoplan.io.text_logs.facts import Fact, Origin, Skipped
from echoplan.io.text_logs.log import TextLog, read_text_log
from echoplan.io.text_logs.options import (
    LogOptions,
    Place,
    parse_angles,
    parse_heading,
    parse_length,
    parse_place,
    read_places,
)

__all__ = [
    "Fact",
    "LogOptions",
    "Origin",
    "Place",
    "Skipped",
    "TextLog",
    "parse_angles",
    "parse_heading",
    "parse_length",
    "parse_place",
    "read_places",
    "read_text_log",
]

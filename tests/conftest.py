"""Tests give the same result on every run, whatever the machine's pace and whatever was asked of the terminal."""

import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

# Whoever runs the tests may have asked for colours or a width: the tests say themselves what they want of a terminal.
for _wish in ("FORCE_COLOR", "NO_COLOR", "COLUMNS", "LINES", "TTY_COMPATIBLE", "TTY_INTERACTIVE"):
    os.environ.pop(_wish, None)
os.environ["TERM"] = "xterm"
# A job that a shell starts in the background ignores interrupts, and so would the programs that the tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Property tests draw the same fifty examples on every run, and a slow machine does not fail them.
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("repeatable")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of whole folders as slow."""
    folders = [Path(__file__).parent / name for name in ("integration", "property")]
    for item in items:
        if any(item.path.is_relative_to(folder) for folder in folders):
            item.add_marker(pytest.mark.slow)

"""Commands as they are typed, for tests."""

import contextlib
import io
import sys
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import pytest

from echoplan.cli.main import main


@dataclass(frozen=True, slots=True, kw_only=True)
class Done:
    """Result of a command."""

    status: int
    out: str
    err: str


def echoplan(*words: str | Path) -> Done:
    """Run a command within this process, which has everything imported."""
    out, err = io.StringIO(), io.StringIO()
    typed = ["echoplan", *map(str, words)]
    with (
        patch.object(sys, "argv", typed),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        pytest.raises(SystemExit) as ended,
    ):
        main()
    return Done(status=int(ended.value.code or 0), out=out.getvalue(), err=err.getvalue())


def succeed(*words: str | Path) -> str:
    """Run a command that must work and say nothing on standard error; return what it printed."""
    done = echoplan(*words)
    assert (done.status, done.err) == (0, "")
    return done.out

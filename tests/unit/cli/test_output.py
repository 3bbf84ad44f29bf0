import os
import signal
from pathlib import Path

import pytest

from echoplan.cli.output import output_folder


def test_a_command_that_is_terminated_leaves_the_folder_as_it_was_and_nothing_beside_it(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "map.json").write_text("old")
    before = signal.getsignal(signal.SIGTERM)

    def write_until_terminated() -> None:
        with output_folder(tmp_path / "out") as draft:
            draft.mkdir()
            (draft / "map.json").write_text("new")
            os.kill(os.getpid(), signal.SIGTERM)

    with pytest.raises(SystemExit) as ended:
        write_until_terminated()
    assert ended.value.code == 143
    assert list(tmp_path.rglob("*")) == [tmp_path / "out", tmp_path / "out" / "map.json"]
    assert (tmp_path / "out" / "map.json").read_text() == "old"
    assert signal.getsignal(signal.SIGTERM) == before

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.errors import InputError
from echoplan.io import read_trajectory, write_trajectory

ROWS = st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 2, st.floats(-3.14, 3.14)), min_size=0, max_size=20)


@given(rows=ROWS)
def test_what_was_written_is_read_again(
    rows: list[tuple[float, float, float]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("trajectory") / "trajectory.tum"
    poses, stamps_ns = np.array(rows).reshape(-1, 3), 1_763_700_000_123_456_789 + np.arange(len(rows))
    write_trajectory(path, stamps_ns, poses)
    read_stamps_ns, read_poses = read_trajectory(path)
    assert read_stamps_ns.tolist() == stamps_ns.tolist()
    np.testing.assert_allclose(read_poses, poses, atol=1e-8)


def test_lines_are_those_of_the_tum_benchmark(tmp_path: Path) -> None:
    path = tmp_path / "trajectory.tum"
    write_trajectory(path, np.array([1_500_000_000]), np.array([[1.0, 2.0, np.pi]]))
    head, line = path.read_text().splitlines()
    assert head.startswith("#")
    assert [float(text) for text in line.split()] == pytest.approx([1.5, 1, 2, 0, 0, 0, 1, 0], abs=1e-9)


def test_any_rotation_about_the_vertical_is_a_yaw(tmp_path: Path) -> None:
    path = tmp_path / "trajectory.tum"
    path.write_text("0 0 0 0 0 0 -0.5 -0.8660254\n")
    assert np.degrees(read_trajectory(path)[1][0, 2]) == pytest.approx(60.0, abs=1e-4)


@pytest.mark.parametrize(("line", "said"), [("1 2 3", "3 numbers"), ("1 2 3 4 5 6 7 eight", "not all numbers")])
def test_a_bad_line_is_named(tmp_path: Path, line: str, said: str) -> None:
    path = tmp_path / "trajectory.tum"
    path.write_text(f"# head\n0 0 0 0 0 0 0 1\n{line}\n")
    with pytest.raises(InputError, match=f"line 3.*{said}"):
        read_trajectory(path)

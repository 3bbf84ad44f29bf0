"""Changes in words and in pictures."""

import numpy as np
from matplotlib.figure import Figure

from echoplan.model import Changes, Cylinder
from echoplan.viewer.changes import changes_in_words, draw_changes
from echoplan.viewer.palette import GONE, NEW

WALL = np.array([[0.0, 1.0], [0.0, 2.5]])
PILLAR = Cylinder(center_xy=np.array([1.0, -2.0]), radius=0.06, covariance=1e-6 * np.eye(3))


def test_a_map_of_one_recording_has_no_changes_to_tell() -> None:
    assert changes_in_words(()) == ()


def test_nothing_is_said_to_have_changed_in_so_many_words() -> None:
    (section,) = changes_in_words([Changes(recording="tuesday")])
    assert section.items == (("Changed when tuesday was recorded", "nothing"),)


def test_what_is_gone_comes_before_what_is_new() -> None:
    changed = Changes(recording="b", gone_walls=(WALL,), gone_cylinders=(PILLAR,), new_walls=(WALL + 1.0,))
    (section,) = changes_in_words([changed])
    gone = "gone: a wall of 1.50 m at x 0.00 m, y 1.75 m, a cylinder of 60 mm radius at x 1.00 m, y -2.00 m"
    assert section.items[0][1] == f"{gone}; new: a wall of 1.50 m at x 1.00 m, y 2.75 m"


def test_each_recording_has_a_line() -> None:
    (section,) = changes_in_words([Changes(recording="tuesday"), Changes(recording="friday", new_walls=(WALL,))])
    assert [name.split()[2] for name, _ in section.items] == ["tuesday", "friday"]


def test_what_is_gone_is_dashed_and_what_is_new_is_not() -> None:
    axes = Figure().add_subplot()
    draw_changes(axes, [Changes(gone_walls=(WALL, WALL + 1.0), new_walls=(WALL,), new_cylinders=(PILLAR,))])
    assert [line.get_color() for line in axes.lines] == [GONE, GONE, NEW, NEW]
    assert [line.get_linestyle() for line in axes.lines] == ["--", "--", "-", "-"]
    # The legend names each kind once.
    assert [line.get_label() for line in axes.lines if not str(line.get_label()).startswith("_")] == ["gone", "new"]

import numpy as np
import pytest

from echoplan.classical.loci.carving import carve, longest_runs, sample_turns
from helpers import arcs

WALL = (0.0, 2.0)
HERE = [(0.0, 0.0)]


def left_of(older: list[tuple[float, float]], cone: float, *, core: float = 1.0) -> tuple[float, float]:
    """Carve the arc of a wall by a longer echo in some direction; the outermost angles that are left."""
    arc = arcs.on_wall(WALL, older)
    newer = arcs.on_wall((0.0, 4.0), HERE, turns=(cone,))
    turns = sample_turns(arc, 81)
    left = carve(arc.points_xy(turns), np.ones((1, 81), dtype=bool), newer, margin=0.05, core=core)
    return float(turns[left].min()), float(turns[left].max())


def test_a_newer_echo_from_farther_away_cuts_its_beam_out_of_an_older_arc() -> None:
    assert left_of(HERE, 0.5) == pytest.approx((-0.4, 0.1 - 0.01), abs=0.011)
    assert left_of(HERE, -0.5) == pytest.approx((-0.1 + 0.01, 0.4), abs=0.011)


def test_only_the_core_of_a_beam_cuts() -> None:
    assert left_of(HERE, 0.5, core=0.5) == pytest.approx((-0.4, 0.3), abs=0.011)
    assert left_of(HERE, 0.5, core=0.2) == pytest.approx((-0.4, 0.4), abs=0.011)


def test_an_echo_of_the_same_thing_cuts_nothing() -> None:
    arc = arcs.on_wall(WALL, HERE)
    again = arcs.on_wall(WALL, HERE, turns=(-0.2, 0.0, 0.2))
    points = arc.points_xy(sample_turns(arc, 25))
    assert carve(points, np.ones((1, 25), dtype=bool), again, margin=0.05).all()


def test_a_beam_cuts_nothing_behind_itself() -> None:
    arc = arcs.on_wall(WALL, HERE)
    away = arcs.on_wall((np.pi, 4.0), HERE)
    assert carve(arc.points_xy(sample_turns(arc, 25)), np.ones((1, 25), dtype=bool), away, margin=0.05).all()


def test_what_is_cut_stays_cut() -> None:
    arc = arcs.on_wall(WALL, HERE)
    none = np.zeros((1, 25), dtype=bool)
    assert not carve(arc.points_xy(sample_turns(arc, 25)), none, arcs.nothing(), margin=0.05).any()


def test_the_longest_piece_counts_and_the_first_of_several() -> None:
    turns = np.tile(np.arange(6.0), (4, 1))
    left = np.array([[1, 1, 0, 1, 1, 1], [1, 1, 0, 0, 1, 1], [0] * 6, [1] * 6], dtype=bool)
    pieces = longest_runs(left, turns)
    assert pieces.arcs.tolist() == [0, 1, 3]
    assert pieces.turns.tolist() == [4.0, 0.5, 2.5]
    assert pieces.widths.tolist() == [3.0, 2.0, 6.0]

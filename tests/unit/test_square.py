"""How square a square room comes out, measured by a benchmark."""

from functools import cache
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.simulation import Simulation

SQUARE = run_path(str(Path(__file__).parents[2] / "benchmarks" / "square.py"))


@cache
def room() -> Simulation:
    made = SQUARE["square_room"](0)
    assert isinstance(made, Simulation)
    return made


@cache
def judged(name: str) -> tuple[dict[str, float], dict[str, float]]:
    """Error [mm] and tilt [degrees] of what a method draws, and of its map."""
    _, *both = SQUARE["judged"](room(), name)
    drawn, mapped = ({"error": 1000 * each.error, "tilt": np.degrees(each.tilt)} for each in both)
    return drawn, mapped


def tilt(points_xy: FloatArray) -> float:
    return float(np.degrees(SQUARE["tilt"](points_xy)))


def side(*, turned: float = 0.0) -> FloatArray:
    """Points along a line of three metres."""
    return np.linspace(0.0, 3.0, 301)[:, None] * directions(turned)


@pytest.mark.parametrize("degrees", [0.0, 10.0, 45.0, 80.0, 90.0, 170.0])
def test_the_tilt_of_a_line_is_its_angle_from_the_nearer_axis(degrees: float) -> None:
    assert tilt(side(turned=np.radians(degrees))) == pytest.approx(min(degrees % 90, 90 - degrees % 90), abs=1e-6)


def test_a_circle_is_tilted_by_half_of_the_greatest_tilt() -> None:
    circle = 1.5 * directions(np.linspace(0.0, 2 * np.pi, 1000, endpoint=False))
    assert tilt(circle) == pytest.approx(22.5, abs=0.1)


def test_of_a_square_only_its_corners_are_tilted() -> None:
    truth = room().truth
    square = SQUARE["Outline"](segments_xy=truth.walls_xy, circles=truth.cylinders).samples(0.01)
    assert tilt(square) < 2.0
    assert SQUARE["squareness"](square, truth).error == pytest.approx(0.0, abs=1e-9)


def test_where_nothing_is_drawn_nothing_is_tilted() -> None:
    assert np.isnan(tilt(np.zeros((0, 2))))
    assert np.isnan(tilt(np.zeros((5, 2))))


def test_the_plain_plot_of_points_comes_out_round() -> None:
    drawn, _ = judged("point-plot")
    assert drawn["tilt"] > 14.0
    assert drawn["error"] > 80.0


def test_what_robots_have_today_comes_out_rounder_than_a_circle_as_it_cuts_the_corners_off() -> None:
    drawn, _ = judged("grid-range-layer")
    assert drawn["tilt"] > 22.5
    assert drawn["error"] > 200.0


def test_the_joint_map_comes_out_square() -> None:
    _, mapped = judged("joint")
    assert mapped["tilt"] < 2.0
    assert mapped["error"] < 2.0


def test_the_papers_map_comes_out_square_too() -> None:
    _, mapped = judged("mdp-fuzzy")
    assert mapped["tilt"] < 2.0
    assert mapped["error"] < 10.0

import numpy as np
import pytest

from echoplan.classical.arc_carving import ArcCarvingMapper, ArcCarvingSettings
from echoplan.classical.loci.carving import CarvingSettings
from echoplan.model import Sweep
from helpers import scenes


def sweep_of_one_ping(degree: int, reading: float, *, index: int) -> Sweep:
    """One echo in one direction, from the origin."""
    ranges = np.full(360, np.inf)
    ranges[degree + 45] = reading
    return scenes.sweep_of(ranges, index=index)


def mapped(*sweeps: Sweep) -> ArcCarvingMapper:
    mapper = ArcCarvingMapper(scenes.rig(), ArcCarvingSettings(carving=CarvingSettings(core=1.0)))
    for sweep in sweeps:
        mapper.add(sweep)
    return mapper


def test_an_uncut_arc_says_nothing_yet() -> None:
    assert mapped(sweep_of_one_ping(0, 1.0, index=0)).points_xy.shape == (0, 2)


def test_a_newer_echo_from_farther_away_turns_an_older_point_aside() -> None:
    (point,) = mapped(sweep_of_one_ping(0, 1.0, index=0), sweep_of_one_ping(20, 2.5, index=1)).points_xy
    # What is left of the arc of 35 degrees to either side reaches from -35 to about -15 degrees.
    assert np.degrees(np.arctan2(point[1], point[0] - scenes.ARM)) == pytest.approx(-25.0, abs=2.0)
    assert np.hypot(point[0] - scenes.ARM, point[1]) == pytest.approx(1.0)


def test_an_older_echo_does_not_cut_a_newer_arc() -> None:
    assert mapped(sweep_of_one_ping(20, 2.5, index=0), sweep_of_one_ping(0, 1.0, index=1)).points_xy.shape == (0, 2)


def test_an_arc_that_is_cut_away_leaves_no_point() -> None:
    assert mapped(sweep_of_one_ping(0, 1.0, index=0), sweep_of_one_ping(0, 2.5, index=1)).points_xy.shape == (0, 2)

import numpy as np
import pytest

from echoplan.classical.loci import Loci, VoteSettings, line_ballot, point_ballot
from helpers import arcs

# In the middle of a cell.
WALL = (17 * 0.0175, 67.5 * 0.03)
POINT = (3.01, 1.02)
STATIONS = [(0.0, 0.0), (0.3, 0.9), (0.5, -0.8), (1.1, 0.2)]
SETTINGS = VoteSettings()


def test_echoes_of_a_wall_vote_for_one_line() -> None:
    loci = arcs.on_wall(WALL, STATIONS, turns=(-0.2, 0.1))
    cell, votes = line_ballot(loci, SETTINGS).leader()
    assert votes == 8
    assert line_ballot(loci, SETTINGS).voters(cell).tolist() == list(range(8))


def test_echoes_of_a_point_vote_for_one_point() -> None:
    loci = arcs.on_point(POINT, STATIONS, turns=(-0.2, 0.1))
    assert point_ballot(loci, SETTINGS).leader()[1] == 8
    assert line_ballot(loci, SETTINGS).leader()[1] < 8


def test_a_line_beside_the_beam_gets_no_vote() -> None:
    past = arcs.on_wall(WALL, STATIONS, turns=(arcs.HALF_APERTURE + 0.03,))
    straight = arcs.on_wall(WALL, STATIONS)
    cell, _ = line_ballot(Loci.joined([straight, past]), SETTINGS).leader()
    assert line_ballot(Loci.joined([straight, past]), SETTINGS).voters(cell).tolist() == [0, 1, 2, 3]


def test_cells_with_echoes_of_too_few_sweeps_do_not_lead() -> None:
    loci = arcs.on_wall(WALL, STATIONS[:2], turns=np.linspace(-0.3, 0.3, 20).tolist())
    for ballot in (line_ballot(loci, SETTINGS), point_ballot(loci, SETTINGS)):
        assert ballot.leader()[1] == -np.inf
    assert line_ballot(loci, VoteSettings(min_sweeps=2)).leader()[1] >= 40


@pytest.mark.parametrize("ballot_of", [line_ballot, point_ballot])
def test_an_echo_has_one_vote_in_a_cell(ballot_of: type) -> None:
    loci = arcs.on_point(POINT, STATIONS[:1], turns=(0.0,))
    near = Loci(
        centers_xy=loci.centers_xy,
        ranges=np.array([0.05]),
        bearings=loci.bearings,
        half_apertures=loci.half_apertures,
        sweeps=loci.sweeps,
    )
    assert ballot_of(near, VoteSettings(min_sweeps=1)).leader()[1] == 1


def test_there_are_no_votes_where_nothing_was_detected() -> None:
    for ballot in (line_ballot(arcs.nothing(), SETTINGS), point_ballot(arcs.nothing(), SETTINGS)):
        assert ballot.leader()[1] <= 0

import numpy as np

from echoplan.classical.features.ballots import Ballot

CELLS = np.array([[0, 3], [1, 3], [0, 2], [2, 2]])


def test_the_leader_has_the_greatest_weight_of_votes() -> None:
    assert Ballot(CELLS, np.array([1.0, 1.0, 0.5, 0.1])).leader() == (3, 2.0)
    assert Ballot(CELLS, np.array([1.0, 1.0, 1.5, 0.1])).leader() == (0, 2.5)


def test_of_several_leaders_the_first_wins() -> None:
    assert Ballot(np.array([[2, 1], [1, 2]]), np.ones(2)).leader() == (1, 2.0)


def test_votes_are_withdrawn_only_once() -> None:
    ballot = Ballot(CELLS, np.ones(4))
    ballot.withdraw(np.array([0]))
    ballot.withdraw(np.array([0]))
    assert ballot.voters(3).tolist() == [1]
    assert ballot.leader() == (2, 3.0)
    ballot.withdraw(np.array([1, 2, 3]))
    assert ballot.leader()[1] == 0.0


def test_the_weights_of_the_caller_stay_as_they_are() -> None:
    weights = np.ones(4)
    Ballot(CELLS, weights).withdraw(np.array([0, 1]))
    assert weights.tolist() == [1.0] * 4


def test_a_cell_that_was_struck_out_does_not_lead() -> None:
    ballot = Ballot(CELLS, np.ones(4))
    ballot.strike(np.array([2, 3]))
    assert ballot.leader() == (0, 2.0)
    ballot.withdraw(np.array([0]))
    assert ballot.leader() == (0, 1.0)
    assert ballot.voters(2).tolist() == [2, 3, 3]


def test_cells_may_have_any_numbers() -> None:
    ballot = Ballot(np.array([[-(10**15), 7], [10**15, -(10**15)]]), np.ones(2))
    assert ballot.leader() == (-(10**15), 2.0)
    ballot.withdraw(np.array([0]))
    ballot.strike(np.array([-(10**15)]))
    assert ballot.leader() == (10**15, 1.0)
    assert ballot.voters(10**15).tolist() == [1]


def test_a_ballot_without_votes_has_no_leader() -> None:
    assert Ballot(np.zeros((0, 5), dtype=np.int64), np.zeros(0)).leader() == (0, 0.0)

from math import isnan

from echoplan.evaluation import Tally


def test_recall_counts_what_was_wanted_and_precision_what_was_estimated() -> None:
    tally = Tally(wanted=8, found=6, right=7, duplicate=1, spurious=2)
    assert tally.estimates == 10
    assert tally.recall == 0.75
    assert tally.precision == 0.7


def test_shares_of_nothing_are_unknown() -> None:
    assert isnan(Tally().recall)
    assert isnan(Tally().precision)


def test_tallies_add_up_count_by_count() -> None:
    first = Tally(wanted=1, found=2, right=3, duplicate=4, spurious=5)
    second = Tally(wanted=10, found=20, right=30, duplicate=40, spurious=50)
    assert first + second == Tally(wanted=11, found=22, right=33, duplicate=44, spurious=55)

from itertools import pairwise

import numpy as np
import pytest
import skfuzzy

from echoplan.classical.covering import Covering
from echoplan.classical.fuzzy import CORRECTIONS, CROSSINGS, class_of, corrected_memberships, memberships
from echoplan.model import FeatureClass

WIDTHS = np.linspace(0.0, 1.0, 1001)
RANK = {FeatureClass.CORNER: 0, FeatureClass.CYLINDER: 1, FeatureClass.WALL: 2}


def ranks(covering: Covering, rules: str) -> list[int]:
    return [RANK[class_of(corrected_memberships(width, covering, rules=rules))] for width in WIDTHS]


def test_the_crossings_of_equation_seventeen_are_where_the_memberships_cross() -> None:
    assert pytest.approx((0.4109, 0.6614), abs=5e-5) == CROSSINGS
    small, medium, _ = memberships(CROSSINGS[0])
    assert small == pytest.approx(medium)
    _, medium, big = memberships(CROSSINGS[1])
    assert medium == pytest.approx(big)


def test_the_printed_first_crossing_would_lie_where_nothing_crosses() -> None:
    big, medium, small = 0.90, 0.55, 0.15
    printed = (big * small - small**2) / (-2 * small + big + medium)
    assert printed < small
    assert memberships(printed).tolist() == [1.0, 0.0, 0.0]


def test_memberships_are_those_of_an_independent_library() -> None:
    expected = np.stack(
        [
            skfuzzy.trapmf(WIDTHS, [0.0, 0.0, 0.15, 0.90]),
            skfuzzy.trimf(WIDTHS, [0.15, 0.55, 0.90]),
            skfuzzy.trapmf(WIDTHS, [0.15, 0.90, 1.0, 1.0]),
        ],
        axis=1,
    )
    assert np.allclose(memberships(WIDTHS), expected)


def test_the_class_is_the_one_an_independent_inference_gives() -> None:
    for width in WIDTHS[::7]:
        degrees = memberships(width)
        # Largest of maxima over the three classes as singletons 0, 1, 2: ties go to the larger class.
        largest = skfuzzy.defuzz(np.arange(3), degrees, "lom")
        assert RANK[class_of(degrees)] == largest


def test_widths_beyond_the_greatest_count_as_the_greatest() -> None:
    assert memberships(1.7).tolist() == memberships(1.0).tolist() == [0.0, 0.0, 1.0]


# Table 4 as the reading notes unroll it: range state, covering, what is added.
TABLE_4 = [
    (0.10, Covering.NONE, (0.0, 0.0, 0.0)),
    (0.10, Covering.LEFT, (-0.25, 0.25, 0.0)),
    (0.10, Covering.RIGHT, (-0.25, 0.25, 0.0)),
    (0.10, Covering.FRONT, (-0.30, 0.0, 0.30)),
    (0.55, Covering.NONE, (0.0, 0.0, 0.0)),
    (0.55, Covering.LEFT, (0.0, -0.20, 0.20)),
    (0.55, Covering.RIGHT, (0.0, -0.20, 0.20)),
    (0.55, Covering.FRONT, (0.0, -0.30, 0.30)),
    (0.95, Covering.NONE, (0.0, 0.0, 0.0)),
    (0.95, Covering.LEFT, (0.0, 0.0, 0.0)),
    (0.95, Covering.RIGHT, (0.0, 0.0, 0.0)),
    (0.95, Covering.FRONT, (0.0, 0.0, 0.0)),
]


@pytest.mark.parametrize(("width", "covering", "added"), TABLE_4)
def test_every_cell_of_table_four(width: float, covering: Covering, added: tuple[float, ...]) -> None:
    assert corrected_memberships(width, covering) - memberships(width) == pytest.approx(added)


def test_ties_go_to_the_larger_class() -> None:
    assert class_of(np.array([0.5, 0.5, 0.2])) is FeatureClass.CYLINDER
    assert class_of(np.array([0.5, 0.5, 0.5])) is FeatureClass.WALL


def test_the_literal_rules_call_a_wider_cluster_a_lesser_class() -> None:
    falls = {state: any(b < a for a, b in pairwise(ranks(state, "paper"))) for state in Covering}
    assert falls == {Covering.NONE: False, Covering.LEFT: True, Covering.RIGHT: True, Covering.FRONT: True}


@pytest.mark.parametrize("covering", Covering)
def test_the_monotone_rules_never_do(covering: Covering) -> None:
    found = ranks(covering, "monotone")
    assert all(b >= a for a, b in pairwise(found))
    assert found[0] == 0
    assert found[-1] == 2


def test_without_covering_both_sets_of_rules_agree() -> None:
    assert ranks(Covering.NONE, "paper") == ranks(Covering.NONE, "monotone")


def classes(width: float, covering: Covering, rules: str) -> FeatureClass:
    return class_of(corrected_memberships(width, covering, rules=rules))


# By hand from Eq. 14-16 and Table 4: where small, corrected, meets its rival, and where medium, corrected, meets big.
BORDERS = [
    (Covering.NONE, 0.47250 / 1.15000, 0.72750 / 1.10000),
    (Covering.LEFT, 1.07500 / (4 / 3 + 5 / 2), (2.49 / 1.05) / (4.4 / 1.05)),
    (Covering.RIGHT, 1.07500 / (4 / 3 + 5 / 2), (2.49 / 1.05) / (4.4 / 1.05)),
    (Covering.FRONT, 0.30000, 0.30000),
]


@pytest.mark.parametrize(("covering", "corner_below", "flat_from"), BORDERS)
def test_the_monotone_rules_have_two_borders(covering: Covering, corner_below: float, flat_from: float) -> None:
    hair = 1e-6
    assert classes(corner_below - hair, covering, "monotone") is FeatureClass.CORNER
    assert classes(flat_from + hair, covering, "monotone") is FeatureClass.WALL
    if corner_below < flat_from:
        assert classes(corner_below + hair, covering, "monotone") is FeatureClass.CYLINDER
        assert classes(flat_from - hair, covering, "monotone") is FeatureClass.CYLINDER


@pytest.mark.parametrize("covering", [Covering.LEFT, Covering.RIGHT])
def test_to_the_letter_a_cluster_covered_at_one_end_changes_its_class_five_times(covering: Covering) -> None:
    found = [classes(width, covering, "paper") for width in (0.28, 0.29, 0.40, 0.42, 0.44, 0.47, 0.52, 0.56, 0.57)]
    corner, cylinder, wall = FeatureClass.CORNER, FeatureClass.CYLINDER, FeatureClass.WALL
    assert found == [corner, cylinder, cylinder, corner, corner, wall, cylinder, cylinder, wall]


def test_covering_never_makes_the_monotone_class_smaller() -> None:
    free = ranks(Covering.NONE, "monotone")
    for covering in (Covering.LEFT, Covering.FRONT):
        assert all(b >= a for a, b in zip(free, ranks(covering, "monotone"), strict=True))


def test_the_table_cannot_be_changed_by_accident() -> None:
    with pytest.raises(ValueError, match="read-only"):
        CORRECTIONS[0, 0, 0] = 1.0

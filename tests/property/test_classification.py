"""Laws of the fuzzy model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.classical.covering import Covering, covering_state
from echoplan.classical.fuzzy import class_of, corrected_memberships, memberships
from echoplan.model import FeatureClass
from helpers import scenes

RANK = {FeatureClass.CORNER: 0, FeatureClass.CYLINDER: 1, FeatureClass.WALL: 2}
widths = st.floats(0.0, 1.2)
coverings = st.sampled_from(Covering)
ends = st.one_of(st.floats(0.1, 3.0), st.just(float("inf")))


@given(widths)
def test_memberships_are_shares_and_some_class_is_always_meant(width: float) -> None:
    degrees = memberships(width)
    assert ((degrees >= 0) & (degrees <= 1)).all()
    assert degrees.max() > 0.5


@given(widths, st.floats(0.0, 1.2))
def test_a_wider_cluster_is_less_small_and_more_big(width: float, other: float) -> None:
    narrow, wide = memberships(min(width, other)), memberships(max(width, other))
    assert narrow[0] >= wide[0]
    assert narrow[2] <= wide[2]


@given(widths, coverings)
def test_the_rules_of_the_paper_take_from_one_class_what_they_give_to_another(width: float, covering: Covering) -> None:
    assert corrected_memberships(width, covering).sum() == pytest.approx(memberships(width).sum())


@given(widths)
def test_left_and_right_are_alike(width: float) -> None:
    for rules in ("paper", "monotone"):
        left, right = (corrected_memberships(width, each, rules=rules) for each in (Covering.LEFT, Covering.RIGHT))
        np.testing.assert_array_equal(left, right)


@given(widths, st.floats(0.0, 1.2), coverings)
def test_by_the_monotone_rules_a_wider_cluster_is_never_a_lesser_class(
    width: float, other: float, covering: Covering
) -> None:
    narrow, wide = (
        RANK[class_of(corrected_memberships(each, covering, rules="monotone"))] for each in sorted((width, other))
    )
    assert narrow <= wide


@given(ends, ends)
def test_mirrored_clusters_are_covered_on_the_other_side(right: float, left: float) -> None:
    bearings = scenes.around(0.0, 0.2)
    state, mirrored = (
        covering_state(scenes.cluster(bearings, np.ones(len(bearings)), right=one, left=other))
        for one, other in ((right, left), (left, right))
    )
    swapped = {Covering.LEFT: Covering.RIGHT, Covering.RIGHT: Covering.LEFT}
    assert mirrored is swapped.get(state, state)

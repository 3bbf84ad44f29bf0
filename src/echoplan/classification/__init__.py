"""From located objects to classes: the covering state and the fuzzy model of the paper."""

from echoplan.classification.covering import Covering, covering_state
from echoplan.classification.fuzzy import (
    CROSSINGS,
    FuzzySettings,
    RangeState,
    class_of,
    corrected_memberships,
    memberships,
)

__all__ = [
    "CROSSINGS",
    "Covering",
    "FuzzySettings",
    "RangeState",
    "class_of",
    "corrected_memberships",
    "covering_state",
    "memberships",
]

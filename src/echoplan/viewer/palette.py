"""Colours and marks that the colour-blind can distinguish, and in grey by lightness and shape.

The lightness (CIE L*) of the three classes is 23, 61 and 49, and each stands at least 3 : 1 against white; seen without
red, green or blue receptors any two still differ by 38 or more (CIE 1976 colour difference).
"""

from collections.abc import Mapping
from types import MappingProxyType

from echoplan.model import FeatureClass

__all__ = ["COLORS", "FAINT", "GONE", "INK", "MARKERS", "MUTED", "NEW", "TRUTH"]

INK = "#1d2430"
MUTED = "#6b7280"
FAINT = "#d5d9e0"
TRUTH = "#e0a030"
# What an earlier recording found and this one did not, dashed, and the other way round.
GONE, NEW = "#cc4b24", "#2fa58e"

COLORS: Mapping[FeatureClass, str] = MappingProxyType(
    {FeatureClass.WALL: "#17375e", FeatureClass.CORNER: "#cc4b24", FeatureClass.CYLINDER: "#2fa58e"}
)
MARKERS: Mapping[FeatureClass, str] = MappingProxyType(
    {FeatureClass.WALL: "s", FeatureClass.CORNER: "^", FeatureClass.CYLINDER: "o"}
)

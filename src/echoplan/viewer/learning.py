"""What a recording taught about the sonar and the poses, in words."""

import math
from collections.abc import Mapping
from typing import Any

from echoplan.model import FeatureMap
from echoplan.viewer.sections import Definitions

__all__ = ["learned_in_words"]

# Name, what it is called, what turns it into its unit, and the unit.
_NUMBERS = (
    ("range_scale", "Ranges are too short by", 100.0, "%"),
    ("range_offset", "Ranges at 1 m are too long by", 1000.0, "mm"),
    ("walk_gain", "Faint echoes are read too far by up to", 1000.0, "mm"),
    ("servo_latency", "The servo lags by", 1000.0, "ms"),
)
# A value that the pings did not narrow down by this factor is what was believed before.
_DETERMINED = 0.5


def learned_in_words(feature_map: FeatureMap) -> tuple[Definitions, ...]:
    """Say what was learned beside the map.

    Parameters
    ----------
    feature_map : FeatureMap
        A map whose method learns about the sonar.

    Returns
    -------
    tuple of Definitions
        One; none if the method learns nothing.

    Examples
    --------
    >>> learned_in_words(FeatureMap(method="rcd"))
    ()
    """
    found = feature_map.parameters.get("found")
    if not isinstance(found, Mapping) or not found:
        return ()
    items = [(words, _value(found[name], factor, unit)) for name, words, factor, unit in _NUMBERS if name in found]
    noise = ("Readings scatter by", f"{1000 * float(found['noise']):.1f} mm")
    poses = ("Poses", str(found.get("poses", "trusted")))
    open_ways = [("Not determined", _open_way(each)) for each in found.get("undetermined", ())]
    return (Definitions(title="What the recording tells of itself", items=(poses, *open_ways, *items, noise)),)


def _open_way(found: Mapping[str, Any]) -> str:
    direction = math.degrees(float(found["direction"]))
    along, across = (1000 * float(found[name]) for name in ("along", "across"))
    return (
        f"the position along {direction:.0f}\N{DEGREE SIGN} from sweep {found['first']} to {found['last']}: only "
        f"odometry tells it, to \N{PLUS-MINUS SIGN} {along:.0f} mm at worst, {across:.0f} mm between the walls"
    )


def _value(number: Mapping[str, Any], factor: float, unit: str) -> str:
    value, sigma = factor * float(number["value"]), factor * float(number["sigma"])
    if sigma > _DETERMINED * factor * float(number["believed"]):
        return "not determined by this recording"
    digits = max(0, min(3, 1 - math.floor(math.log10(max(sigma, 1e-3)))))
    return f"{value:.{digits}f} \N{PLUS-MINUS SIGN} {sigma:.{digits}f} {unit}"

"""Calibration of the sonar and quality of the poses, in words."""

import cmath
import math
from collections.abc import Mapping, Sequence
from typing import Any

from echoplan.model import Conventions, FeatureMap
from echoplan.viewer.pose_status import poses_in_words
from echoplan.viewer.sections import Definitions

__all__ = ["learned_in_words"]

# Name, what it is called above and below zero and where it is not determined, factor to its unit, and the unit.
# The range offset is in map.json only: no recording determines it better than modules are set.
_NUMBERS = (
    ("range_scale", ("Ranges are too short by", "Ranges are too long by", "Ranges are off by"), 100.0, "%"),
    (
        "walk_gain",
        (
            "Weak echoes read long, by up to",
            "Weak echoes read short, by up to",
            "Weak echoes read long, by up to",
        ),
        1000.0,
        "mm",
    ),
    ("servo_latency", ("The servo lags by", "The servo leads by", "The servo lags by"), 1000.0, "ms"),
)
# Of a servo that is calibrated: name, what it is called, what turns it into its unit, and the unit.
_SERVO = (
    ("servo_gain", "The servo turns", 1.0, " of the recorded angle"),
    ("servo_offset", "Where it records 0 the servo stands at", math.degrees(1.0), "\N{DEGREE SIGN}"),
)
# What robot simulators make of a sonar.
_CONE = "the nearest points in cones of rays of \N{PLUS-MINUS SIGN}{:.1f}\N{DEGREE SIGN}, as robot simulators make them"
# A value that the pings did not narrow down by this factor is only the prior.
_DETERMINED = 0.5
_OPEN = "not determined by this recording"
# Stretches along one direction [rad] at most this many sweeps apart are reported as one.
_ONE_WAY, _BETWEEN = math.radians(15), 12


def learned_in_words(feature_map: FeatureMap, conventions: Conventions | None = None) -> tuple[Definitions, ...]:
    """Describe the calibration and the pose quality that a map was made with.

    Parameters
    ----------
    feature_map : FeatureMap
        A map whose method learns about the sonar.
    conventions : Conventions, optional
        How the recording that was mapped is written: what makes a finding permanent comes on top of them.

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
    items = [_item(found[name], words, factor, unit) for name, words, factor, unit in _NUMBERS if name in found]
    scatter = _OPEN if feature_map.is_empty else f"{1000 * float(found['noise']):.1f} mm"
    noise = ("Readings scatter by", scatter)
    poses = ("Poses", poses_in_words(found.get("poses", "used as recorded")))
    rays = [("Readings are", _CONE.format(math.degrees(float(found["cone"]))))] if "cone" in found else []
    square = [_square(feature_map, found["right_angles"])] if found.get("right_angles") else []
    open_ways = [("Not determined", _open_way(each)) for each in _joined(found.get("undetermined", ()))]
    lines = (*rays, poses, *open_ways, *square, *items, *_servo(found, conventions), noise)
    return (Definitions(title="Calibration and quality", items=lines),)


def _servo(found: Mapping[str, Any], conventions: Conventions | None) -> list[tuple[str, str]]:
    """Write gain and offset of a servo that was calibrated, and how to make them permanent."""
    items, known = [], {"gain": 1.0, "offset": 0.0}
    now = conventions or Conventions()
    for name, words, factor, unit in _SERVO:
        if name not in found:
            continue
        value, sigma, prior_sigma = (float(found[name][key]) for key in ("value", "sigma", "prior_sigma"))
        if sigma > _DETERMINED * prior_sigma:
            items.append((words, _OPEN))
            continue
        digits = _digits(factor * sigma)
        items.append((words, f"{factor * value:.{digits}f} \N{PLUS-MINUS SIGN} {factor * sigma:.{digits}f}{unit}"))
        known[name.removeprefix("servo_")] = value
    then = now.with_servo(**known)
    keys = [f"{name} = {getattr(then, name):.5f}" for name, *_ in _SERVO if getattr(then, name) != getattr(now, name)]
    return [*items, ("To make that permanent", f"{', '.join(keys)} in [conventions] of rig.toml")] if keys else items


def _digits(sigma: float) -> int:
    return max(0, min(3, 1 - math.floor(math.log10(max(sigma, 1e-3)))))


def _square(feature_map: FeatureMap, square: Mapping[str, Any]) -> tuple[str, str]:
    closely = f"{math.degrees(float(square['sigma'])):.2f}\N{DEGREE SIGN}"
    count, where = (
        f"{square['walls']} of {len(feature_map.walls)}",
        ", along the axes" if square.get("along_axes") else "",
    )
    return "Walls at right angles", f"{count}, \N{PLUS-MINUS SIGN} {closely}{where}"


def _joined(stretches: Sequence[Mapping[str, Any]]) -> list[list[Mapping[str, Any]]]:
    """Join stretches separated by few sweeps, for example where a door fixes the position for a moment."""
    joined: list[list[Mapping[str, Any]]] = []
    for each in stretches:
        if joined and _goes_on(joined[-1][-1], each):
            joined[-1].append(each)
        else:
            joined.append([each])
    return joined


def _goes_on(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    turned = math.remainder(float(after["direction"]) - float(before["direction"]), math.pi)
    return abs(turned) < _ONE_WAY and int(after["first"]) - int(before["last"]) <= _BETWEEN


def _open_way(stretches: Sequence[Mapping[str, Any]]) -> str:
    # Twice the angle: a direction and its opposite are the same.
    mean = sum((each["last"] - each["first"] + 1) * cmath.exp(2j * each["direction"]) for each in stretches)
    direction, mostly = round(math.degrees(cmath.phase(mean) / 2)), ", mostly" if len(stretches) > 1 else ""
    along, across = (1000 * max(float(each[name]) for each in stretches) for name in ("along", "across"))
    return (
        f"the position along {direction}\N{DEGREE SIGN} from sweep {stretches[0]['first']} to {stretches[-1]['last']}"
        f"{mostly}: known only from odometry, \N{PLUS-MINUS SIGN}{along:.0f} mm along and "
        f"\N{PLUS-MINUS SIGN}{across:.0f} mm across at worst"
    )


def _item(number: Mapping[str, Any], words: tuple[str, str, str], factor: float, unit: str) -> tuple[str, str]:
    value, sigma = factor * float(number["value"]), factor * float(number["sigma"])
    is_determined, air = sigma <= _DETERMINED * factor * float(number["prior_sigma"]), number.get("temperature")
    if not is_determined and air is None:
        return words[2], _OPEN
    digits = _digits(sigma)
    source = "" if air is None else f", in air of {float(air):.1f} \N{DEGREE SIGN}C by the thermometer"
    return words[value < 0.0], f"{abs(value):.{digits}f} \N{PLUS-MINUS SIGN} {sigma:.{digits}f} {unit}{source}"

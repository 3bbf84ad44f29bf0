"""Whether a localisation in a map can be trusted, and if not, why."""

import math
from collections.abc import Iterator

from echoplan.model import FeatureMap, Localisation, Quality, Stretch, Verdict

__all__ = ["assess_localisation"]

# Share of the echoes that the map explains: below the first one, a part does not fit; below the second one, it is
# another place. In 30 rooms the map of another room explained 0.34 to 0.88 (benchmarks/localisation.py 30), in 6 of
# them the right one 0.84 to 1.00 (benchmarks/localisation.py 6 --first 2010).
_LIKELY, _LEAST = 0.88, 0.7
# Number of alternatives that are listed, and least probability of one.
_MOST, _POSSIBLE = 3, 0.01


def assess_localisation(localisation: Localisation, feature_map: FeatureMap) -> Quality:
    """Tell whether a localisation can be trusted.

    Parameters
    ----------
    localisation : Localisation
        The poses.
    feature_map : FeatureMap
        The map in which they are.

    Returns
    -------
    Quality
        ``failed`` if the map does not explain the echoes; ``doubtful`` if it explains some, if other poses fit as well,
        or if the map itself is not good.
    """
    reasons, share = [*_reasons(localisation, feature_map)], localisation.inlier_ratio
    if share < _LEAST:
        step = "Check that the map is of this place, and that echoplan map makes a good map of the recording."
        return Quality(verdict=Verdict.FAILED, reasons=tuple(reasons), next_step=step)
    if not reasons:
        return Quality(verdict=Verdict.GOOD)
    first = localisation.stretches[0].is_ambiguous
    step = "Pass --start X,Y,YAW, or drive on until the echoes differ." if first else "Map the place again."
    return Quality(verdict=Verdict.DOUBTFUL, reasons=tuple(reasons), next_step=step)


def _reasons(localisation: Localisation, feature_map: FeatureMap) -> Iterator[str]:
    if localisation.inlier_ratio < _LIKELY:
        yield f"Only {100.0 * localisation.inlier_ratio:.0f} % of the echoes fit the map."
    yield from (_ambiguity(each) for each in localisation.stretches if each.is_ambiguous)
    if feature_map.quality is not None and feature_map.quality.verdict is not Verdict.GOOD:
        yield f"The map itself is {feature_map.quality.verdict}."


def _ambiguity(stretch: Stretch) -> str:
    """List the poses that fit nearly as well as the most likely one."""
    likely = [each for each in stretch.starts[:_MOST] if each.weight > _POSSIBLE]
    poses = (
        f"x {each.pose[0]:.2f} m, y {each.pose[1]:.2f} m, yaw {math.degrees(each.pose[2]):.0f}° "
        f"({100.0 * each.weight:.0f} %)"
        for each in likely
    )
    return f"Sweep {stretch.first} may be at {' or '.join(poses)}."

"""Whether a localisation in a map can be trusted, and if not, why."""

import math
from collections.abc import Iterator

from echoplan.diagnosis.findings import faults_in_words
from echoplan.model import FeatureMap, Localisation, Quality, TrajectorySegment, Verdict
from echoplan.preprocessing import Faults

__all__ = ["assess_localisation"]

# Share of the echoes that the map explains: below the first one, a part does not fit; below the second one, it is
# another place. In 30 rooms the map of another room explained 0.34 to 0.88 (benchmarks/localisation.py 30), in 6 of
# them the right one 0.84 to 1.00 (benchmarks/localisation.py 6 --first 2010).
_MIN_GOOD, _MIN_LOCATED = 0.88, 0.7
# Number of alternatives that are listed, and least probability of one.
_MAX_LISTED, _MIN_LISTED_WEIGHT = 3, 0.01


def assess_localisation(
    localisation: Localisation, feature_map: FeatureMap, *, faults: Faults | None = None
) -> Quality:
    """Tell whether a localisation can be trusted.

    Parameters
    ----------
    localisation : Localisation
        The poses.
    feature_map : FeatureMap
        The map in which they are.
    faults : Faults, optional
        Faults of the recording; none by default.

    Returns
    -------
    Quality
        ``failed`` if the map does not explain the echoes; ``doubtful`` if it explains some, if other poses fit as well,
        or if the map itself is not good.
    """
    found = () if faults is None else faults_in_words(faults)
    reasons = [*_reasons(localisation, feature_map), *found]
    if localisation.inlier_ratio < _MIN_LOCATED:
        step = "check that the map is of this place, and that echoplan map makes a good map of the recording"
        return Quality(verdict=Verdict.FAILED, reasons=tuple(reasons), next_step=step)
    if not reasons:
        return Quality(verdict=Verdict.GOOD)
    if found:
        step = "Correct the sensor, and record again."
    elif localisation.segments[0].is_ambiguous:
        step = "Pass --start X,Y,YAW, or drive on until the echoes differ."
    else:
        step = "Map the place again."
    return Quality(verdict=Verdict.DOUBTFUL, reasons=tuple(reasons), next_step=step)


def _reasons(localisation: Localisation, feature_map: FeatureMap) -> Iterator[str]:
    if localisation.inlier_ratio < _MIN_GOOD:
        yield f"Only {100.0 * localisation.inlier_ratio:.0f} % of the echoes fit the map."
    yield from (_ambiguity(each) for each in localisation.segments if each.is_ambiguous)
    if feature_map.quality is not None and feature_map.quality.verdict is not Verdict.GOOD:
        yield f"The map itself is {feature_map.quality.verdict}."


def _ambiguity(segment: TrajectorySegment) -> str:
    """List the poses that fit nearly as well as the most likely one."""
    likely = [each for each in segment.starts[:_MAX_LISTED] if each.weight > _MIN_LISTED_WEIGHT]
    poses = (
        f"x {each.pose[0]:.2f} m, y {each.pose[1]:.2f} m, yaw {math.degrees(each.pose[2]):.0f}° "
        f"({100.0 * each.weight:.0f} %)"
        for each in likely
    )
    return f"Sweep {segment.first} may be at {' or '.join(poses)}."

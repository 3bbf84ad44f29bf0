"""Whether a localisation in a map can be trusted, and if not, why."""

import math
from collections.abc import Iterator

from echoplan.diagnosis.findings import faults_in_words
from echoplan.model import FeatureMap, Localisation, Quality, TrajectorySegment, Verdict
from echoplan.preprocessing import Faults

__all__ = ["assess_localisation", "disagreement", "listed_starts"]

# Jaccard index of echoes and map: below the first one, the map does not show all that is there; below the second one,
# it is of another place. benchmarks/localisation.py prints it for maps of other rooms and for the right ones, and
# benchmarks/several_recordings.py counts the recordings that are refused or joined wrongly because of the first one.
_MIN_GOOD, _MIN_LOCATED = 0.7, 0.6
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
        ``failed`` if echoes and map do not agree; ``doubtful`` if they agree in part, if other poses fit as well, or if
        the map itself is not good.
    """
    found = () if faults is None else faults_in_words(faults)
    reasons = [*_reasons(localisation, feature_map), *found]
    if localisation.jaccard_index < _MIN_LOCATED:
        step = "check that the map is of this place, and that echoplan map makes a good map of the recording"
        return Quality(verdict=Verdict.FAILED, reasons=tuple(reasons), next_step=step)
    if not reasons:
        return Quality(verdict=Verdict.GOOD)
    if found:
        step = "Correct the sensor, and record again."
    elif localisation.is_ambiguous:
        step = "Pass --start X,Y,YAW, or drive on until the echoes differ."
    else:
        step = "Map the place again."
    return Quality(verdict=Verdict.DOUBTFUL, reasons=tuple(reasons), next_step=step)


def _reasons(localisation: Localisation, feature_map: FeatureMap) -> Iterator[str]:
    if few := disagreement(localisation):
        yield f"{few[:1].upper()}{few[1:]}."
    yield from (
        f"Sweep {each.first} may be at {listed_starts(each)}." for each in localisation.segments if each.is_ambiguous
    )
    if feature_map.quality is not None and feature_map.quality.verdict is not Verdict.GOOD:
        yield f"The map itself is {feature_map.quality.verdict}."


def disagreement(localisation: Localisation) -> str:
    """Say that echoes and map do not agree as they do in the right place.

    Parameters
    ----------
    localisation : Localisation
        The poses in the map.

    Returns
    -------
    str
        How far they agree, and what is needed; empty if that is enough.
    """
    if localisation.jaccard_index >= _MIN_GOOD:
        return ""
    needed = f"{100.0 * _MIN_GOOD:.0f} % are needed"
    return f"echoes and map agree to only {localisation.percent_in_common} % ({needed})"


def listed_starts(segment: TrajectorySegment) -> str:
    """List the poses at which a part of a recording may begin.

    Parameters
    ----------
    segment : TrajectorySegment
        The part.

    Returns
    -------
    str
        The most likely poses, at most three, with their probabilities.
    """
    likely = [each for each in segment.starts[:_MAX_LISTED] if each.weight > _MIN_LISTED_WEIGHT]
    return " or ".join(
        f"x {each.pose[0]:.2f} m, y {each.pose[1]:.2f} m, yaw {math.degrees(each.pose[2]):.0f}° "
        f"({100.0 * each.weight:.0f} %)"
        for each in likely
    )

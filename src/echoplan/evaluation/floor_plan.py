"""A map as a floor plan: how much of the walls is drawn, where the openings are, and where walls end."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.evaluation.doorways import Doorway, count_stations, true_doorways
from echoplan.evaluation.intervals import IntervalErrors
from echoplan.evaluation.lengths import WallLengths, measure_lengths
from echoplan.evaluation.matches import Matching, OpeningMatch, WallMatch
from echoplan.evaluation.matching import MatchingSettings, angles_between, one_each
from echoplan.evaluation.outlines import OutlineSettings
from echoplan.evaluation.tally import Tally
from echoplan.geometry import lines_through
from echoplan.model import FeatureMap, Opening, Truth, Wall

__all__ = ["FloorPlanScore", "match_openings", "score_floor_plan"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FloorPlanScore:
    """How good a map is as a floor plan; scores of several maps add up.

    Parameters
    ----------
    lengths : WallLengths, optional
        Lengths of drawn and true walls.
    openings : Tally, optional
        Counts of openings; estimates of true ones that do not count for recall are left out.
    opening_widths : IntervalErrors, optional
        Of the right openings.
    wall_ends : IntervalErrors, optional
        Of both ends of each right wall, along the wall; positive where the wall is drawn too long.
    """

    lengths: WallLengths = field(default_factory=WallLengths)
    openings: Tally = field(default_factory=Tally)
    opening_widths: IntervalErrors = field(default_factory=IntervalErrors)
    wall_ends: IntervalErrors = field(default_factory=IntervalErrors)

    def __add__(self, other: "FloorPlanScore") -> "FloorPlanScore":
        return FloorPlanScore(
            lengths=self.lengths + other.lengths,
            openings=self.openings + other.openings,
            opening_widths=self.opening_widths + other.opening_widths,
            wall_ends=self.wall_ends + other.wall_ends,
        )


def score_floor_plan(
    feature_map: FeatureMap,
    truth: Truth,
    walls: Matching[WallMatch],
    *,
    matching: MatchingSettings,
    outlines: OutlineSettings,
) -> FloorPlanScore:
    """Score a map as a floor plan.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    truth : Truth
        The true walls and poses.
    walls : Matching of WallMatch
        Which wall is of which true wall.
    matching : MatchingSettings
        When an opening is right, and which true objects count.
    outlines : OutlineSettings
        When a stretch of a wall is right.

    Returns
    -------
    FloorPlanScore
        Of this map.
    """
    openings = match_openings(feature_map.openings, truth, matching)
    return FloorPlanScore(
        lengths=measure_lengths(feature_map, truth, min_stations=matching.min_stations, settings=outlines),
        openings=openings.tally,
        opening_widths=IntervalErrors(
            errors=np.array([match.width_error for match in openings.right]),
            sigmas=np.array([feature_map.openings[match.estimate].width_sigma for match in openings.right]),
        ),
        wall_ends=_wall_ends(feature_map, truth, walls),
    )


def match_openings(openings: Sequence[Opening], truth: Truth, settings: MatchingSettings) -> Matching[OpeningMatch]:
    """Match openings: each with the nearest doorway of about the same direction; of duplicates the nearest stands.

    Parameters
    ----------
    openings : sequence of Opening
        The estimates.
    truth : Truth
        The true walls and poses.
    settings : MatchingSettings
        How close, how nearly parallel.

    Returns
    -------
    Matching of OpeningMatch
        A doorway is wanted if the path leads through it or enough stations face it.  Estimates of other doorways are
        neither right nor wrong: they are left out.
    """
    doorways = true_doorways(truth)
    candidates = [_candidate(number, opening, doorways, settings) for number, opening in enumerate(openings)]
    detected_by = count_stations(doorways, truth, reach=settings.opening_reach)
    every = one_each(candidates, detected_by=detected_by, settings=settings, rank=lambda match: match.distance)
    return Matching(
        right=tuple(match for match in every.right if match.truth in every.wanted),
        duplicate=tuple(match for match in every.duplicate if match.truth in every.wanted),
        spurious=every.spurious,
        detected_by=detected_by,
        wanted=every.wanted,
        found=every.found,
    )


def _candidate(
    number: int, opening: Opening, doorways: Sequence[Doorway], settings: MatchingSettings
) -> OpeningMatch | None:
    middle, (direction, _) = opening.endpoints_xy.mean(axis=0), lines_through(*opening.endpoints_xy)
    matches = [
        OpeningMatch(
            truth=truth,
            estimate=number,
            distance=float(np.hypot(*(doorway.middles_xy - middle).T).min()),
            width_error=opening.width - doorway.width,
        )
        for truth, doorway in enumerate(doorways)
        if angles_between(direction, lines_through(*doorway.endpoints_xy)[0]) <= settings.opening_angle
    ]
    near = [match for match in matches if match.distance <= settings.opening_distance]
    return min(near, key=lambda match: match.distance, default=None)


def _wall_ends(feature_map: FeatureMap, truth: Truth, walls: Matching[WallMatch]) -> IntervalErrors:
    """Errors of the ends of right walls."""
    drawn = [feature_map.walls[match.estimate] for match in walls.right]
    errors = [_end_errors(wall, truth.walls_xy[match.truth]) for wall, match in zip(drawn, walls.right, strict=True)]
    return IntervalErrors(
        errors=np.concatenate([np.zeros(0), *errors]),
        sigmas=np.concatenate([np.zeros(0), *(wall.endpoint_sigmas for wall in drawn)]),
    )


def _end_errors(wall: Wall, true_ends_xy: FloatArray) -> FloatArray:
    """By how much a wall is drawn too long at its start and at its end, shape (2,) [m]."""
    span = wall.endpoints_xy[1] - wall.endpoints_xy[0]
    unit = span / np.hypot(*span)
    start, end = np.sort(true_ends_xy @ unit)
    drawn_start, drawn_end = wall.endpoints_xy @ unit
    return np.array([start - drawn_start, drawn_end - end])

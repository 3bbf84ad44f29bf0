"""Assessment: whether a map can be trusted, from the map itself and the recording."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.diagnosis.causes import Remedy, find_remedies
from echoplan.diagnosis.consistency import consistency, sampled
from echoplan.diagnosis.stations import Misplaced, misplaced_stations
from echoplan.diagnosis.wording import next_step, reasons
from echoplan.geometry import compose, crosses_segments, invert
from echoplan.mapping.joint.settings import AccountSettings
from echoplan.model import Conventions, Corner, Cylinder, FeatureMap, Quality, Rig, Sweep, Verdict, Wall

__all__ = ["FEWEST_PLACES", "Measures", "assess", "examine", "verdict_of"]

# From fewer places nothing checks where a wall is.
FEWEST_PLACES = 3
# Places nearer than this hear the same [m]: that of the stations of joint.
_APART = 0.15
# Longer steps need not be straight [m].
_STEP = 0.5
# Where so many echoes fit together from the poses as recorded, joint does not question these.
_AGREE = AccountSettings().agreement
# Shares of explained echoes, and of those whose feature a second station detects, below which a map is doubtful, and
# has failed: on seeds 1000 on of benchmarks/verdicts.py.
_GOOD, _FAILED = 0.8, 0.6
_CONFIRMED, _LONE = 0.5, 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class Measures:
    """What a verdict is made of.

    Parameters
    ----------
    share : float
        Share of the echoes that the map explains.
    confirmed : float
        Share of the explained echoes whose feature a second station detects.
    places : int
        Places from which the room was sounded, counted up to ``FEWEST_PLACES``.
    features : int
        Walls, corners and cylinders of the map.
    crossed : int
        Walls that the path of the robot crosses.
    misplaced : tuple of Misplaced
        Stations that do not fit the others.
    remedies : tuple of Remedy
        Mistakes in how the recording is written that explain it.
    """

    share: float
    confirmed: float
    places: int
    features: int
    crossed: int = 0
    misplaced: tuple[Misplaced, ...] = ()
    remedies: tuple[Remedy, ...] = ()

    @property
    def is_unexplained(self) -> bool:
        """Whether too few echoes are explained for a good map."""
        return self.share < _GOOD

    @property
    def is_unconfirmed(self) -> bool:
        """Whether too few echoes are confirmed by a second station for a good map from several places."""
        return self.confirmed < _CONFIRMED and not self.is_from_few_places

    @property
    def is_from_few_places(self) -> bool:
        """Whether there were too few places for a good map."""
        return self.places < FEWEST_PLACES


def assess(
    feature_map: FeatureMap,
    rig: Rig,
    sweeps: Sequence[Sweep],
    *,
    conventions: Conventions | None = None,
    findings: Sequence[str] = (),
) -> Quality:
    """Assess a map: whether it can be trusted, and if not, why and what to do.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    rig : Rig
        What made the sweeps.
    sweeps : sequence of Sweep
        All sweeps of which the map was made.
    conventions : Conventions, optional
        How the recording was written, as ``rig.toml`` has it; SI and REP 103 by default.
    findings : sequence of str, optional
        What else is wrong with the recording, a sentence each, the most serious first; a map is doubtful at best then.

    Returns
    -------
    Quality
        The verdict, its reasons and the next step.

    Examples
    --------
    >>> from echoplan.io import builtin_rig
    >>> assess(FeatureMap(method="joint"), builtin_rig("ring-16"), ()).verdict.value
    'failed'
    """
    now = conventions or Conventions()
    measures = _measured(feature_map, rig, sweeps, now)
    verdict = verdict_of(measures)
    if verdict is Verdict.GOOD and not findings:
        return Quality(verdict=verdict)
    return Quality(
        verdict=Verdict.DOUBTFUL if verdict is Verdict.GOOD else verdict,
        reasons=reasons(measures, now, findings),
        next_step=next_step(measures, now, findings),
    )


def examine(
    rig: Rig, sweeps: Sequence[Sweep], *, conventions: Conventions | None = None, findings: Sequence[str] = ()
) -> Quality:
    """Examine a recording before anything is mapped, for mistakes that can be told from the recording alone.

    That few echoes fit together is none of them: poses of a robot that drives drift, and mapping corrects them.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    sweeps : sequence of Sweep
        All sweeps.
    conventions : Conventions, optional
        How the recording was written, as ``rig.toml`` has it; SI and REP 103 by default.
    findings : sequence of str, optional
        What else is wrong with the recording, a sentence each.

    Returns
    -------
    Quality
        ``good`` if nothing was found, ``failed`` if the recording is written in another way than it is read.
    """
    now = conventions or Conventions()
    share = consistency(sampled(sweeps, rig), rig).share
    remedies = find_remedies(sweeps, rig, conventions=now, share=share) if share < _AGREE else ()
    places = _places(np.array([sweep.station[:2] for sweep in sweeps if len(sweep)]).reshape(-1, 2))
    misplaced = () if remedies or places < FEWEST_PLACES else misplaced_stations(sweeps, rig)
    measures = Measures(share=1.0, confirmed=1.0, places=places, features=1, misplaced=misplaced, remedies=remedies)
    verdict, found = verdict_of(measures), reasons(measures, now, findings)
    if not found:
        return Quality(verdict=verdict)
    verdict = Verdict.DOUBTFUL if verdict is Verdict.GOOD else verdict
    return Quality(verdict=verdict, reasons=found, next_step=next_step(measures, now, findings))


def verdict_of(measures: Measures) -> Verdict:
    """Judge by numbers alone."""
    if not measures.features or not measures.share >= _FAILED or measures.remedies:
        return Verdict.FAILED
    if measures.is_unconfirmed and measures.confirmed < _LONE:
        return Verdict.FAILED
    if (
        measures.is_unexplained
        or measures.is_unconfirmed
        or measures.is_from_few_places
        or measures.crossed
        or measures.misplaced
    ):
        return Verdict.DOUBTFUL
    return Verdict.GOOD


def _measured(feature_map: FeatureMap, rig: Rig, sweeps: Sequence[Sweep], now: Conventions) -> Measures:
    features = len(feature_map.walls) + len(feature_map.corners) + len(feature_map.cylinders)
    placed = _placed(sweeps, feature_map)
    measures = Measures(
        share=_share(feature_map, rig, placed) if placed else 0.0,
        confirmed=_confirmed(feature_map),
        places=_places(feature_map.poses[:, :2]),
        features=features,
        crossed=_crossed_walls(feature_map),
    )
    if placed and verdict_of(measures) is not Verdict.GOOD:
        remedies = find_remedies(sweeps, rig, conventions=now, share=measures.share)
        measures = replace(measures, remedies=remedies)
    # Of a failed map most stations do not fit the others.
    if placed and verdict_of(measures) is not Verdict.FAILED:
        measures = replace(measures, misplaced=misplaced_stations(placed, rig))
    return measures


def _share(feature_map: FeatureMap, rig: Rig, placed: Sequence[Sweep]) -> float:
    """Take the share of explained echoes from joint, or explain those of some stations."""
    found = feature_map.parameters.get("found")
    if isinstance(found, Mapping) and "agreement" in found:
        return float(found["agreement"])
    return consistency(sampled(placed, rig), rig).share


def _confirmed(feature_map: FeatureMap) -> float:
    """Return the share of the pings of all features whose feature a second station detects; 1 without pings."""
    features: list[Wall | Corner | Cylinder] = [*feature_map.walls, *feature_map.corners, *feature_map.cylinders]
    pings = sum(each.pings for each in features)
    return sum(each.pings for each in features if each.stations > 1) / pings if pings else 1.0


def _placed(sweeps: Sequence[Sweep], feature_map: FeatureMap) -> list[Sweep]:
    """Put sweeps where the map has them."""
    poses = dict(zip(feature_map.sweeps.tolist(), feature_map.poses, strict=True))
    return [
        replace(sweep, map_from_base=compose(pose, compose(invert(sweep.station), sweep.map_from_base)))
        for sweep in sweeps
        if len(sweep) and (pose := poses.get(sweep.index)) is not None
    ]


def _places(stations_xy: FloatArray) -> int:
    """Count places that are apart from each other, up to those that are enough."""
    apart = np.zeros((0, 2))
    for place in stations_xy:
        if len(apart) < FEWEST_PLACES and np.hypot(*(apart - place).T).min(initial=np.inf) > _APART:
            apart = np.vstack([apart, place])
    return len(apart)


def _crossed_walls(feature_map: FeatureMap) -> int:
    """Count walls that short steps of the robot cross."""
    path = feature_map.poses[:, :2]
    if len(path) < 2 or not feature_map.walls:
        return 0
    is_short = np.hypot(*np.diff(path, axis=0).T) < _STEP
    walls = np.array([wall.endpoints_xy for wall in feature_map.walls])
    return int(crosses_segments(path[:-1][is_short], path[1:][is_short], walls).any(axis=0).sum())

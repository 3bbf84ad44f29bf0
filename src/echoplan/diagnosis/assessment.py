"""Assessment: whether a map can be trusted, from the map itself and the recording."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.diagnosis.calibration import servo_error
from echoplan.diagnosis.causes import Cause, Remedy, find_remedies
from echoplan.diagnosis.consistency import CONSISTENT, Consistency, consistency, sampled, stations_of, windows
from echoplan.diagnosis.stations import Misplaced, misplaced_stations
from echoplan.diagnosis.wording import next_step, reasons
from echoplan.geometry import crosses_segments
from echoplan.joint.settings import EstimateSettings
from echoplan.model import Conventions, Corner, Cylinder, FeatureMap, Quality, Rig, Sweep, Verdict, Wall
from echoplan.preprocessing import Faults, RecordingFaultKind, clean_sweeps, find_faults
from echoplan.preprocessing.placement import placed_sweeps, servo_of, servo_turned
from echoplan.preprocessing.servo import AS_RECORDED

__all__ = ["Measures", "assess", "examine", "verdict_of"]

# Length of a step up to which the path is taken as straight [m].
_STEP = 0.5
# Share of explained echoes below which `joint` always questions the recorded poses.
_AGREE = EstimateSettings().min_inlier_ratio
# Number of windows of a long recording over which the share is averaged: each takes as long as mapping it.
_WINDOWS = 5
# Thresholds below which a map is doubtful or failed: share of explained echoes, and share of echoes that are explained
# by landmarks which at least two stations detect. Chosen on seeds from 1000 of benchmarks/verdicts.py.
_GOOD, _FAILED = 0.8, 0.6
_CONFIRMED, _LONE = 0.7, 0.25
# Number of sensors from which a good map may leave all echoes of one of them unexplained: 1 / (1 - _GOOD).
_MANY_SENSORS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Measures:
    """Measures from which a verdict follows.

    Parameters
    ----------
    share : float
        Share of the echoes that the map explains.
    confirmed : float
        Share of the echoes that are explained by landmarks which at least two stations detect: ``share`` times the
        share of the pings of the map that belong to such landmarks.
    features : int
        Number of walls, corners and cylinders of the map.
    faults : Faults, optional
        Faults of the recording and of its readings.
    crossed : int, optional
        Number of walls that the path of the robot crosses.
    misplaced : tuple of Misplaced, optional
        Stations that are inconsistent with the others.
    remedies : tuple of Remedy, optional
        Wrong conventions or sensor directions that explain the symptoms.
    odd_sensor : int, optional
        Sensor whose echoes fit together less than half as often as those of the others.
    unchecked : str, optional
        Name of the method if it does not report how many echoes its map explains. Then ``share`` is what a model of
        one room explains from the poses of the map.
    """

    share: float
    confirmed: float
    features: int
    faults: Faults = field(default_factory=Faults)
    crossed: int = 0
    misplaced: tuple[Misplaced, ...] = ()
    remedies: tuple[Remedy, ...] = ()
    odd_sensor: int | None = None
    unchecked: str = ""

    @property
    def is_unexplained(self) -> bool:
        """Whether too few echoes are explained for a good map."""
        return self.share < _GOOD

    @property
    def is_unconfirmed(self) -> bool:
        """Whether too few echoes are explained by what at least two stations detect; False without three places.

        With wrong poses each station gets landmarks of its own, which explain most of its echoes.
        """
        return self.confirmed < _CONFIRMED and not self.faults.recording


def assess(
    feature_map: FeatureMap,
    rig: Rig,
    sweeps: Sequence[Sweep],
    *,
    conventions: Conventions | None = None,
    has_rig_file: bool = True,
) -> Quality:
    """Return the quality of a map: verdict, reasons and next step.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    rig : Rig
        Sensors that recorded the sweeps.
    sweeps : sequence of Sweep
        All sweeps of the recording, as recorded.
    conventions : Conventions, optional
        Conventions of the recording, as in ``rig.toml``; SI and REP 103 by default.
    has_rig_file : bool, optional
        Whether the recording has a ``rig.toml`` that the next step may name; a bag has none.

    Returns
    -------
    Quality
        Verdict, reasons and next step. The map of a recording with faults is doubtful at best.

    Examples
    --------
    >>> from echoplan.io import builtin_rig
    >>> assess(FeatureMap(method="joint"), builtin_rig("ring-16"), ()).verdict.value
    'failed'
    """
    now = conventions or Conventions()
    return _quality(_measured(feature_map, rig, sweeps, now), now, has_rig_file=has_rig_file)


def examine(
    rig: Rig, sweeps: Sequence[Sweep], *, conventions: Conventions | None = None, has_rig_file: bool = True
) -> Quality:
    """Check a recording before mapping for faults and wrong conventions.

    That few echoes are consistent is no fault: odometry drifts, and mapping corrects it.

    Parameters
    ----------
    rig : Rig
        Sensors that recorded the sweeps.
    sweeps : sequence of Sweep
        All sweeps, as recorded.
    conventions : Conventions, optional
        Conventions of the recording, as in ``rig.toml``; SI and REP 103 by default.
    has_rig_file : bool, optional
        Whether the recording has a ``rig.toml`` that the next step may name; a bag has none.

    Returns
    -------
    Quality
        ``good`` if nothing was found, ``failed`` if the recording does not follow the conventions, ``doubtful`` for
        faults and misplaced stations.
    """
    now, faults = conventions or Conventions(), find_faults(sweeps, rig)
    measures = Measures(share=1.0, confirmed=1.0, features=1, faults=faults)
    # With unknown poses or an unsuitable beam, no conventions explain the echoes.
    if any(map(len, sweeps)) and not faults.recording:
        cleaned = clean_sweeps(sweeps, rig, faults)
        error = servo_error(cleaned, rig)
        turned = servo_turned(cleaned, error)
        # What looks like a servo error may be another mistake.
        is_consistent = consistency(sampled(turned, rig), rig).share >= _AGREE
        is_strange = error != AS_RECORDED or not is_consistent
        causes = _causes_to_test(_of_sensors(turned, rig), is_strange=is_strange)
        remedies = find_remedies(cleaned, rig, conventions=now, causes=causes)
        misplaced = () if remedies else misplaced_stations(turned, rig)
        measures = replace(measures, misplaced=misplaced, remedies=remedies)
    return _quality(measures, now, has_rig_file=has_rig_file)


def _quality(measures: Measures, now: Conventions, *, has_rig_file: bool) -> Quality:
    verdict, why = verdict_of(measures), reasons(measures, now)
    step = next_step(measures, now, has_rig_file=has_rig_file) if why else ""
    return Quality(verdict=verdict, reasons=why, next_step=step)


def verdict_of(measures: Measures) -> Verdict:
    """Return the verdict that follows from measures.

    Parameters
    ----------
    measures : Measures
        Measures of the map and its recording.

    Returns
    -------
    Verdict
        Failed, doubtful or good.
    """
    if not measures.features or not measures.share >= _FAILED or measures.remedies:
        return Verdict.FAILED
    if measures.is_unconfirmed and measures.confirmed < _LONE:
        return Verdict.FAILED
    symptoms = (measures.is_unexplained, measures.is_unconfirmed, measures.crossed, measures.misplaced)
    others = (measures.odd_sensor is not None, measures.faults != Faults(), measures.unchecked)
    return Verdict.DOUBTFUL if any((*symptoms, *others)) else Verdict.GOOD


def _measured(feature_map: FeatureMap, rig: Rig, sweeps: Sequence[Sweep], now: Conventions) -> Measures:
    faults = find_faults(sweeps, rig)
    cleaned = clean_sweeps(sweeps, rig, faults)
    placed = placed_sweeps(cleaned, feature_map)
    ratio = _inlier_ratio(feature_map)
    share = _share(ratio, rig, placed, faults) if placed else 0.0
    measures = Measures(
        share=share,
        confirmed=share * _confirmed(feature_map),
        features=len(feature_map.walls) + len(feature_map.corners) + len(feature_map.cylinders),
        faults=faults,
        crossed=_crossed_walls(feature_map),
        unchecked=feature_map.method if ratio is None else "",
    )
    # With unknown poses or an unsuitable beam, no conventions explain the echoes.
    if not placed or faults.recording:
        return measures
    sensors = _of_sensors(placed, rig)
    odd_sensor = rig.sensors[sensors.strangest].sensor_id if sensors.has_odd_sensor else None
    measures = replace(measures, odd_sensor=odd_sensor)
    is_strange = verdict_of(replace(measures, faults=Faults(), unchecked="")) is not Verdict.GOOD
    # What looks like a servo error may be another mistake.
    causes = _causes_to_test(sensors, is_strange=is_strange or servo_of(feature_map) != AS_RECORDED)
    measures = replace(measures, remedies=find_remedies(cleaned, rig, conventions=now, causes=causes))
    # In a failed map most stations are inconsistent, so none is singled out.
    if verdict_of(measures) is not Verdict.FAILED:
        measures = replace(measures, misplaced=misplaced_stations(placed, rig))
    return measures


def _causes_to_test(sensors: Consistency, *, is_strange: bool) -> tuple[Cause, ...]:
    """Return the mistakes to test; without symptoms, the echoes of one of many sensors may still be unexplained."""
    if is_strange:
        return tuple(Cause)
    return (Cause.SENSOR,) if sensors.has_unexplained_sensor else ()


def _inlier_ratio(feature_map: FeatureMap) -> float | None:
    """Return the share of echoes that the map explains; None if the method does not report it."""
    found = feature_map.parameters.get("found")
    ratio = found.get("inlier_ratio") if isinstance(found, Mapping) else None
    return None if ratio is None else float(ratio)


def _of_sensors(sweeps: Sequence[Sweep], rig: Rig) -> Consistency:
    """Return the consistency by sensor for rigs of many sensors; in rigs of few, the total share shows a bad one."""
    if len(rig.sensors) < _MANY_SENSORS:
        return CONSISTENT
    return consistency(sampled(sweeps, rig, stations=EstimateSettings().window.stations), rig)


def _share(ratio: float | None, rig: Rig, placed: Sequence[Sweep], faults: Faults) -> float:
    """Return the share of explained echoes.

    It is that which the method reports, or else that of a model of one room from the poses of the map.
    """
    window = EstimateSettings().window
    # For a longer recording, `joint` reports the share of the last window only.
    if ratio is not None and len(stations_of(placed).poses) <= window.stations + window.stride:
        return ratio
    # The sonar model does not apply to lidar readings.
    if any(fault.kind is RecordingFaultKind.NARROW_BEAM for fault in faults.recording):
        return 1.0 if ratio is None else ratio
    # All stations of a window are used: fewer ones would share fewer landmarks.
    parts = (sampled(part, rig, stations=window.stations) for part in windows(placed, most=_WINDOWS))
    return float(np.mean([consistency(part, rig).share for part in parts]))


def _confirmed(feature_map: FeatureMap) -> float:
    """Return the share of pings whose landmark a second station detects; 1 without pings.

    Landmarks of unknown stations, such as those from cells of a grid, do not count.
    """
    features: list[Wall | Corner | Cylinder] = [*feature_map.walls, *feature_map.corners, *feature_map.cylinders]
    pings = sum(each.pings for each in features if each.stations)
    return sum(each.pings for each in features if each.stations > 1) / pings if pings else 1.0


def _crossed_walls(feature_map: FeatureMap) -> int:
    """Count the walls that short steps of the robot cross."""
    path = feature_map.poses[:, :2]
    if len(path) < 2 or not feature_map.walls:
        return 0
    is_short = np.hypot(*np.diff(path, axis=0).T) < _STEP
    walls = np.array([wall.endpoints_xy for wall in feature_map.walls])
    return int(crosses_segments(path[:-1][is_short], path[1:][is_short], walls).any(axis=0).sum())

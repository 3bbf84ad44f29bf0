"""What the server sends to a page: topics as JSON; a message replaces the one before it of the same topic."""

import json
from collections.abc import Mapping, Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.diagnosis import faults_in_words
from echoplan.geometry import directions
from echoplan.live.feed import Feed
from echoplan.live.survey import Survey
from echoplan.model import Pings, Quality, Rig, Sweep
from echoplan.preprocessing import Faults, is_valid
from echoplan.viewer.plan import station_labels
from echoplan.viewer.quality import headline

__all__ = [
    "encoded",
    "faults_message",
    "hello_message",
    "shares_message",
    "stations_message",
    "sweep_message",
    "verdict_message",
]

_MILLIMETRES = 1000.0


def encoded(topic: str, content: Mapping[str, object]) -> str:
    """Write a message of one topic."""
    return json.dumps({"topic": topic, **content}, separators=(",", ":"), allow_nan=False)


def hello_message(feed: Feed, *, folder: str) -> dict[str, object]:
    """Introduce a source to a page: its name, its sensors and what may be asked of it."""
    return {
        "name": feed.name,
        "rig": feed.rig.name,
        "reach": float(feed.rig.max_ranges.max()),
        "sensors": [{"id": each.sensor_id, "aperture": round(each.half_aperture, 4)} for each in feed.rig.sensors],
        "controls": sorted(feed.controls),
        "folder": folder,
    }


def sweep_message(sweep: Sweep, rig: Rig) -> dict[str, object]:
    """Return where the echoes of a sweep would lie if sound were a ray [mm], and the bearings of the sensors [rad]."""
    pings = Pings.from_sweep(sweep, rig)
    valid = is_valid(pings, rig)
    ends = pings.origins_xy + np.where(valid, pings.ranges, 0.0)[:, None] * directions(pings.bearings)
    places = np.round(_MILLIMETRES * ends).astype(np.int64)
    last = dict(zip(pings.sensors.tolist(), pings.bearings.tolist(), strict=True))
    return {
        "number": sweep.index,
        "pose": _rounded(sweep.map_from_base[-1]),
        "hub": _rounded(pings.hubs_xy[-1]),
        "sensors": pings.sensors[valid].tolist(),
        "x": places[valid, 0].tolist(),
        "y": places[valid, 1].tolist(),
        "pings": len(sweep),
        "bearings": [[sensor, round(bearing, 3)] for sensor, bearing in last.items()],
    }


def shares_message(sweeps: Sequence[Sweep], rig: Rig) -> list[dict[str, object]]:
    """Return how many pings of each sensor are in these sweeps, and which share of them has a valid reading."""
    pings, valid = np.zeros((2, len(rig.sensors)), dtype=np.int64)
    for sweep in sweeps:
        placed = Pings.from_sweep(sweep, rig)
        pings += np.bincount(placed.sensors, minlength=len(pings))
        valid += np.bincount(placed.sensors[is_valid(placed, rig)], minlength=len(pings))
    shares = np.round(valid / np.maximum(pings, 1), 3)
    return [
        {"id": sensor.sensor_id, "pings": count, "share": share}
        for sensor, count, share in zip(rig.sensors, pings.tolist(), shares.tolist(), strict=True)
    ]


def faults_message(faults: Faults) -> dict[str, object]:
    """Return which sensors have a fault, and the sentences about it."""
    return {"sensors": [each.sensor_id for each in faults.sensors], "sentences": faults_in_words(faults)}


def stations_message(survey: Survey) -> dict[str, object]:
    """Return where the stations were placed, and the sweeps of each."""
    poses, numbers = survey.station_poses, survey.stations
    labels = station_labels(np.arange(len(poses)), poses[:, :2])
    counts = np.bincount(numbers, minlength=len(poses)).tolist()
    firsts = [survey.sweeps[place].index for place in np.unique(numbers, return_index=True)[1]]
    return {
        "pings": sum(each.pings for each in survey.sweeps),
        "stations": [
            {"pose": _rounded(pose), "label": label, "sweeps": count, "first": first}
            for pose, label, count, first in zip(poses, labels, counts, firsts, strict=True)
        ],
    }


def verdict_message(quality: Quality | None, *, sweeps: int) -> dict[str, object]:
    """Return the verdict on the map of so many sweeps, empty without one."""
    if quality is None:
        return {"sweeps": sweeps, "verdict": "", "headline": "", "reasons": []}
    return {
        "sweeps": sweeps,
        "verdict": str(quality.verdict),
        "headline": headline(quality),
        "reasons": list(quality.reasons),
    }


def _rounded(numbers: FloatArray) -> list[float]:
    rounded: list[float] = np.round(numbers, 4).tolist()
    return rounded

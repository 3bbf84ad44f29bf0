"""Sweeps where a map has them: at its poses, with the servo that it found."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from echoplan.geometry import compose, invert
from echoplan.model import FeatureMap, Sweep
from echoplan.preprocessing.servo import AS_RECORDED, ServoError

__all__ = ["placed_sweeps", "servo_of", "servo_turned"]


def placed_sweeps(sweeps: Sequence[Sweep], feature_map: FeatureMap) -> list[Sweep]:
    """Move sweeps to their poses in a map, and turn their servo by the gain and offset that the map states.

    Parameters
    ----------
    sweeps : sequence of Sweep
        Sweeps as recorded.
    feature_map : FeatureMap
        A map of them.

    Returns
    -------
    list of Sweep
        Those with pings and a pose in the map; each moves as a rigid body, so that motion within it is kept.
    """
    poses = dict(zip(feature_map.sweeps.tolist(), feature_map.poses, strict=True))
    return [
        replace(sweep, map_from_base=compose(pose, compose(invert(sweep.station), sweep.map_from_base)))
        for sweep in servo_turned(sweeps, servo_of(feature_map))
        if len(sweep) and (pose := poses.get(sweep.index)) is not None
    ]


def servo_of(feature_map: FeatureMap) -> ServoError:
    """Return the gain and offset of the servo as the map reports them; those as recorded if it does not."""
    found = feature_map.parameters.get("found")
    if not isinstance(found, Mapping) or "servo_gain" not in found:
        return AS_RECORDED
    return ServoError(gain=float(found["servo_gain"]["value"]), offset=float(found["servo_offset"]["value"]))


def servo_turned(sweeps: Sequence[Sweep], error: ServoError) -> list[Sweep]:
    """Return the sweeps with servo angles corrected by gain and offset."""
    if error == AS_RECORDED:
        return list(sweeps)
    return [replace(each, servo_angles=error.gain * each.servo_angles + error.offset) for each in sweeps]

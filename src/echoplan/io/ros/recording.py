"""Bags of ROS 1 and ROS 2 as sources of sweeps: no rig file is needed."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from echoplan.errors import InputError
from echoplan.io.files import by_name
from echoplan.io.ros.contents import BagContents, read_contents
from echoplan.io.ros.mounting import Mounting, mountings_of, names_of
from echoplan.io.ros.options import BagOptions
from echoplan.io.ros.readings import Readings, notes_about_infrared, notes_about_ranges, ranges_of, sonar_readings
from echoplan.io.ros.sensors import sensor_of
from echoplan.io.ros.series import SeriesKey
from echoplan.io.ros.sweeps import PingColumns, split_into_sweeps
from echoplan.io.ros.trajectory import Trajectory, poses_at, trajectory_of
from echoplan.io.units import WIDEST
from echoplan.model import Recording, Rig

__all__ = ["read_bag", "recording_of"]


@by_name
def read_bag(path: Path, options: BagOptions | None = None) -> Recording:
    """Read a bag of ROS 1 or ROS 2: ranges, mounting and poses.

    Parameters
    ----------
    path : Path or str
        A file (.bag, .mcap, .db3) or the folder of a ROS 2 bag.
    options : BagOptions, optional
        Which topics and fields to read; by default they are found by their types.

    Returns
    -------
    Recording
        The sweeps, the rig, and notes about how they were read.

    Raises
    ------
    InputError
        If the bag cannot be read, or something is missing for a map.
    MissingExtraError
        If rosbags is not installed.
    """
    return recording_of(read_contents(path, options or BagOptions()))


def recording_of(read: BagContents) -> Recording:
    """Make sweeps from the content of a bag.

    Raises ``InputError`` if ranges, a mounting or the poses of the robot are missing.
    """
    path = read.path
    readings = sonar_readings(read)
    trajectory = trajectory_of(read)
    mounted = mountings_of(read, readings, base=trajectory.base)
    mountings = {key: mounting for key, mounting in mounted.items() if mounting.is_level}
    turret = _common_turret(mountings, path=path)
    pings, lost = _pings(read, mountings, readings=readings, trajectory=trajectory)
    sensors = tuple(
        sensor_of(read, key, series=readings[key], mounting=mounting, sensor_id=number)
        for number, (key, mounting) in enumerate(mountings.items())
    )
    notes = [*read.notes, *notes_about_infrared(read)]
    notes += [
        f"The mounting of the sensor on {key.topic} is unknown; the middle of the robot is assumed: state "
        f"it with --mount {key.topic.strip('/')}=X,Y,YAW."
        for key, mounting in mountings.items()
        if mounting.is_assumed
    ]
    notes += [
        f"{key.frame} points at the floor or the ceiling and is left out. To keep it, state its mounting: "
        f"--mount {names_of(key)[0]}=X,Y,YAW [m, m, rad]."
        for key in mounted
        if key not in mountings
    ]
    if lost:
        total = lost + len(pings)
        notes.append(f"{lost} of {total} readings are left out: their pose or servo angle is unknown.")
    notes += notes_about_ranges({key: readings[key] for key in mountings}, read.options)
    return Recording(
        # Python decodes names that are not UTF-8 to lone surrogates, which cannot be encoded in any file.
        name=path.resolve().name.encode(errors="replace").decode(),
        rig=Rig(name=f"sensors in {path.name}", sensors=sensors, base_from_turret=turret.base_from_turret),
        sweeps=split_into_sweeps(pings),
        notes=tuple(notes),
    )


def _common_turret(mountings: Mapping[SeriesKey, Mounting], *, path: Path) -> Mounting:
    """Return a mounting with the joint that turns all sensors; refuse sensors that do not turn together."""
    if not mountings:
        remedy = "check the mounting of the sensors in /tf_static, or state it: --mount FRAME=X,Y,YAW [m, m, rad]"
        raise InputError(path, "all sensors point at the floor or the ceiling", remedy=remedy)
    joints = {mounting.joint: key.topic for key, mounting in mountings.items()}
    if len(joints) > 1:
        states = (f"{topic} {f'turns with {joint}' if joint else 'is fixed'}" for joint, topic in joints.items())
        remedy = "name those to map together with --topic"
        raise InputError(path, f"not all sensors turn together: {', '.join(states)}", remedy=remedy)
    return next(iter(mountings.values()))


def _pings(
    read: BagContents, mountings: Mapping[SeriesKey, Mounting], *, readings: Readings, trajectory: Trajectory
) -> tuple[PingColumns, int]:
    """Gather the pings of all sensors whose pose and servo angle are known, and count the others."""
    parts, whether = [], []
    for number, (key, mounting) in enumerate(mountings.items()):
        series = readings[key]
        poses, on_way = poses_at(trajectory, read, stamps_ns=series.stamps_ns)
        whether.append(on_way & mounting.known)
        parts.append(
            PingColumns(
                stamps_ns=series.stamps_ns,
                sensor_ids=np.full(len(series), number),
                servo_angles=mounting.servo_angles,
                ranges=ranges_of(series, read.options),
                map_from_base=poses,
            )
        )
    names = ("stamps_ns", "sensor_ids", "servo_angles", "ranges", "map_from_base")
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    known = np.concatenate(whether)
    pings = PingColumns(**joined)[known]
    if not known.any():
        problem = "the pose of the robot is unknown at the time of every reading"
        raise InputError(read.path, problem, remedy=f"record the readings and {trajectory.origin} at the same time")
    way = np.ptp(pings.map_from_base[:, :2], axis=0).max()
    if way > WIDEST:
        problem = f"the poses lie up to {way:.3g} m apart, and echoplan maps at most {WIDEST:g} m"
        raise InputError(read.path, problem, place=trajectory.origin, remedy="cut the bag where the position jumps")
    return pings, len(known) - len(pings)

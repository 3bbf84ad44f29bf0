"""A rig: sensors on a turret, how a servo turns it and in which order the sensors fire."""

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, IntArray, checked_floats, checked_number, store
from echoplan.errors import InvalidValueError, UnknownNameError
from echoplan.geometry import compose, identity
from echoplan.model.odometry import Odometry
from echoplan.model.sensor import Sensor, Transducer

__all__ = ["Firing", "Rig", "Servo"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """The turn of the turret in one sweep.

    Parameters
    ----------
    start, stop : float
        First and last angle [rad]; sweeps run to and fro between them.
    step : float
        Turn between two firing rounds [rad], positive.

    Raises
    ------
    InvalidValueError
        If the step is not positive or the angles are not in order.
    """

    start: float
    stop: float
    step: float

    def __post_init__(self) -> None:
        checked_number(self.start, name="start")
        checked_number(self.stop, name="stop", above=self.start)
        checked_number(self.step, name="step", above=0.0)

    @property
    def angles(self) -> FloatArray:
        """Angles of one forward sweep [rad], shape (n,); the last step may end just short of ``stop``."""
        count = int(np.floor((self.stop - self.start) / self.step + 1e-6)) + 1
        angles: FloatArray = self.start + self.step * np.arange(count, dtype=np.float64)
        return angles


@dataclass(frozen=True, slots=True, kw_only=True)
class Firing:
    """Which sensors fire together, and how soon the next ones follow.

    Parameters
    ----------
    period : float
        Time from one group's firing to the next [s].
    groups : tuple of tuple of int
        Sensor ids fired together, group after group; all groups make one round.

    Raises
    ------
    InvalidValueError
        If the period is not positive or a group is empty.
    """

    period: float
    groups: tuple[tuple[int, ...], ...]

    def __post_init__(self) -> None:
        checked_number(self.period, name="period", above=0.0)
        if not self.groups or not all(self.groups):
            raise InvalidValueError(f"groups must name the sensors fired together, not {self.groups}")

    @property
    def sensor_ids(self) -> set[int]:
        """Ids of all sensors that are fired."""
        return {sensor_id for group in self.groups for sensor_id in group}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Rig:
    """All that is known of the array that made a recording.

    Parameters
    ----------
    name : str
        What people call it.
    sensors : tuple of Sensor
        The sensors, each with an id of its own.
    base_from_turret : ndarray, shape (3,), optional
        Pose of the servo's axis in ``base_link`` [m, m, rad].
    servo : Servo, optional
        How the turret turns; None for fixed sensors.
    firing : Firing, optional
        Order of firing; None if the recording does not say.
    transducer : Transducer, optional
        What the simulator needs; None if the recording does not say.
    odometry : Odometry, optional
        How far dead reckoning may be off; None if the recording does not say.
    speed_of_sound : float, optional
        With which the modules turn time into range [m/s]; None if the recording does not say.
    rays : bool, optional
        Whether a reading is the nearest point in a cone of rays, as robot simulators have it, and no sound at all; None
        if the recording does not say.

    Raises
    ------
    InvalidValueError
        If there is no sensor, an id occurs twice, a firing group names a sensor that is not there, or sound never
        travels so fast in air.
    """

    name: str
    sensors: tuple[Sensor, ...]
    base_from_turret: FloatArray = field(default_factory=identity)
    servo: Servo | None = None
    firing: Firing | None = None
    transducer: Transducer | None = None
    odometry: Odometry | None = None
    speed_of_sound: float | None = None
    rays: bool | None = None

    def __post_init__(self) -> None:
        if self.speed_of_sound is not None:
            checked_number(self.speed_of_sound, name="speed_of_sound", minimum=300.0, maximum=370.0)
        ids = Counter(sensor.sensor_id for sensor in self.sensors)
        if not ids:
            raise InvalidValueError("a rig must have at least one sensor")
        repeated, count = ids.most_common(1)[0]
        if count > 1:
            raise InvalidValueError(f"sensor id {repeated} occurs {count} times; every sensor needs its own")
        strange = self.firing.sensor_ids - set(ids) if self.firing else set()
        if strange:
            raise InvalidValueError(f"groups name sensor {min(strange)}, but the sensors are {sorted(ids)}")
        store(self, base_from_turret=checked_floats(self.base_from_turret, name="turret", shape=(3,)))

    @property
    def sensor_ids(self) -> IntArray:
        """Ids of the sensors in their order, shape (s,)."""
        return np.array([sensor.sensor_id for sensor in self.sensors], dtype=np.int64)

    @property
    def turret_from_sensors(self) -> FloatArray:
        """Poses of the acoustic centres in the turret's frame [m, m, rad], shape (s, 3)."""
        return np.array([[sensor.x, sensor.y, sensor.yaw] for sensor in self.sensors])

    @property
    def min_ranges(self) -> FloatArray:
        """Dead distances [m], shape (s,)."""
        return np.array([sensor.min_range for sensor in self.sensors])

    @property
    def max_ranges(self) -> FloatArray:
        """Reaches [m], shape (s,)."""
        return np.array([sensor.max_range for sensor in self.sensors])

    def indices(self, sensor_ids: ArrayLike) -> IntArray:
        """Positions of sensors in ``sensors``.

        Parameters
        ----------
        sensor_ids : array_like of int, shape (n,)
            Ids as recorded.

        Returns
        -------
        ndarray of int64, shape (n,)
            Index into ``sensors`` of each.

        Raises
        ------
        UnknownNameError
            If an id is not of this rig.
        """
        wanted = np.asarray(sensor_ids, dtype=np.int64)
        known = self.sensor_ids
        order = np.argsort(known)
        found: IntArray = order[np.searchsorted(known, wanted, sorter=order).clip(max=len(known) - 1)]
        strange = wanted[known[found] != wanted]
        if strange.size:
            raise UnknownNameError("sensor id", str(strange[0]), known=map(str, known))
        return found

    def base_from_sensors(self, sensor_ids: ArrayLike, servo_angles: ArrayLike) -> FloatArray:
        """Poses of acoustic centres and beam axes in ``base_link``.

        Parameters
        ----------
        sensor_ids : array_like of int, shape (n,)
            Which sensor.
        servo_angles : array_like, shape (n,)
            Turn of the servo [rad].

        Returns
        -------
        ndarray of float64, shape (n, 3)
            ``(x, y, yaw)`` [m, m, rad]; yaw is the direction of the beam axis.

        Raises
        ------
        UnknownNameError
            If an id is not of this rig.
        """
        turns = np.asarray(servo_angles, dtype=np.float64)
        turned = np.stack([np.zeros_like(turns), np.zeros_like(turns), turns], axis=-1)
        in_turret = compose(turned, self.turret_from_sensors[self.indices(sensor_ids)])
        return compose(self.base_from_turret, in_turret)

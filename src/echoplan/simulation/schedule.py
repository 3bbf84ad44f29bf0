"""When each sensor fires, where it is then and how it moves: a rig on its route, ping by ping."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InvalidValueError
from echoplan.geometry import compose, wrap
from echoplan.model import Firing, Rig, Route

__all__ = ["Schedule", "build_schedule", "default_firing"]

# Without a stated order all sensors fire at once, as often as the paper's array does.
_PERIOD = 0.025
# Time between two stations, on the way between which nothing is recorded.
_WAY_NS = 1_000_000_000
# Three and a half hours of the paper's array; each ping takes 350 bytes of memory.
_MOST_PINGS = 2_000_000
# Over which the motion of a sensor is taken from its poses.
_MOMENT_NS = 1_000_000


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Schedule:
    """All pings of a simulation in the order of time, as they truly happen.

    Parameters
    ----------
    stamps_ns : ndarray of int, shape (n,)
        Time of each ping [ns].
    sensors : ndarray of int, shape (n,)
        Index of the sensor in the rig.
    servo_angles : ndarray, shape (n,)
        Commanded angle of the servo [rad].
    map_from_base : ndarray, shape (n, 3)
        True pose of the robot [m, m, rad].
    map_from_sensors : ndarray, shape (n, 3)
        True pose of the acoustic centre, with the servo where it is [m, m, rad].
    velocities : ndarray, shape (n, 3)
        Rate of the latter [m/s, m/s, rad/s].
    bounds : ndarray of int, shape (s + 1,)
        Pings of sweep i are ``bounds[i]`` to ``bounds[i + 1]``.
    """

    stamps_ns: IntArray
    sensors: IntArray
    servo_angles: FloatArray
    map_from_base: FloatArray
    map_from_sensors: FloatArray
    velocities: FloatArray
    bounds: IntArray

    @property
    def stations(self) -> IntArray:
        """Index of the ping halfway through each sweep, shape (s,)."""
        return (self.bounds[:-1] + self.bounds[1:]) // 2


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Rounds:
    # One entry a firing round: when it begins, the commanded angle of the servo, the sweep.
    stamps_ns: IntArray
    angles: FloatArray
    sweeps: IntArray


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Motion:
    rig: Rig
    route: Route
    rounds: _Rounds
    latency_ns: int
    gain: float
    offset: float

    def servo_angles(self, stamps_ns: IntArray) -> FloatArray:
        """Commanded angles of the servo [rad], between the rounds by linear interpolation."""
        angles: FloatArray = np.interp(stamps_ns, self.rounds.stamps_ns, self.rounds.angles)
        return angles

    def map_from_base(self, stamps_ns: IntArray, sweeps: IntArray) -> FloatArray:
        """Poses of the robot [m, m, rad]: those of the sweeps, or between the moments of a route that has stamps."""
        poses = self.route.map_from_base
        if self.route.stamps_ns is None:
            return poses[sweeps]
        poses = np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])])
        moments = stamps_ns - self.route.stamps_ns[0]
        knots = self.route.stamps_ns - self.route.stamps_ns[0]
        return np.stack([np.interp(moments, knots, column) for column in poses.T], axis=-1)

    def map_from_sensors(self, stamps_ns: IntArray, sweeps: IntArray, sensors: IntArray) -> FloatArray:
        """Poses of the sensors [m, m, rad], by their indices in the rig, with the errors of the servo."""
        angles = self.offset + self.gain * self.servo_angles(stamps_ns - self.latency_ns)
        in_base = self.rig.base_from_sensors(self.rig.sensor_ids[sensors], angles)
        return compose(self.map_from_base(stamps_ns, sweeps), in_base)


def default_firing(rig: Rig) -> Firing:
    """Order of firing of a rig that does not state one: all sensors at once, every 25 ms.

    Parameters
    ----------
    rig : Rig
        The rig.

    Returns
    -------
    Firing
        What the rig says, or else the default.
    """
    return rig.firing or Firing(period=_PERIOD, groups=(tuple(rig.sensor_ids.tolist()),))


def build_schedule(
    rig: Rig, route: Route, *, servo_latency: float = 0.0, servo_gain: float = 1.0, servo_offset: float = 0.0
) -> Schedule:
    """Lay out every ping of a rig on its route.

    At a station the servo turns once, to and fro at alternate stations; on a stamped route it keeps turning to and
    fro until the route ends.  Each pass is a sweep; without a servo each firing round is one.  The servo turns
    evenly from the angle of one round to that of the next.

    Parameters
    ----------
    rig : Rig
        What fires.
    route : Route
        Where it goes.
    servo_latency : float, optional
        How long the servo lags behind its commanded angle [s].
    servo_gain : float, optional
        How far the servo turns for each radian that is recorded [rad].
    servo_offset : float, optional
        Where the servo stands when it records 0 [rad].

    Returns
    -------
    Schedule
        All pings.

    Raises
    ------
    InvalidValueError
        If there are more than two million pings.

    Examples
    --------
    >>> from echoplan.model import Sensor, Servo
    >>> sensor = Sensor(sensor_id=7, half_aperture=0.3, min_range=0.03, max_range=3.0, resolution=0.005)
    >>> rig = Rig(name="one", sensors=(sensor,), servo=Servo(start=0.0, stop=0.2, step=0.1))
    >>> schedule = build_schedule(rig, Route(map_from_base=[[0, 0, 0], [1, 0, 0]]))
    >>> schedule.servo_angles
    array([0. , 0.1, 0.2, 0.2, 0.1, 0. ])
    """
    firing = default_firing(rig)
    rounds = _lay_out_rounds(rig, route, firing)
    offsets_ns = np.concatenate(
        [np.full(len(group), number * _to_ns(firing.period)) for number, group in enumerate(firing.groups)]
    )
    fired = rig.indices(np.concatenate([np.array(group) for group in firing.groups]))
    stamps_ns = np.add.outer(rounds.stamps_ns, offsets_ns).ravel()
    sensors = np.tile(fired, len(rounds.stamps_ns))
    sweeps = np.repeat(rounds.sweeps, len(fired))
    motion = _Motion(
        rig=rig,
        route=route,
        rounds=rounds,
        latency_ns=_to_ns(servo_latency),
        gain=servo_gain,
        offset=servo_offset if rig.servo else 0.0,
    )
    poses = motion.map_from_sensors(stamps_ns, sweeps, sensors)
    later = motion.map_from_sensors(stamps_ns + _MOMENT_NS, sweeps, sensors)
    moved = np.column_stack([later[:, :2] - poses[:, :2], wrap(later[:, 2] - poses[:, 2])])
    return Schedule(
        stamps_ns=stamps_ns,
        sensors=sensors,
        servo_angles=motion.servo_angles(stamps_ns),
        map_from_base=motion.map_from_base(stamps_ns, sweeps),
        map_from_sensors=poses,
        velocities=moved / (_MOMENT_NS * 1e-9),
        bounds=np.searchsorted(sweeps, np.arange(sweeps[-1] + 2)),
    )


def _lay_out_rounds(rig: Rig, route: Route, firing: Firing) -> _Rounds:
    forward = rig.servo.angles if rig.servo else np.zeros(1)
    duration_ns = _to_ns(firing.period) * len(firing.groups)
    if route.stamps_ns is None:
        count = len(forward) * len(route.map_from_base)
        begin_ns, pause_ns = 0, _WAY_NS
    else:
        count = int((route.stamps_ns[-1] - route.stamps_ns[0]) // duration_ns) + 1
        begin_ns, pause_ns = int(route.stamps_ns[0]), 0
    pings = count * sum(map(len, firing.groups))
    if pings > _MOST_PINGS:
        raise InvalidValueError(
            f"the route must take at most {_MOST_PINGS} pings, not {pings}; shorten it, or let the rig fire less often"
        )
    numbers = np.arange(count)
    sweeps, steps = numbers // len(forward), numbers % len(forward)
    angles = np.where(sweeps % 2 == 0, forward[steps], forward[::-1][steps])
    return _Rounds(stamps_ns=begin_ns + numbers * duration_ns + sweeps * pause_ns, angles=angles, sweeps=sweeps)


def _to_ns(seconds: float) -> int:
    return round(seconds * 1e9)

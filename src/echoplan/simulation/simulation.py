"""The simulator: a world, a rig and a route make sweeps, and the truth beside them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from echoplan.acoustics import typical_transducer
from echoplan.arrays import FloatArray, IntArray, checked_number, store
from echoplan.errors import InvalidValueError
from echoplan.model import Rig, Route, Sweep, Truth, World
from echoplan.simulation.detector import build_detector
from echoplan.simulation.module import Module, build_module
from echoplan.simulation.odometry import dead_reckoning
from echoplan.simulation.receiver import ReceiverSimulation
from echoplan.simulation.scene import build_scene
from echoplan.simulation.schedule import Schedule, build_schedule
from echoplan.simulation.settings import SimulationSettings
from echoplan.simulation.shots import build_shots, memory_of
from echoplan.simulation.sonar import build_sonar
from echoplan.simulation.stage import Stage

__all__ = ["Simulation"]

# The streams of chance that a seed feeds.
_ODOMETRY, _READINGS, _THERMOMETER = 0, 1, 2


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Simulation:
    """A recording that is made while it is read: a source of sweeps like any other, with the truth beside it.

    Every sweep draws its chance from the seed and its own number, so that the same simulation yields the same bits
    however often and however far it is read.

    Parameters
    ----------
    world : World
        What stands in the room.
    rig : Rig
        What sounds it; without a transducer one is guessed from the first sensor's data sheet, without an order
        of firing all sensors fire every 25 ms.
    route : Route
        Stations, at each of which the array turns once, or stamped poses between which the robot moves.
    settings : SimulationSettings, optional
        Air, module, paths and noise.
    seed : int, optional
        Seed of all chance.

    Raises
    ------
    UnknownNameError
        If the world has a material that nobody knows.
    InvalidValueError
        If the module cannot detect the plane for which it is set right, or the rig is one of rays.

    Examples
    --------
    >>> from echoplan.model import Polyline, Sensor
    >>> wall = Polyline(points_xy=[[1.0, -2.0], [1.0, 2.0]])
    >>> sensor = Sensor(sensor_id=0, half_aperture=0.3, min_range=0.03, max_range=3.0, resolution=0.001)
    >>> simulation = Simulation(
    ...     world=World(name="one wall", polylines=(wall,)),
    ...     rig=Rig(name="one sensor", sensors=(sensor,)),
    ...     route=Route(map_from_base=[[0.0, 0.0, 0.0], [0.2, 0.0, np.pi]]),
    ...     settings=SimulationSettings(jitter=0.0),
    ... )
    >>> [float(sweep.ranges[0]) for sweep in simulation]
    [1.0, inf]
    """

    world: World
    rig: Rig
    route: Route
    settings: SimulationSettings = field(default_factory=SimulationSettings)
    seed: int = 0
    _schedule: Schedule = field(init=False)
    _module: Module = field(init=False)
    _receivers: ReceiverSimulation = field(init=False)

    def __post_init__(self) -> None:
        checked_number(self.seed, name="seed", minimum=0)
        if self.rig.rays:
            raise InvalidValueError("rays must be left out of the rig, or false: what is simulated here is sound")
        settings = self.settings
        transducer = self.rig.transducer or typical_transducer(self.rig.sensors[0])
        module = build_module(self.rig, transducer, settings)
        schedule = build_schedule(
            self.rig,
            self.route,
            servo_latency=settings.servo_latency,
            servo_gain=settings.servo_gain,
            servo_offset=settings.servo_offset,
        )
        memory = memory_of(transducer, settings.air) if settings.second_time_around else None
        stage = Stage(
            scene=build_scene(self.world),
            sonar=build_sonar(transducer, settings),
            shots=build_shots(schedule, module, memory=memory),
        )
        receivers = ReceiverSimulation(stage=stage, detector=build_detector(transducer, settings))
        store(self, _schedule=schedule, _module=module, _receivers=receivers)

    @property
    def name(self) -> str:
        """What to call the recording: the name of the world."""
        return self.world.name

    def __len__(self) -> int:
        return len(self._schedule.bounds) - 1

    def __iter__(self) -> Iterator[Sweep]:
        given = self._given()
        return (self._sweep(index, given) for index in range(len(self)))

    @property
    def truth(self) -> Truth:
        """What a map of this recording should say.

        A wall or cylinder counts as detected from a station (a sweep) if at least one ping there would be answered
        by it alone: by one specular reflection of the ping's own burst, with clear lines of sight past everything
        else, above the threshold, and neither too close nor out of reach.
        """
        walls, cylinders, stations = self.world.segments_xy, self.world.discs, self._schedule.stations
        detected = np.zeros(len(walls) + len(cylinders), dtype=np.int64)
        for index in range(len(self)):
            detected[self._receivers.detected_alone(self._pings(index))] += 1
        return Truth(
            walls_xy=walls,
            walls_detected_by=detected[: len(walls)],
            cylinders=cylinders,
            cylinders_detected_by=detected[len(walls) :],
            poses=self._schedule.map_from_base[stations],
            given=self._given()[stations],
            temperature=self.settings.air.temperature,
        )

    def _given(self) -> FloatArray:
        rng = np.random.default_rng((self.seed, _ODOMETRY))
        return dead_reckoning(self._schedule.map_from_base, self.settings.odometry, rng)

    def _pings(self, index: int) -> IntArray:
        return np.arange(*self._schedule.bounds[index : index + 2])

    def _sweep(self, index: int, given: FloatArray) -> Sweep:
        pings, schedule = self._pings(index), self._schedule
        sensors = schedule.sensors[pings]
        rng = np.random.default_rng((self.seed, _READINGS, index))
        return Sweep(
            index=index,
            stamps_ns=schedule.stamps_ns[pings],
            sensor_ids=self.rig.sensor_ids[sensors],
            servo_angles=schedule.servo_angles[pings],
            ranges=self._module.readings(self._receivers.instants(pings), sensors, rng),
            map_from_base=given[pings],
            temperature=self._temperature(),
        )

    def _temperature(self) -> float:
        """Read the thermometer, which errs all the time alike."""
        if math.isinf(self.settings.thermometer):
            return math.nan
        error = self.settings.thermometer * np.random.default_rng((self.seed, _THERMOMETER)).standard_normal()
        return round(self.settings.air.temperature + float(error), 2)

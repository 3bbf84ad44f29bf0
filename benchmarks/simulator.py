"""Speed and truthfulness of the simulator: python benchmarks/simulator.py [STATIONS].

Prints how many pings a core simulates in a second in a room of twelve walls and two cylinders, and the figures of
docs/simulator.md: the measured HC-SR04, visible widths, the bias of a plane, the edge of a box.  Widths and bias are
those of simulated readings; the measured HC-SR04 is held against the sonar equation and against the simulator.
"""

import json
import platform
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from echoplan.acoustics import (
    Air,
    audible_half_angle,
    cylinder_echo,
    edge_echo,
    plane_echo,
    plate_echo,
    reach,
    strip_echo,
    wavenumber,
)
from echoplan.arrays import FloatArray
from echoplan.io import builtin_rig
from echoplan.model import Firing, Pillar, Polyline, Rig, Route, Sensor, Servo, Transducer, World
from echoplan.simulation import Simulation, SimulationSettings

HC_SR04 = Transducer()
ROTARY_ARRAY = builtin_rig("rotary-array")
ROOM = Air()
MEASURED_IN = Air(temperature=16.7, relative_humidity=0.32)
OPTIONS: Mapping[str, Mapping[str, Any]] = {
    "default": {},
    "without crosstalk": {"crosstalk": False},
    "own bursts only": {"crosstalk": False, "second_time_around": False},
    "incoherent": {"superposition": "incoherent"},
    "carrier detector": {"detector": "carrier"},
    "one reflection": {"reflection_order": 1},
    "without diffraction": {"diffraction": False},
}
STEP = 0.1
STATIONS = np.array(
    [
        [0.97, 0.47, 2.2],
        [0.35, 1.37, 1.5],
        [0.39, 2.46, 0.5],
        [1.35, 2.95, -0.5],
        [2.27, 2.47, -1.2],
        [2.67, 1.44, -1.0],
    ]
)


def main(arguments: list[str]) -> None:
    """Print all figures."""
    stations = int(arguments[0]) if arguments else 50
    report = {
        "machine": f"{platform.platform()}, {platform.processor() or platform.machine()}",
        "pings_per_second_of_one_core": {name: speed(stations, options) for name, options in OPTIONS.items()},
        "microseconds_per_ping": {count: round(1e6 / speed(count, {}), 1) for count in (1, 10, 100)},
        "hc_sr04": measured_observations(),
        "width_in_degrees_hc_sr04": {str(distance): widths(distance) for distance in (0.3, 0.5, 1.0, 1.5, 2.0, 3.0)},
        "width_in_degrees_rotary_array": {str(distance): rotary_widths(distance) for distance in (0.5, 1.0, 2.0, 2.9)},
        "bias_in_millimetres_of_a_plane_at_1_m": bias(),
        "edge_in_decibels_against_a_plane": {str(distance): edge(distance) for distance in (0.3, 1.0, 2.0)},
    }
    print(json.dumps(report, indent=2))


def speed(stations: int, options: Mapping[str, Any]) -> int:
    """Count the pings in a second of the processor, in the best of three runs."""
    simulation = Simulation(
        world=twelve_walls_and_two_cylinders(),
        rig=ROTARY_ARRAY,
        route=Route(map_from_base=np.tile(STATIONS, (-(-stations // len(STATIONS)), 1))[:stations]),
        settings=SimulationSettings(**options),
    )
    next(iter(simulation))  # compiles
    runs = [timed(lambda: sum(len(sweep) for sweep in simulation)) for _ in range(3)]
    return 100 * round(max(pings / seconds for pings, seconds in runs) / 100)


def timed(run: Callable[[], int]) -> tuple[int, float]:
    """Return what a run returns, and the seconds of the processor that it took."""
    begun = time.process_time()
    count = run()
    return count, time.process_time() - begun


def twelve_walls_and_two_cylinders() -> World:
    """Build an L of six walls, a box, a bent board and two pillars."""
    outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.2], [2.6, 2.2], [2.6, 3.4], [0.0, 3.4]]
    box = [[1.2, 1.9], [1.9, 1.9], [1.9, 2.3], [1.2, 2.3]]
    board = [[0.4, 0.6], [0.8, 0.9], [0.9, 1.2]]
    return World(
        name="twelve walls",
        polylines=(
            Polyline(points_xy=np.array(outline), closed=True),
            Polyline(points_xy=np.array(box), closed=True),
            Polyline(points_xy=np.array(board)),
        ),
        pillars=(
            Pillar(center_xy=np.array([3.2, 1.0]), radius=0.1),
            Pillar(center_xy=np.array([0.6, 2.8]), radius=0.08),
        ),
    )


def measured_observations() -> dict[str, dict[str, float | str]]:
    """Hold what G. Dyrkacz measured with HC-SR04 against the sonar equation and the simulator, in his air."""
    wavelength = MEASURED_IN.speed_of_sound / HC_SR04.frequency
    panel = audible_half_angle(plane_echo(2.0), 4.0, transducer=HC_SR04, air=MEASURED_IN)
    radius = 0.5 * 3.5 * 0.0254

    return {
        "panel, half-angle at 2 m [degrees]": {
            "measured": 23.5,
            "equation": round(float(np.degrees(panel)), 1),
            "simulated": round(0.5 * width(wall(2.0), air=MEASURED_IN), 1),
        },
        "strip of 25.4 mm [m]": {
            "measured": 2.45,
            "equation": equation(lambda r: strip_echo(r, 0.0254, wavelength=wavelength), MEASURED_IN),
            "simulated": last_read(lambda r: wall(r, half_length=0.0127), MEASURED_IN),
        },
        "plate of 33 mm x 38 mm [m]": {
            "measured": 1.70,
            "equation": equation(lambda r: plate_echo(r, 0.033, 0.038, wavelength=wavelength), MEASURED_IN),
        },
        "cylinder of 3.5 in [m]": {
            "measured": "1.66 to 2.29",
            "equation": equation(lambda r: cylinder_echo(r, radius), MEASURED_IN),
            "simulated": last_read(lambda r: pillar(r, radius), MEASURED_IN),
        },
        "wall at 20 degrees Celsius, 50 % [m]": {
            "data sheets": "4 to 4.5",
            "equation": equation(plane_echo, ROOM),
            "simulated": last_read(wall, ROOM),
        },
    }


def equation(law: Callable[[float], FloatArray], air: Air) -> float:
    """Solve the sonar equation for the greatest distance at which something is heard."""
    return round(reach(law, transducer=HC_SR04, air=air), 2)


def last_read(world_at: Callable[[float], World], air: Air) -> float:
    """Find to a centimetre the greatest distance at which a simulated HC-SR04 reads what it looks at."""
    near, far = 0.5, 6.0
    while far - near > 0.005:
        middle = 0.5 * (near + far)
        looked = turned(world_at(middle), HC_SR04, half_turn=STEP, air=air)
        near, far = (middle, far) if np.isfinite(looked[1]) else (near, middle)
    return round(near, 2)


def widths(distance: float) -> dict[str, float]:
    """Measure over how many degrees of rotation a simulated HC-SR04 reads each thing."""
    corner = [[distance, -20.0], [distance, distance], [-20.0, distance]]
    box = np.add([[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [2.0, -2.0]], [distance, 0.0])
    return {
        "wall": width(wall(distance)),
        **{f"cylinder {radius} m": width(pillar(distance, radius)) for radius in (0.05, 0.1, 0.2, 0.5)},
        "concave corner": width(
            World(name="corner", polylines=(Polyline(points_xy=np.array(corner)),)),
            yaw=np.pi / 4,
            near=np.sqrt(2) * distance,
        ),
        "convex edge": width(World(name="box", polylines=(Polyline(points_xy=box, closed=True),))),
    }


def rotary_widths(distance: float) -> dict[str, float]:
    """Measure the same for the transducer of the rotary array."""
    return {
        "wall": width(wall(distance), transducer=ROTARY_ARRAY.transducer),
        "cylinder 0.1 m": width(pillar(distance, 0.1), transducer=ROTARY_ARRAY.transducer),
    }


def width(
    world: World,
    *,
    transducer: Transducer | None = HC_SR04,
    yaw: float = 0.0,
    near: float | None = None,
    air: Air = ROOM,
) -> float:
    """Count the degrees over which something is read, at about a distance if one is given."""
    readings = turned(world, transducer, yaw=yaw, air=air)
    read = np.isfinite(readings) if near is None else np.abs(readings - near) < 0.08
    return round(float(STEP * read.sum()), 1)


def bias() -> dict[str, float]:
    """Measure how much too long the rotary array, with its arm of 5 cm, reads a plane off its normal."""
    readings = turned(wall(1.0), ROTARY_ARRAY.transducer, arm=0.05)
    error = 1000 * (readings - readings[len(readings) // 2])
    return {str(angle): round(float(error[len(error) // 2 + round(angle / STEP)]), 1) for angle in (10, 15, 20, 25, 30)}


def turned(
    world: World,
    transducer: Transducer | None,
    *,
    yaw: float = 0.0,
    arm: float = 0.0,
    half_turn: float = 60.0,
    air: Air = ROOM,
) -> FloatArray:
    """Simulate one sensor that is turned so many degrees to either side."""
    sensor = Sensor(sensor_id=0, x=arm, half_aperture=0.5, min_range=0.02, max_range=6.0, resolution=0.0)
    rig = Rig(
        name="one sensor",
        sensors=(sensor,),
        servo=turning(half_turn),
        firing=Firing(period=0.2, groups=((0,),)),
        transducer=transducer,
    )
    route, settings = Route(map_from_base=np.array([[0.0, 0.0, yaw]])), SimulationSettings(jitter=0.0, air=air)
    (sweep,) = Simulation(world=world, rig=rig, route=route, settings=settings)
    return sweep.ranges


def turning(half_turn: float) -> Servo:
    """Build a servo that turns so many degrees to either side."""
    start, step = np.radians([-half_turn, STEP]).tolist()
    return Servo(start=start, stop=-start, step=step)


def wall(distance: float, *, half_length: float = 20.0) -> World:
    """Build a wall across the x axis."""
    ends = np.array([[distance, -half_length], [distance, half_length]])
    return World(name="wall", polylines=(Polyline(points_xy=ends),))


def pillar(distance: float, radius: float) -> World:
    """Build a cylinder whose surface is so far away on the x axis."""
    return World(
        name="pillar", polylines=(), pillars=(Pillar(center_xy=np.array([distance + radius, 0.0]), radius=radius),)
    )


def edge(distance: float) -> float:
    """Evaluate the edge of a box on its bisector against a plane at the same distance."""
    k = float(wavenumber(HC_SR04.frequency, ROOM.speed_of_sound))
    echo = edge_echo(distance, angle=0.75 * np.pi, opening=1.5 * np.pi, wavenumber=k)
    return round(float(20 * np.log10(np.abs(echo) / plane_echo(distance))), 1)


if __name__ == "__main__":
    main(sys.argv[1:])

"""Speed and truthfulness of the simulator: python benchmarks/simulator.py [STATIONS].

Prints how many pings a core simulates in a second in a room of twelve walls and two cylinders, and the figures of
docs/simulator.md: the measured HC-SR04, visible widths, the bias of a plane, the edge of a box.  Widths and bias are
those of simulated readings; the measured HC-SR04 is compared with the sonar equation and with the simulator.
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
from echoplan.model import Pillar, Polyline, Route, World
from echoplan.simulation import Simulation, SimulationSettings
from library.single_objects import HC_SR04, ROOM_AIR, ROTARY_ARRAY, STEP, detection_width, pillar_at, scan, wall_at

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
    """Compare measurements of G. Dyrkacz with HC-SR04 with the sonar equation and the simulator, in his air."""
    wavelength = MEASURED_IN.speed_of_sound / HC_SR04.frequency
    panel = audible_half_angle(plane_echo(2.0), 4.0, transducer=HC_SR04, air=MEASURED_IN)
    radius = 0.5 * 3.5 * 0.0254

    return {
        "panel, half-angle at 2 m [degrees]": {
            "measured": 23.5,
            "equation": round(float(np.degrees(panel)), 1),
            "simulated": round(0.5 * detection_width(wall_at(2.0), air=MEASURED_IN), 1),
        },
        "strip of 25.4 mm [m]": {
            "measured": 2.45,
            "equation": equation(lambda r: strip_echo(r, 0.0254, wavelength=wavelength), MEASURED_IN),
            "simulated": last_read(lambda r: wall_at(r, half_length=0.0127), MEASURED_IN),
        },
        "plate of 33 mm x 38 mm [m]": {
            "measured": 1.70,
            "equation": equation(lambda r: plate_echo(r, 0.033, 0.038, wavelength=wavelength), MEASURED_IN),
        },
        "cylinder of 3.5 in [m]": {
            "measured": "1.66 to 2.29",
            "equation": equation(lambda r: cylinder_echo(r, radius), MEASURED_IN),
            "simulated": last_read(lambda r: pillar_at(r, radius), MEASURED_IN),
        },
        "wall at 20 degrees Celsius, 50 % [m]": {
            "data sheets": "4 to 4.5",
            "equation": equation(plane_echo, ROOM_AIR),
            "simulated": last_read(wall_at, ROOM_AIR),
        },
    }


def equation(law: Callable[[float], FloatArray], air: Air) -> float:
    """Solve the sonar equation for the greatest distance at which something is detected."""
    return round(reach(law, transducer=HC_SR04, air=air), 2)


def last_read(world_at: Callable[[float], World], air: Air) -> float:
    """Find to a centimetre the greatest distance at which a simulated HC-SR04 reads what it looks at."""
    near, far = 0.5, 6.0
    while far - near > 0.005:
        middle = 0.5 * (near + far)
        looked = scan(world_at(middle), HC_SR04, half_turn=STEP, air=air)
        near, far = (middle, far) if np.isfinite(looked[1]) else (near, middle)
    return round(near, 2)


def widths(distance: float) -> dict[str, float]:
    """Measure over how many degrees of rotation a simulated HC-SR04 reads each thing."""
    corner = [[distance, -20.0], [distance, distance], [-20.0, distance]]
    box = np.add([[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [2.0, -2.0]], [distance, 0.0])
    return {
        "wall": detection_width(wall_at(distance)),
        **{f"cylinder {radius} m": detection_width(pillar_at(distance, radius)) for radius in (0.05, 0.1, 0.2, 0.5)},
        "concave corner": detection_width(
            World(name="corner", polylines=(Polyline(points_xy=np.array(corner)),)),
            yaw=np.pi / 4,
            near=np.sqrt(2) * distance,
        ),
        "convex edge": detection_width(World(name="box", polylines=(Polyline(points_xy=box, closed=True),))),
    }


def rotary_widths(distance: float) -> dict[str, float]:
    """Measure the same for the transducer of the rotary array."""
    return {
        "wall": detection_width(wall_at(distance), transducer=ROTARY_ARRAY.transducer),
        "cylinder 0.1 m": detection_width(pillar_at(distance, 0.1), transducer=ROTARY_ARRAY.transducer),
    }


def bias() -> dict[str, float]:
    """Measure how much too long the rotary array, with its arm of 5 cm, reads a plane off its normal."""
    readings = scan(wall_at(1.0), ROTARY_ARRAY.transducer, arm=0.05)
    error = 1000 * (readings - readings[len(readings) // 2])
    return {str(angle): round(float(error[len(error) // 2 + round(angle / STEP)]), 1) for angle in (10, 15, 20, 25, 30)}


def edge(distance: float) -> float:
    """Evaluate the edge of a box on its bisector against a plane at the same distance."""
    k = float(wavenumber(HC_SR04.frequency, ROOM_AIR.speed_of_sound))
    echo = edge_echo(distance, angle=0.75 * np.pi, opening=1.5 * np.pi, wavenumber=k)
    return round(float(20 * np.log10(np.abs(echo) / plane_echo(distance))), 1)


if __name__ == "__main__":
    main(sys.argv[1:])

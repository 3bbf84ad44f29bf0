"""What the array of the paper reads of single objects, against their distance: python benchmarks/paper_array.py.

Prints over how many degrees of rotation it reads a wall, a cylinder and a concave corner, and by how much it reads a
wall too long: on its normal, 30 degrees off it, and at the vertex of the parabola after the compensation.
"""

import numpy as np

from echoplan.cli.terminal import show
from echoplan.extraction import differential_clusters, minimum_distance_point
from echoplan.geometry import directions
from echoplan.model import Pings, Polyline, Table, World
from library.single_objects import ROTARY_ARRAY, detection_width, pillar_at, scan, wall_at

ARM = 0.05
STEP = 0.1
DISTANCES = (0.5, 1.0, 1.5, 2.0, 2.5, 2.9)


def main() -> None:
    """Print both tables."""
    show(
        Table(
            title="Degrees of rotation over which the array reads an object",
            columns=("distance (m)", "wall", "cylinder of 10 cm radius", "concave corner"),
            rows=tuple((f"{distance:.1f}", *(f"{each:.1f}" for each in widths(distance))) for distance in DISTANCES),
        )
    )
    show(
        Table(
            title="By how much a wall is read too long (mm), on its normal, 30 degrees off and at the vertex",
            columns=("distance (m)", "on the normal", "30 degrees off", "vertex"),
            rows=tuple((f"{distance:.1f}", *(f"{each:.1f}" for each in errors(distance))) for distance in DISTANCES),
        )
    )


def widths(distance: float) -> tuple[float, float, float]:
    """Measure the widths; the distance of a corner is that of its two walls, whose vertex lies farther by sqrt(2)."""
    corner = np.array([[distance, -20.0], [distance, distance], [-20.0, distance]])
    world, transducer = World(name="corner", polylines=(Polyline(points_xy=corner),)), ROTARY_ARRAY.transducer
    return (
        detection_width(wall_at(distance), transducer=transducer),
        detection_width(pillar_at(distance, 0.1), transducer=transducer),
        detection_width(world, transducer=transducer, yaw=np.pi / 4, near=np.sqrt(2) * distance),
    )


def errors(distance: float) -> tuple[float, float, float]:
    """Measure the errors in millimetres; the hub is as far from the wall as the distance says."""
    ranges = scan(wall_at(distance), ROTARY_ARRAY.transducer, arm=ARM)
    bearings = np.radians(STEP * (np.arange(len(ranges)) - len(ranges) // 2))
    read = np.isfinite(ranges)
    hubs = np.zeros((int(read.sum()), 2))
    pings = Pings(
        origins_xy=hubs + ARM * directions(bearings[read]),
        hubs_xy=hubs,
        bearings=bearings[read],
        ranges=ranges[read],
        sensors=np.zeros(len(hubs), dtype=np.int64),
    )
    (cluster,) = differential_clusters(pings)
    point = minimum_distance_point(cluster)
    off = 1000 * (ranges + ARM - distance)
    middle = len(ranges) // 2
    vertex = np.nan if point is None else 1000 * (point.distance - distance)
    return float(off[middle]), float(off[middle + round(30 / STEP)]), float(vertex)


if __name__ == "__main__":
    main()

"""Tables of the features of a map."""

import math
from collections.abc import Sequence

from echoplan.model import Corner, Cylinder, Opening, Table, Wall
from echoplan.viewer.uncertainty import greatest_sigma, half_interval, middle_sigma, sigma
from echoplan.viewer.wording import SIGMA, decimal, in_percent

__all__ = ["corner_table", "cylinder_table", "opening_table", "wall_table"]


def wall_table(walls: Sequence[Wall]) -> Table:
    """Tabulate walls.

    Parameters
    ----------
    walls : sequence of Wall
        The walls of a map.

    Returns
    -------
    Table
        A row a wall, numbered as in ``map.json``.
    """
    return Table(
        title="Walls",
        columns=(
            "wall",
            "length (m)",
            "normal (°)",
            "offset (m)",
            f"{SIGMA} across (mm)",
            "wall (%)",
            "pings",
            "stations",
        ),
        rows=tuple(
            (
                str(number),
                decimal(wall.length, 3),
                decimal(math.degrees(wall.normal_angle), 1),
                decimal(wall.offset, 3),
                decimal(1000 * middle_sigma(wall), 1),
                *_counts(wall, wall.class_probabilities.wall),
            )
            for number, wall in enumerate(walls)
        ),
    )


def corner_table(corners: Sequence[Corner]) -> Table:
    """Tabulate corners.

    Parameters
    ----------
    corners : sequence of Corner
        The corners of a map.

    Returns
    -------
    Table
        A row a corner, numbered as in ``map.json``; sigma is that along the long axis of its ellipse.
    """
    return Table(
        title="Corners",
        columns=("corner", "x (m)", "y (m)", "kind", f"{SIGMA} (mm)", "corner (%)", "pings", "stations"),
        rows=tuple(
            (
                str(number),
                *(decimal(value, 3) for value in corner.position_xy),
                str(corner.kind),
                decimal(1000 * greatest_sigma(corner.covariance), 1),
                *_counts(corner, corner.class_probabilities.corner),
            )
            for number, corner in enumerate(corners)
        ),
    )


def cylinder_table(cylinders: Sequence[Cylinder]) -> Table:
    """Tabulate cylinders.

    Parameters
    ----------
    cylinders : sequence of Cylinder
        The cylinders of a map.

    Returns
    -------
    Table
        A row a cylinder, numbered as in ``map.json``; sigma of the centre is that along the long axis of its ellipse.
    """
    sigmas = (f"{SIGMA} centre (mm)", f"{SIGMA} radius (mm)")
    return Table(
        title="Cylinders",
        columns=("cylinder", "x (m)", "y (m)", "radius (m)", *sigmas, "cylinder (%)", "pings", "stations"),
        rows=tuple(
            (
                str(number),
                *(decimal(value, 3) for value in (*cylinder.center_xy, cylinder.radius)),
                decimal(1000 * greatest_sigma(cylinder.covariance[:2, :2]), 1),
                decimal(1000 * sigma(cylinder.covariance, 2), 1),
                *_counts(cylinder, cylinder.class_probabilities.cylinder),
            )
            for number, cylinder in enumerate(cylinders)
        ),
    )


def opening_table(openings: Sequence[Opening]) -> Table:
    """Tabulate openings.

    Parameters
    ----------
    openings : sequence of Opening
        The openings of a map.

    Returns
    -------
    Table
        A row an opening, numbered as in ``map.json``: its width and half its 95 % interval, its middle,
        the walls beside it, and whether the robot drove through or only sound travelled through.
    """
    return Table(
        title="Openings",
        columns=("opening", "width, 95 % (m)", "x (m)", "y (m)", "walls", "evidence"),
        rows=tuple(
            (
                str(number),
                f"{decimal(opening.width, 3)} ± {decimal(half_interval(opening.width_sigma), 3)}",
                *(decimal(value, 3) for value in opening.endpoints_xy.mean(axis=0)),
                ", ".join(map(str, dict.fromkeys(opening.walls))),
                "driven through" if opening.passed else "seen through",
            )
            for number, opening in enumerate(openings)
        ),
    )


def _counts(feature: Wall | Corner | Cylinder, probability: float) -> tuple[str, str, str]:
    return in_percent(probability), str(feature.pings), str(feature.stations)

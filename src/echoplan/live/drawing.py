"""The map as a page draws it: plain lists in metres, with what there is to know of each thing."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from echoplan.geometry import directions
from echoplan.model import Wall
from echoplan.viewer.facts import (
    corner_facts,
    cylinder_facts,
    opening_facts,
    station_facts,
    unobserved_facts,
    wall_facts,
)
from echoplan.viewer.outline import body_pieces, jamb_strokes, wall_bodies
from echoplan.viewer.plan import Plan
from echoplan.viewer.uncertainty import Ellipse, wall_band
from echoplan.viewer.wording import decimal

__all__ = ["drawing_of"]

Json = dict[str, object]

# More echoes than this are thinned out: a phone draws them all again when the map changes.
_MOST_ECHOES = 4000


def drawing_of(plan: Plan) -> Json:
    """Return a map as JSON: landmarks, openings, stations and echoes; lengths in metres."""
    found = plan.feature_map
    times = plan.magnification
    return {
        "magnification": times,
        "walls": list(_walls(plan)),
        "openings": list(_openings(plan)),
        "unobserved": [
            {"ends": _points(each.endpoints_xy), "facts": facts.text}
            for each, facts in zip(found.unobserved, unobserved_facts(found.unobserved), strict=True)
        ],
        "corners": [
            {
                "place": _points(corner.position_xy),
                "kind": str(corner.kind),
                "ellipse": _ellipse(ellipse, times=times),
                "facts": facts.text,
            }
            for corner, ellipse, facts in zip(found.corners, plan.ellipses, corner_facts(found.corners), strict=False)
        ],
        "cylinders": [
            {
                "place": _points(cylinder.center_xy),
                "radius": round(cylinder.radius, 4),
                "ellipse": _ellipse(ellipse, times=times),
                "facts": facts.text,
            }
            for cylinder, ellipse, facts in zip(
                found.cylinders, plan.ellipses[len(found.corners) :], cylinder_facts(found.cylinders), strict=True
            )
        ],
        "poses": list(_poses(plan)),
        "echoes": _points(plan.echoes_xy[:: -(-len(plan.echoes_xy) // _MOST_ECHOES) or 1]),
    }


def _walls(plan: Plan) -> Iterator[Json]:
    walls = plan.feature_map.walls
    bodies = wall_bodies(walls, plan.feature_map.poses[:, :2], thickness=plan.thickness)
    for wall, body, facts in zip(walls, bodies, wall_facts(walls), strict=True):
        observed, inferred = body_pieces(body, wall.inferred)
        yield {
            "observed": [_points(each) for each in observed],
            "inferred": [_points(each) for each in inferred],
            "band": _band(wall, times=plan.magnification),
            "facts": facts.text,
        }


def _band(wall: Wall, *, times: int) -> list[object]:
    """Outline the band in which a wall lies with 95 % probability, so many times enlarged."""
    along, half = wall_band(wall).T
    start, end = wall.endpoints_xy
    middle = start + along[:, None] * (end - start) / wall.length
    across = times * half[:, None] * directions(wall.normal_angle)
    return _points(np.concatenate([middle + across, (middle - across)[::-1]]))


def _openings(plan: Plan) -> Iterator[Json]:
    found = plan.feature_map
    bodies = wall_bodies(found.walls, found.poses[:, :2], thickness=plan.thickness)
    for opening, facts in zip(found.openings, opening_facts(found.openings), strict=True):
        yield {
            "ends": _points(opening.endpoints_xy),
            "jambs": _points(jamb_strokes(opening, bodies, thickness=plan.thickness)),
            "width": f"{decimal(opening.width, 2)} m",
            "passed": opening.passed,
            "facts": facts.text,
        }


def _poses(plan: Plan) -> Iterator[Json]:
    """Corrected poses of the sweeps, with their ellipses."""
    found = plan.feature_map
    ellipses: list[list[float] | None] = [_ellipse(each, times=plan.magnification) for each in plan.pose_ellipses]
    for sweep, pose, ellipse, facts in zip(
        found.sweeps.tolist(), found.poses, ellipses or [None] * len(found.poses), station_facts(found), strict=True
    ):
        yield {"sweep": sweep, "pose": _points(pose), "ellipse": ellipse, "facts": facts.text}


def _ellipse(ellipse: Ellipse, *, times: int) -> list[float]:
    """Centre, semi-axes, so many times enlarged [m], and direction of the long one [rad]."""
    numbers = [*ellipse.center_xy, *(times * ellipse.semi_axes), ellipse.angle]
    return [round(float(each), 4) for each in numbers]


def _points(points: ArrayLike) -> list[object]:
    rounded: list[object] = np.round(np.asarray(points), 4).tolist()
    return rounded

"""What there is to know of each feature and station, as text."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.model import Corner, Cylinder, FeatureClass, FeatureMap, Opening, UnobservedStretch, Wall
from echoplan.viewer.plan import station_labels
from echoplan.viewer.uncertainty import error_ellipse, half_interval, middle_sigma, sigma
from echoplan.viewer.wording import SIGMA, decimal, in_degrees, in_metres, in_millimetres, in_percent, plural, point

__all__ = [
    "Facts",
    "corner_facts",
    "cylinder_facts",
    "opening_facts",
    "station_facts",
    "unobserved_facts",
    "wall_facts",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What there is to know of one thing.

    Parameters
    ----------
    title : str
        Its name, as ``wall 0``: numbered as in ``map.json``.
    items : tuple of tuple of str
        Names and values.
    """

    title: str
    items: tuple[tuple[str, str], ...]

    @property
    def kind(self) -> str:
        """What it is, as ``wall``."""
        return self.title.split()[0]

    @property
    def key(self) -> str:
        """Its name without blanks."""
        return self.title.replace(" ", "-")

    @property
    def text(self) -> str:
        """All of it, a line a fact."""
        return "\n".join([self.title, *(f"{name}: {value}" for name, value in self.items)])


def wall_facts(walls: Sequence[Wall]) -> list[Facts]:
    """Describe what there is to know of walls.

    Parameters
    ----------
    walls : sequence of Wall
        The walls of a map.

    Returns
    -------
    list of Facts
        One a wall.
    """
    return [
        Facts(
            title=f"wall {number}",
            items=(
                ("from", point(wall.endpoints_xy[0])),
                ("to", point(wall.endpoints_xy[1])),
                ("length", in_metres(wall.length)),
                (
                    "normal",
                    f"{in_degrees(wall.normal_angle)}, {SIGMA} {in_degrees(sigma(wall.covariance, 0), digits=2)}",
                ),
                ("offset", f"{in_metres(wall.offset)}, {SIGMA} {in_millimetres(sigma(wall.covariance, 1))}"),
                (f"{SIGMA} across, in its middle", in_millimetres(middle_sigma(wall))),
                *_ends(wall),
                *_evidence(wall),
            ),
        )
        for number, wall in enumerate(walls)
    ]


def corner_facts(corners: Sequence[Corner]) -> list[Facts]:
    """Describe what there is to know of corners.

    Parameters
    ----------
    corners : sequence of Corner
        The corners of a map.

    Returns
    -------
    list of Facts
        One a corner.
    """
    return [
        Facts(
            title=f"corner {number}",
            items=(
                ("at", point(corner.position_xy)),
                ("kind", str(corner.kind)),
                *_spread(corner.position_xy, corner.covariance),
                *_evidence(corner),
            ),
        )
        for number, corner in enumerate(corners)
    ]


def cylinder_facts(cylinders: Sequence[Cylinder]) -> list[Facts]:
    """Describe what there is to know of cylinders.

    Parameters
    ----------
    cylinders : sequence of Cylinder
        The cylinders of a map.

    Returns
    -------
    list of Facts
        One a cylinder.
    """
    return [
        Facts(
            title=f"cylinder {number}",
            items=(
                ("centre", point(cylinder.center_xy)),
                ("radius", f"{in_metres(cylinder.radius)}, {SIGMA} {in_millimetres(sigma(cylinder.covariance, 2))}"),
                *_spread(cylinder.center_xy, cylinder.covariance[:2, :2]),
                *_evidence(cylinder),
            ),
        )
        for number, cylinder in enumerate(cylinders)
    ]


def opening_facts(openings: Sequence[Opening]) -> list[Facts]:
    """List the facts of openings, one value an opening."""
    return [
        Facts(
            title=f"opening {number}",
            items=(
                *_gap(opening),
                ("width", f"{in_metres(opening.width)} ± {in_metres(half_interval(opening.width_sigma))} (95 %)"),
                ("evidence", "driven through" if opening.passed else "seen through"),
            ),
        )
        for number, opening in enumerate(openings)
    ]


def unobserved_facts(unobserved: Sequence[UnobservedStretch]) -> list[Facts]:
    """List the facts of unobserved stretches, one value a stretch."""
    return [
        Facts(
            title=f"unobserved stretch {number}",
            items=(*_gap(stretch), ("meaning", "wall or opening: no station could observe it")),
        )
        for number, stretch in enumerate(unobserved)
    ]


def station_facts(feature_map: FeatureMap) -> list[Facts]:
    """Describe where each sweep was made.

    Parameters
    ----------
    feature_map : FeatureMap
        A map with its poses.

    Returns
    -------
    list of Facts
        One a station.
    """
    labels = station_labels(feature_map.sweeps, feature_map.poses[:, :2])
    spreads = [
        (
            *_spread(pose[:2], covariance[:2, :2]),
            (f"{SIGMA} of the heading", in_degrees(sigma(covariance, 2), digits=2)),
        )
        for pose, covariance in zip(feature_map.poses, feature_map.pose_covariances, strict=False)
    ]
    return [
        Facts(
            title=f"station {sweep}",
            items=(
                ("label", label or "none"),
                ("at", point(pose[:2])),
                ("heading", in_degrees(float(wrap(pose[2])))),
                *spread,
            ),
        )
        for label, sweep, pose, spread in zip(
            labels, feature_map.sweeps.tolist(), feature_map.poses, spreads or [()] * len(labels), strict=True
        )
    ]


def _spread(position_xy: FloatArray, covariance: FloatArray) -> tuple[tuple[str, str], ...]:
    ellipse = error_ellipse(position_xy, covariance)
    long, short = (decimal(1000 * each, 1) for each in ellipse.semi_axes)
    sigmas = f"{in_millimetres(sigma(covariance, 0))}, {in_millimetres(sigma(covariance, 1))}"
    # An axis has no sense: its direction is given modulo half a turn.
    direction = in_degrees(math.remainder(ellipse.angle, math.pi), digits=0)
    return ((f"{SIGMA} in x, y", sigmas), ("95 % ellipse", f"± {long} by {short} mm, long axis at {direction}"))


def _gap(gap: Opening | UnobservedStretch) -> tuple[tuple[str, str], ...]:
    ends = (("from", point(gap.endpoints_xy[0])), ("to", point(gap.endpoints_xy[1])))
    beside = " and ".join(f"wall {wall}" for wall in dict.fromkeys(gap.walls))
    return (*ends, ("beside", beside)) if beside else ends


def _ends(wall: Wall) -> list[tuple[str, str]]:
    """List what is known of the ends of a wall: only what was estimated, and only lengths that are not zero."""
    ends = list(zip(("start", "end"), wall.endpoint_sigmas.tolist(), wall.inferred.tolist(), strict=True))
    sigmas = [(f"{SIGMA} of its {name}", in_millimetres(sigma)) for name, sigma, _ in ends if not math.isnan(sigma)]
    inferred = [(f"inferred at its {name}", in_metres(length)) for name, _, length in ends if length]
    return [*sigmas, *inferred]


def _evidence(feature: Wall | Corner | Cylinder) -> tuple[tuple[str, str], ...]:
    probabilities = feature.class_probabilities
    classes = ", ".join(f"{name} {in_percent(getattr(probabilities, name))} %" for name in FeatureClass)
    detected = f"{plural(feature.pings, 'ping')} from {plural(feature.stations, 'station')}"
    return (("class", classes), ("detected by", detected if feature.pings else "no ping of its own"))

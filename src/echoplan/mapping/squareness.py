"""Squareness: whether the walls of a place stand at right angles to each other, and what follows if they do."""

import math
from collections.abc import Sequence

import numpy as np
from pydantic import BaseModel, Field

from echoplan.classification.hypotheses import Hypothesis
from echoplan.geometry import wrap

__all__ = ["SquarenessSettings", "main_direction", "off_square"]


class SquarenessSettings(BaseModel, frozen=True, extra="forbid"):
    """When right angles are believed in."""

    concentration: float = Field(
        default=0.8, gt=0.0, le=1.0, description="of the directions of walls, folded by right angles, from which on"
    )
    least_walls: int = Field(default=4, ge=2, description="from which anything follows")
    within: float = Field(default=math.radians(12), gt=0.0, description="of the main direction counts as square [rad]")
    sigma: float = Field(default=math.radians(1), gt=0.0, description="of such walls about it [rad]")
    cost: float = Field(default=100.0, ge=0.0, description="of a wall that is not square [nats]")


def main_direction(features: Sequence[Hypothesis], settings: SquarenessSettings) -> float | None:
    """Find the direction to which, or across which, most walls stand.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there.
    settings : SquarenessSettings
        When right angles are believed in.

    Returns
    -------
    float or None
        Direction of a normal [rad], modulo a right angle; None where the walls do not support one.
    """
    walls = [each for each in features if each.is_wall]
    if len(walls) < settings.least_walls:
        return None
    gains = np.array([each.total for each in walls])
    mean = np.sum(gains * np.exp(4j * np.array([each.line[0] for each in walls]))) / gains.sum()
    return float(np.angle(mean)) / 4 if abs(mean) > settings.concentration else None


def off_square(angle: float, direction: float) -> float:
    """Tell by how much a wall is off the nearest square direction.

    Parameters
    ----------
    angle : float
        Direction of its normal [rad].
    direction : float
        The main direction [rad].

    Returns
    -------
    float
        Within 45 degrees [rad].

    Examples
    --------
    >>> round(math.degrees(off_square(math.radians(93), 0.0)), 6)
    3.0
    """
    return float(wrap(4 * (angle - direction))) / 4

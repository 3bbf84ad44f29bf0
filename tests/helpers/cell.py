"""A small room without a right angle, with a pillar: what every method is tried on."""

import numpy as np

from echoplan.model import Pillar, Polyline, World

__all__ = ["CELL"]

CELL = World(
    name="cell",
    polylines=(Polyline(points_xy=np.array([[0.0, 0.0], [2.4, 0.2], [2.1, 1.9], [0.1, 1.6]]), closed=True),),
    pillars=(Pillar(center_xy=np.array([1.7, 0.7]), radius=0.08),),
)

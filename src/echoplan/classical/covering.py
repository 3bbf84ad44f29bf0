"""Covering: whether something nearer cuts off what an object answers (Table 2 of the paper)."""

from enum import IntEnum

from echoplan.extraction import Cluster

__all__ = ["Covering", "covering_state"]


class Covering(IntEnum):
    """Boundary state of a cluster, with the values of Table 2; left and right as seen from the sensor."""

    NONE = 0
    LEFT = 1
    RIGHT = 2
    FRONT = 3


def covering_state(cluster: Cluster) -> Covering:
    """Return the ends of a cluster at which a nearer echo occludes it.

    Parameters
    ----------
    cluster : Cluster
        Echoes of one object, with the distances of the echoes beyond its ends.

    Returns
    -------
    Covering
        An end is covered if the echo beyond it is nearer than the object's own echo there; a farther echo or
        none leaves it uncovered.  Covered at both ends is covered in front.
    """
    left = cluster.left < cluster.distances[-1]
    right = cluster.right < cluster.distances[0]
    return Covering(Covering.LEFT * left + Covering.RIGHT * right)

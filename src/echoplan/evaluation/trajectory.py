"""How far the poses of a map are off."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.geometry import wrap
from echoplan.model import FeatureMap, Truth

__all__ = ["Trajectory", "compare_poses"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Trajectory:
    """Errors of s poses.

    Parameters
    ----------
    distances : ndarray, shape (s,)
        Between estimated and true positions [m].
    angles : ndarray, shape (s,)
        Estimated less true headings, in [-pi, pi) [rad].
    """

    distances: FloatArray
    angles: FloatArray

    def __post_init__(self) -> None:
        distances = checked_floats(self.distances, name="distances", shape=(None,))
        store(self, distances=distances, angles=checked_floats(self.angles, name="angles", shape=(len(distances),)))

    @property
    def absolute_error(self) -> float:
        """Absolute trajectory error (ATE): root mean square of the distances [m]."""
        return float(np.sqrt(np.mean(self.distances**2)))

    @property
    def heading_error(self) -> float:
        """Root mean square of the angles [rad]."""
        return float(np.sqrt(np.mean(self.angles**2)))


def compare_poses(feature_map: FeatureMap, truth: Truth) -> Trajectory | None:
    """Hold the poses of a map against the true ones, without aligning them: both are in the frame of the map.

    Parameters
    ----------
    feature_map : FeatureMap
        The estimates, one a sweep.
    truth : Truth
        The true poses.

    Returns
    -------
    Trajectory or None
        None if there are no poses or their numbers differ.
    """
    if not len(truth.poses) or len(feature_map.poses) != len(truth.poses):
        return None
    errors = feature_map.poses - truth.poses
    return Trajectory(distances=np.hypot(errors[:, 0], errors[:, 1]), angles=wrap(errors[:, 2]))

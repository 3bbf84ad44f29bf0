"""How far the poses of a map are off, by themselves and from one to the next.

ATE and RPE are those of evo (Grupp 2017) without alignment: the map and the truth are in one frame.
"""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.evaluation.consistency import Consistency, check_errors
from echoplan.geometry import compose, invert, wrap
from echoplan.model import FeatureMap, Table, Truth

__all__ = ["Trajectory", "compare_poses", "trajectory_table"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Trajectory:
    """Errors of s poses.

    Parameters
    ----------
    distances : ndarray, shape (s,)
        Between estimated and true positions [m].
    angles : ndarray, shape (s,)
        Estimated less true headings, in [-pi, pi) [rad].
    steps : ndarray, shape (s - 1, 3)
        Error of each step from one pose to the next, in the frame of the true one after it: what evo calls
        ``(Q_i^-1 Q_j)^-1 (P_i^-1 P_j)`` [m, m, rad].
    positions, headings : Consistency
        Errors against the map's own covariances, of all poses but the first, which is the frame; empty where the map
        has none.
    """

    distances: FloatArray
    angles: FloatArray
    steps: FloatArray
    positions: Consistency
    headings: Consistency

    def __post_init__(self) -> None:
        distances = checked_floats(self.distances, name="distances", shape=(None,))
        steps = checked_floats(self.steps, name="steps", shape=(max(len(distances) - 1, 0), 3))
        angles = checked_floats(self.angles, name="angles", shape=(len(distances),))
        store(self, distances=distances, angles=angles, steps=steps)

    @property
    def absolute_error(self) -> float:
        """Absolute trajectory error (ATE): root mean square of the distances [m]."""
        return _root_mean_square(self.distances)

    @property
    def heading_error(self) -> float:
        """Root mean square of the angles [rad]."""
        return _root_mean_square(self.angles)

    @property
    def relative_error(self) -> float:
        """Relative pose error (RPE) of translation: root mean square over the steps [m]; nan for a single pose."""
        return _root_mean_square(np.hypot(self.steps[:, 0], self.steps[:, 1]))

    @property
    def relative_heading_error(self) -> float:
        """Relative pose error (RPE) of rotation: root mean square over the steps [rad]; nan for a single pose."""
        return _root_mean_square(self.steps[:, 2])


def compare_poses(feature_map: FeatureMap, truth: Truth) -> Trajectory | None:
    """Compare the poses of a map with the true ones, without aligning them: both are in the frame of the map.

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
    errors[:, 2] = wrap(errors[:, 2])
    covariances = feature_map.pose_covariances
    free = errors[1:] if len(covariances) else errors[:0]
    return Trajectory(
        distances=np.hypot(errors[:, 0], errors[:, 1]),
        angles=errors[:, 2],
        steps=compose(invert(_steps(truth.poses)), _steps(feature_map.poses)),
        positions=check_errors(free[:, :2], covariances[1:, :2, :2]),
        headings=check_errors(free[:, 2:], covariances[1:, 2:, 2:]),
    )


def trajectory_table(trajectory: Trajectory | None) -> Table:
    """Return the errors of the poses of a map: ATE, RPE and consistency.

    Parameters
    ----------
    trajectory : Trajectory or None
        Their errors.

    Returns
    -------
    Table
        A row for positions and one for headings; none where poses cannot be compared.
    """
    columns = ("of", "ATE (RMS)", "RPE (RMS of steps)", "worst", "inside 95 % (%)")
    if trajectory is None:
        return Table(title="Accuracy of the poses", columns=columns, rows=())
    positions = (trajectory.absolute_error, trajectory.relative_error, float(trajectory.distances.max()))
    headings = (trajectory.heading_error, trajectory.relative_heading_error, float(np.abs(trajectory.angles).max()))
    rows = (
        ("position (mm)", *(_decimal(1000 * each, 1) for each in positions), _inside(trajectory.positions)),
        ("heading (°)", *(_decimal(float(np.degrees(each)), 2) for each in headings), _inside(trajectory.headings)),
    )
    return Table(title="Accuracy of the poses", columns=columns, rows=rows)


def _steps(poses: FloatArray) -> FloatArray:
    return compose(invert(poses[:-1]), poses[1:])


def _root_mean_square(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def _inside(consistency: Consistency) -> str:
    return _decimal(100 * consistency.share_inside, 1)


def _decimal(value: float, digits: int) -> str:
    return "-" if np.isnan(value) else f"{value:.{digits}f}"

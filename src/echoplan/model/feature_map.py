"""The map: features, the poses from which they were detected, and whether it can be trusted."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from echoplan.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    checked_covariance,
    checked_floats,
    checked_integers,
    store,
)
from echoplan.errors import InvalidValueError
from echoplan.model.changes import Changes
from echoplan.model.features import Corner, Cylinder, Opening, UnobservedStretch, Wall
from echoplan.model.quality import Quality

__all__ = ["FeatureMap"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FeatureMap:
    """A map of features, with the poses from which they were detected.

    Parameters
    ----------
    method : str
        Name of the method that made it.
    walls : tuple of Wall, optional
        The walls.
    corners : tuple of Corner, optional
        The corners.
    cylinders : tuple of Cylinder, optional
        The cylinders.
    sweeps : ndarray of int, shape (s,), optional
        Numbers of the sweeps that were mapped.
    poses : ndarray, shape (s, 3), optional
        Pose of each sweep [m, m, rad]; corrected where the method corrects poses, else as given.
    pose_covariances : ndarray, shape (s, 3, 3), optional
        Of x, y and yaw of each pose in the frame of the map [m, m, rad]; of shape (0, 3, 3) where poses were not
        corrected.
    frame : str, optional
        Frame of all coordinates (REP 105).
    parameters : mapping, optional
        Settings of the run, ready for JSON.
    openings : tuple of Opening, optional
        Doorways and other gaps between walls.
    unobserved : tuple of UnobservedStretch, optional
        Stretches of wall lines that no station could observe.
    quality : Quality, optional
        Whether the map can be trusted; None where it was not assessed.
    changes : tuple of Changes, optional
        What has changed, for each recording that others came before.

    Raises
    ------
    InvalidValueError
        If sweeps and poses differ in number, or poses and those of their covariances that there are; if one of
        these is invalid; or if an opening or an unobserved stretch refers to a wall that the map does not hold.
    """

    method: str
    walls: tuple[Wall, ...] = ()
    corners: tuple[Corner, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    sweeps: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    poses: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    pose_covariances: FloatArray = field(default_factory=lambda: np.zeros((0, 3, 3)))
    frame: str = "map"
    parameters: Mapping[str, object] = field(default_factory=dict)
    openings: tuple[Opening, ...] = ()
    unobserved: tuple[UnobservedStretch, ...] = ()
    quality: Quality | None = None
    changes: tuple[Changes, ...] = ()

    def __post_init__(self) -> None:
        gaps: tuple[Opening | UnobservedStretch, ...] = (*self.openings, *self.unobserved)
        for gap in gaps:
            for wall in gap.walls:
                if not 0 <= wall < len(self.walls):
                    raise InvalidValueError(f"wall {wall} is not in the map: it holds {len(self.walls)} walls")
        sweeps = checked_integers(self.sweeps, name="sweeps", shape=(None,))
        count = len(sweeps) if len(self.pose_covariances) else 0
        covariances = checked_floats(self.pose_covariances, name="pose_covariances", shape=(count, 3, 3))
        for number, covariance in enumerate(covariances):
            checked_covariance(covariance, name=f"pose_covariances[{number}]", size=3)
        poses = checked_floats(self.poses, name="poses", shape=(len(sweeps), 3))
        store(self, sweeps=sweeps, poses=poses, pose_covariances=covariances)

    @property
    def paths_xy(self) -> list[FloatArray]:
        """Path of the robot in each recording [m], shape (p, 2) each."""
        firsts = [each.first_sweep for each in self.changes if each.first_sweep is not None]
        parts = np.split(self.poses[:, :2], np.searchsorted(self.sweeps, firsts))
        return [part for part in parts if len(part)]

    @property
    def unobserved_ends(self) -> BoolArray:
        """Ends of walls that were not observed, shape (w, 2): the wall is drawn as far as it was detected.

        Where a method estimates how sure the ends of walls are, an end without an estimate is such an end.
        """
        sigmas = np.array([wall.endpoint_sigmas for wall in self.walls]).reshape(-1, 2)
        inferred = np.array([wall.inferred for wall in self.walls]).reshape(-1, 2)
        is_unknown: BoolArray = np.isnan(sigmas) & (inferred == 0.0) & bool(np.isfinite(sigmas).any())
        return is_unknown

    @property
    def is_empty(self) -> bool:
        """Whether nothing was found."""
        return not (self.walls or self.corners or self.cylinders)

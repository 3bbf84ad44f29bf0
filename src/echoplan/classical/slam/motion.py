"""Motion between sweeps by odometry, and its covariance."""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.slam.gaussian_state import GaussianState
from echoplan.geometry import compose, directions
from echoplan.settings import Settings

__all__ = ["MotionSettings", "moved"]


class MotionSettings(Settings):
    """Odometry noise: a random walk, as of a small robot with wheel encoders on a hard floor."""

    along: float = Field(
        default=0.02, ge=0.0, description="Standard deviation of odometry along the path after 1 m [m]."
    )
    lateral: float = Field(
        default=0.02, ge=0.0, description="Standard deviation of odometry across the path after 1 m [m]."
    )
    yaw_per_metre: float = Field(
        default=0.035, ge=0.0, description="Standard deviation of the heading after 1 m [rad]: 2 degrees."
    )
    yaw_per_radian: float = Field(
        default=0.035, ge=0.0, description="Standard deviation of the heading after a turn of 1 rad [rad]."
    )

    def covariance(self, motion: FloatArray) -> FloatArray:
        """Covariance of a motion, in the frame in which it began.

        Parameters
        ----------
        motion : ndarray, shape (3,)
            ``(x, y, yaw)`` from one sweep to the next [m, m, rad].

        Returns
        -------
        ndarray, shape (3, 3)
            Covariance of x, y and yaw; variances grow with distance and turn.
        """
        way, turn = float(np.hypot(*motion[:2])), abs(float(motion[2]))
        ahead, aside = _axes(float(np.arctan2(motion[1], motion[0])))
        spread = np.zeros((3, 3))
        spread[:2, :2] = way * (self.along**2 * np.outer(ahead, ahead) + self.lateral**2 * np.outer(aside, aside))
        spread[2, 2] = self.yaw_per_metre**2 * way + self.yaw_per_radian**2 * turn
        return spread


def moved(
    state: GaussianState, block: str, motion: FloatArray, *, start: str, settings: MotionSettings
) -> GaussianState:
    """Predict the pose after a motion and augment the state with it; the pose before it stays.

    Parameters
    ----------
    state : GaussianState
        Contains the pose at which the motion began.
    block : str
        Name of the new pose.
    motion : ndarray, shape (3,)
        In the frame of the old pose [m, m, rad].
    start : str
        Name of the old pose.
    settings : MotionSettings
        Noise of the motion.

    Returns
    -------
    GaussianState
        The state with the new pose last.

    Examples
    --------
    >>> start = GaussianState(sizes={"a": 3}, mean=np.array([0.0, 0.0, np.pi / 2]), covariance=np.zeros((3, 3)))
    >>> moved(start, "b", np.array([1.0, 0.0, 0.1]), start="a", settings=MotionSettings())["b"].round(4)
    array([0.    , 1.    , 1.6708])
    """
    pose = state[start]
    after = compose(pose, motion)
    after[2] = pose[2] + motion[2]
    x, y = after[:2] - pose[:2]
    turned = np.eye(3)
    turned[:2, :2] = np.stack(_axes(float(pose[2])), axis=1)
    return state.extended(
        block,
        after,
        given=[start],
        jacobian=np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]]),
        noise=turned @ settings.covariance(motion) @ turned.T,
    )


def _axes(angle: float) -> tuple[FloatArray, FloatArray]:
    return directions(angle), directions(angle + np.pi / 2)

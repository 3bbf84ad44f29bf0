"""Map simulated recordings by the method joint, and measure the time."""

import time
from collections.abc import Sequence

from echoplan.joint.map_extraction.segments import SegmentSettings
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Sweep
from echoplan.simulation import Simulation

__all__ = ["map_by_joint"]


def map_by_joint(
    simulation: Simulation, sweeps: Sequence[Sweep], poses: PoseMode, *, driven: bool = False
) -> tuple[FeatureMap, float]:
    """Map the sweeps of a simulation; ``driven`` if the robot drove between them. Returns the map and CPU seconds."""
    settings, begun = JointSettings(poses=poses, segments=SegmentSettings(driven=driven)), time.process_time()
    feature_map = map_sweeps(JointMapper(simulation.rig, settings), sweeps)
    return feature_map, time.process_time() - begun

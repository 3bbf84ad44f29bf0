"""The simulator: a world, a rig and a route make sweeps by the physics of sound."""

from echoplan.simulation.odometry import with_odometry
from echoplan.simulation.settings import OdometryNoise, SimulationSettings
from echoplan.simulation.simulation import Simulation

__all__ = ["OdometryNoise", "Simulation", "SimulationSettings", "with_odometry"]

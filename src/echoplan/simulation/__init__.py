"""The simulator: a world, a rig and a route make sweeps by the physics of sound."""

from echoplan.simulation.settings import OdometryNoise, SimulationSettings
from echoplan.simulation.simulation import Simulation

__all__ = ["OdometryNoise", "Simulation", "SimulationSettings"]

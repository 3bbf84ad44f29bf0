"""The pings of a schedule as the ray tracer wants them, and which bursts each of them can receive."""

from typing import NamedTuple

import numpy as np

from echoplan.acoustics import Air, plane_echo, reach
from echoplan.arrays import ComplexArray, FloatArray, IntArray
from echoplan.model import Transducer
from echoplan.simulation.module import Module
from echoplan.simulation.schedule import Schedule

__all__ = ["Shots", "build_shots", "memory_of"]


class Shots(NamedTuple):
    """Every ping is a burst, and listens to its own and to those before, with and soon after it.

    Attributes
    ----------
    instants : ndarray, shape (n,)
        Time of each burst [s].
    sensors : ndarray of int, shape (n,)
        Which sensor sends and listens.
    places, axes : ndarray of complex, shape (n,)
        Where it is [m] and where it looks, x + jy.
    velocities : ndarray of complex, shape (n,)
        How it moves [m/s].
    turns : ndarray, shape (n,)
        How it turns [rad/s].
    openings, deadlines : ndarray, shape (n,)
        From when until when it listens, after its own burst [s].
    first_burst, last_burst : ndarray of int, shape (n,)
        Range of the bursts that it may receive; the last is not among them.
    """

    instants: FloatArray
    sensors: IntArray
    places: ComplexArray
    axes: ComplexArray
    velocities: ComplexArray
    turns: FloatArray
    openings: FloatArray
    deadlines: FloatArray
    first_burst: IntArray
    last_burst: IntArray


def build_shots(schedule: Schedule, module: Module, *, memory: float | None) -> Shots:
    """Prepare a schedule for the ray tracer.

    Parameters
    ----------
    schedule : Schedule
        All pings.
    module : Module
        From when until when the sensors listen.
    memory : float or None
        How long a burst can be detected [s]; None if a ping receives only what is sent in the same instant.

    Returns
    -------
    Shots
        The same pings.
    """
    (x, y, yaw), (vx, vy, turn) = schedule.map_from_sensors.T, schedule.velocities.T
    instants = (schedule.stamps_ns - schedule.stamps_ns[0]) * 1e-9
    deadlines = module.deadlines(schedule.sensors)
    moment = 0.5e-9
    earliest = instants - (moment if memory is None else memory)
    latest = instants + (moment if memory is None else deadlines)
    return Shots(
        instants=instants,
        sensors=schedule.sensors,
        places=x + 1j * y,
        axes=np.exp(1j * yaw),
        velocities=vx + 1j * vy,
        turns=np.ascontiguousarray(turn),
        openings=module.openings(schedule.sensors),
        deadlines=deadlines,
        first_burst=np.searchsorted(instants, earliest),
        last_burst=np.searchsorted(instants, latest),
    )


def memory_of(transducer: Transducer, air: Air) -> float:
    """How long after a burst an aimed plane could still return it loud enough.

    Parameters
    ----------
    transducer : Transducer
        The transducer.
    air : Air
        What the sound travels in.

    Returns
    -------
    float
        Time [s].

    Examples
    --------
    >>> round(memory_of(Transducer(), Air()) * 1000)
    25
    """
    return 2 * reach(plane_echo, transducer=transducer, air=air) / air.speed_of_sound

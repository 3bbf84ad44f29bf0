"""A random flat on three days: each time another route and another frame of the odometry, and once a moved cupboard."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import Polygon

from echoplan.arrays import FloatArray
from echoplan.geometry import compose
from echoplan.io import builtin_rig
from echoplan.model import Sweep
from echoplan.simulation import Simulation, SimulationSettings
from library.flats import Flat, random_plan, thresholds_of, with_box
from library.rooms import ARRAY, DRIFT
from library.tours import find_route

__all__ = ["DAYS", "flat_on_days", "in_frame_of_odometry"]

DAYS = 3
# Pose of the frame of the map in that of the odometry on the second day [m, m, rad]; on the third day twice that.
_AWAY = np.array([0.3 * math.cos(2.0), 0.3 * math.sin(2.0), math.radians(20.0)])
# Flats that are tried for a seed.
_FLATS = 1000
# Stations that must be able to detect one face of the cupboard.
_STATIONS = 3
# Distance from the outline of a box within which a wall is a face of it [m].
_SAME = 0.01


def flat_on_days(seed: int) -> tuple[list[Simulation], tuple[FloatArray, FloatArray]]:
    """Simulate a flat on three days, of which the third finds a cupboard moved.

    Routes are drawn until enough stations see both places on the first and on the third day: what nobody looks at
    cannot be reported.

    Returns
    -------
    simulations : list of Simulation
        One per day, all in one frame.
    cupboard : tuple of ndarray, shape (4, 2)
        Corners of the cupboard on the first two days, and on the third [m].
    """
    rng = np.random.default_rng((seed, 19))
    for _ in range(_FLATS):
        flat = random_plan(rng, oblique=False)
        before, after = (_with_cupboard(flat, rng) for _ in range(2))
        if before is None or after is None or not _are_apart(before[1], after[1]):
            continue
        flats = (before[0], before[0], after[0])
        worlds = [each.world(f"flat {seed}") for each in flats]
        routes = [find_route(*both, rng) for both in zip(flats, worlds, strict=True)]
        simulations = [
            Simulation(
                world=world,
                rig=builtin_rig(ARRAY),
                route=route,
                settings=SimulationSettings(dropout=0.02, stray=0.02, odometry=DRIFT),
                seed=100 * seed + day,
            )
            for day, (world, route) in enumerate(zip(worlds, routes, strict=True))
            if route is not None
        ]
        if len(simulations) == DAYS and _show(simulations, before[1], after[1]):
            return simulations, (before[1], after[1])
    raise RuntimeError(f"seed {seed}: no route through any of {_FLATS} flats")


def _show(simulations: Sequence[Simulation], before: FloatArray, after: FloatArray) -> bool:
    """Return True if the recordings show both places, with the cupboard and without it."""
    first, _, third = simulations
    views = (
        (third, after),
        (first, before),
        (replace(third, world=first.world), before),
        (replace(first, world=third.world), after),
    )
    return all(_stations_in_view(*view) >= _STATIONS for view in views)


def _stations_in_view(simulation: Simulation, box: FloatArray) -> int:
    """Return the number of stations that detect a face of a box, of the face that most detect."""
    truth, outline = simulation.truth, Polygon(box).exterior
    faces = shapely.distance(shapely.points(truth.walls_xy.mean(axis=1)), outline) < _SAME
    return int(truth.walls_detected_by[faces].max(initial=0))


def in_frame_of_odometry(sweeps: Sequence[Sweep], *, day: int) -> tuple[Sweep, ...]:
    """Return the sweeps of a day with poses in a frame that is 0.3 m and 20 degrees off per day after the first."""
    away = np.zeros(3)
    for _ in range(day):
        away = compose(away, _AWAY)
    return tuple(replace(sweep, map_from_base=compose(away, sweep.map_from_base)) for sweep in sweeps)


def _with_cupboard(flat: Flat, rng: np.random.Generator) -> tuple[Flat, FloatArray] | None:
    """Put a box into the open of one of the rooms; None if there is no place."""
    for number in rng.permutation(len(flat.rooms)):
        room = flat.rooms[number]
        furnished = with_box(room, thresholds_of(flat.doors), rng, turned=0.0)
        if furnished is not room:
            rooms = tuple(furnished if each is room else each for each in flat.rooms)
            return replace(flat, rooms=rooms), furnished.boxes[-1].points_xy
    return None


def _are_apart(one: FloatArray, other: FloatArray) -> bool:
    """Return True if no face of one box lies where the other box stands or stood."""
    return bool(np.hypot(*(one.mean(axis=0) - other.mean(axis=0))) > 1.0)

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.atm import AtmMapper
from echoplan.geometry import directions
from echoplan.model import Sweep
from helpers import scenes

POINT = np.array([2.0, 1.0])
STATIONS = [(0.8, 1.1), (1.9, -0.2), (3.1, 0.6), (2.4, 2.2)]


def sweep_at(station: tuple[float, float], *, index: int = 0) -> Sweep:
    """What the array reads of a post: a constant range, wherever its beam covers the post."""
    bearings = np.radians(np.arange(360) - 45.0)
    away = POINT - station - scenes.ARM * directions(bearings)
    turns = np.arctan2(away[:, 1], away[:, 0]) - bearings
    detected = np.cos(turns) > np.cos(0.6)
    return scenes.sweep_of(np.where(detected, np.hypot(*away.T), np.inf), index=index, pose=(*station, 0.0))


def misses(points_xy: FloatArray) -> FloatArray:
    distances: FloatArray = np.hypot(*(points_xy - POINT).T)
    return distances


def test_crossings_sharpen_the_direction_of_a_post() -> None:
    mapper = AtmMapper(scenes.rig())
    for index, station in enumerate(STATIONS):
        mapper.add(sweep_at(station, index=index))
    middles = np.concatenate([loci.middles_xy for loci in mapper._loci])
    assert len(mapper.points_xy) == len(middles)
    assert misses(mapper.points_xy).max() < 1e-6
    assert np.median(misses(middles)) > 0.3


def test_one_station_alone_shows_nothing() -> None:
    mapper = AtmMapper(scenes.rig())
    mapper.add(sweep_at(STATIONS[0]))
    assert mapper.points_xy.shape == (0, 2)
    assert mapper.result().walls == ()

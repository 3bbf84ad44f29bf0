"""What every method must bear, beyond what it must find: few pings, faulty pings, one sensor, strange sensors."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.errors import UnknownNameError
from echoplan.methods import Mapper, Method, map_sweeps
from echoplan.model import FeatureMap, Sweep
from echoplan.simulation import Simulation

pytestmark = pytest.mark.slow

POSES = [[0.5, 0.5, 0.0], [1.0, 0.6, 0.5], [0.7, 1.2, 1.0], [1.4, 1.3, 1.5]]


def some(sweep: Sweep, chosen: slice) -> Sweep:
    """A part of a sweep."""
    return Sweep(
        index=sweep.index,
        stamps_ns=sweep.stamps_ns[chosen],
        sensor_ids=sweep.sensor_ids[chosen],
        servo_angles=sweep.servo_angles[chosen],
        ranges=sweep.ranges[chosen],
        map_from_base=sweep.map_from_base[chosen],
    )


def test_covariances_are_positive_definite(found: FeatureMap) -> None:
    covariances = [wall.covariance for wall in found.walls]
    covariances += [corner.covariance for corner in found.corners]
    covariances += [cylinder.covariance for cylinder in found.cylinders]
    assert all(np.linalg.eigvalsh(covariance).min() > 0 for covariance in covariances)


def test_walls_lie_on_their_lines(found: FeatureMap) -> None:
    assert found.walls
    for wall in found.walls:
        assert wall.endpoints_xy @ wall.normal_xy == pytest.approx(wall.offset, abs=1e-6)


@pytest.mark.usefixtures("found")
def test_points_lie_within_reach(mapper: Mapper) -> None:
    points = np.asarray(getattr(mapper, "points_xy", np.zeros((0, 2))))
    assert points.shape[1] == 2
    assert np.isfinite(points).all()
    assert (np.hypot(*(points - np.mean(POSES, axis=0)[:2]).T) < 3.0 + 1.0).all()


@pytest.mark.parametrize("reading", [np.nan, -np.inf, np.inf, 0.0, 99.0])
def test_readings_that_are_no_ranges_show_nothing(
    method: Method, cell: Simulation, sweeps: list[Sweep], reading: float
) -> None:
    faulty = [replace(sweep, ranges=np.full(len(sweep), reading)) for sweep in sweeps]
    empty = map_sweeps(method.build(cell.rig), faulty)
    assert (empty.walls, empty.corners, empty.cylinders) == ((), (), ())


@pytest.mark.parametrize("count", [0, 1, 2, 5, 12])
def test_a_few_pings_break_nothing(method: Method, cell: Simulation, sweeps: list[Sweep], count: int) -> None:
    few = [some(sweep, slice(count)) for sweep in sweeps]
    assert len(map_sweeps(method.build(cell.rig), few).poses) == (len(sweeps) if count else 0)


@pytest.mark.parametrize("poses", [POSES, [POSES[0]] * 4], ids=["several places", "one place"])
@pytest.mark.parametrize("count", [6, 91])
def test_equal_readings_break_nothing(
    method: Method, cell: Simulation, sweeps: list[Sweep], poses: list[list[float]], count: int
) -> None:
    # Coarse readings of a wall are a plateau: without an arm its nearest point may be anywhere.
    alone = replace(cell.rig, sensors=(replace(cell.rig.sensors[0], x=0.0, y=0.0),), firing=None)
    plateaus = [
        replace(
            some(sweep, slice(0, 4 * count, 4)), ranges=np.full(count, reading), map_from_base=np.tile(pose, (count, 1))
        )
        for sweep, pose, reading in zip(sweeps, poses, (0.59, 1.51, 0.59, 0.6), strict=True)
    ]
    assert len(map_sweeps(method.build(alone), plateaus).poses) == len(sweeps)


def test_many_sweeps_from_one_place_break_nothing(method: Method, cell: Simulation, sweeps: list[Sweep]) -> None:
    again = [
        replace(sweeps[0], index=number, stamps_ns=sweeps[0].stamps_ns + number * 10_000_000_000) for number in range(4)
    ]
    assert len(map_sweeps(method.build(cell.rig), again).poses) == len(again)


def test_one_sensor_is_enough(method: Method, cell: Simulation, sweeps: list[Sweep]) -> None:
    alone = replace(cell.rig, sensors=cell.rig.sensors[:1], firing=None)
    own = [some(sweep, slice(0, None, 4)) for sweep in sweeps]
    assert {int(sensor) for sweep in own for sensor in sweep.sensor_ids} == {0}
    assert len(map_sweeps(method.build(alone), own).poses) == len(sweeps)


def test_one_station_alone_breaks_nothing(method: Method, cell: Simulation, sweeps: list[Sweep]) -> None:
    assert len(map_sweeps(method.build(cell.rig), sweeps[:1]).poses) == 1


def test_a_sensor_that_the_rig_has_not_is_refused(method: Method, cell: Simulation, sweeps: list[Sweep]) -> None:
    strange = replace(sweeps[0], sensor_ids=sweeps[0].sensor_ids + 90)
    with pytest.raises(UnknownNameError, match="sensor id"):
        map_sweeps(method.build(cell.rig), [strange])

import numpy as np
import pytest

from echoplan.classical.iepf_kalman import IepfKalmanMapper, IepfKalmanSettings
from echoplan.model import CornerKind, Rig, Sensor, Sweep
from helpers import scenes

# A sensor that looks to the left of a robot, as on a ring.
SIDE = Rig(
    name="side",
    sensors=(Sensor(sensor_id=7, yaw=np.pi / 2, half_aperture=0.2, min_range=0.03, max_range=3.0, resolution=0.005),),
)


def passing(poses: list[tuple[float, float, float]], ranges: list[float]) -> list[Sweep]:
    return [
        Sweep(
            index=index,
            stamps_ns=np.array([index]),
            sensor_ids=np.array([7]),
            servo_angles=np.zeros(1),
            ranges=np.array([reading]),
            map_from_base=np.array([pose]),
        )
        for index, (pose, reading) in enumerate(zip(poses, ranges, strict=True))
    ]


def mapped(sweeps: list[Sweep], **settings: float) -> IepfKalmanMapper:
    mapper = IepfKalmanMapper(SIDE, IepfKalmanSettings.model_validate(settings))
    for sweep in sweeps:
        mapper.add(sweep)
    return mapper


def along_wall(*, noise: float = 0.0, back: bool = False) -> list[Sweep]:
    """A drive along y = 0 beside a wall at y = 1; and home again, farther from it."""
    rng = np.random.default_rng(1)
    poses = [(0.1 * step, 0.0, 0.0) for step in range(21)]
    if back:
        poses += [(2.0 - 0.1 * step, 0.4, 0.0) for step in range(21)]
    return passing(poses, [1.0 - y + rng.normal(0, noise) for _, y, _ in poses])


def test_a_drive_along_a_wall_gives_the_wall() -> None:
    (wall,) = mapped(along_wall()).result().walls
    assert (wall.normal_angle, wall.offset) == pytest.approx((np.pi / 2, 1.0))
    assert sorted(wall.endpoints_xy[:, 0]) == pytest.approx([0.0, 2.0])


def test_a_second_pass_makes_the_wall_surer() -> None:
    (once,) = mapped(along_wall(noise=0.004)).result().walls
    (twice,) = mapped(along_wall(noise=0.004, back=True), max_step=0.15).result().walls
    assert np.linalg.det(twice.covariance) < np.linalg.det(once.covariance)
    assert twice.offset == pytest.approx(1.0, abs=0.005)


def test_a_chain_is_split_at_the_farthest_point_into_walls_that_meet() -> None:
    # Past the corner of a box: along its face, and back along the next one with the robot turned.
    poses = [(0.1 * step, 0.0, 0.0) for step in range(11)]
    poses += [(2.0, 1.0 + 0.1 * step, np.pi / 2) for step in range(1, 11)]
    found = mapped(passing(poses, [1.0] * 21)).result()
    assert len(found.walls) == 2
    (corner,) = found.corners
    assert corner.position_xy == pytest.approx([1.0, 1.0], abs=1e-6)
    assert corner.kind is CornerKind.CONVEX


def test_lines_of_one_sweep_need_another() -> None:
    ranges = np.full(360, np.inf)
    ranges[30:60] = scenes.wall_ranges(np.radians(np.arange(-15, 15)), normal=0.0, distance=1.5)
    mapper = IepfKalmanMapper(scenes.rig(), IepfKalmanSettings(tolerance=0.1))
    mapper.add(scenes.sweep_of(ranges))
    assert mapper.result().walls == ()
    mapper.add(scenes.sweep_of(ranges, index=1))
    assert len(mapper.result().walls) == 1


def test_points_too_far_apart_are_no_chain() -> None:
    sweeps = along_wall()[::4]
    assert mapped(sweeps).result().walls == ()
    assert len(mapped(sweeps, max_step=0.5).result().walls) == 1

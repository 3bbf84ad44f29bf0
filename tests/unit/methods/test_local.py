"""Every mapper that the registry builds maps near the origin of its own frame, and refuses bad sweeps."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import EchoplanError
from echoplan.joint.map_extraction.segments import SegmentSettings
from echoplan.joint.mapper import JointSettings
from echoplan.methods import METHODS, Mapper, Method, grid_of, map_sweeps, observations_of, points_of
from echoplan.model import FeatureMap, Sweep
from echoplan.simulation import Simulation

pytestmark = pytest.mark.slow

# Multiples of 2^-6 m, so that positions far away are exact and a shifted recording is the same recording.
POSES = np.array([[0.5, 0.5, 0.0], [1.0, 0.625, 0.5], [0.75, 1.25, 1.0], [1.375, 1.25, 1.5]])
# A place in UTM coordinates [m].
FAR = np.array([500_000.0, 5_200_000.0])


def shifted(sweep: Sweep, by_xy: FloatArray) -> Sweep:
    return replace(sweep, map_from_base=sweep.map_from_base + np.append(by_xy, 0.0))


def about(found: FeatureMap, origin_xy: FloatArray) -> list[FloatArray]:
    """Everything that a map holds in metres and radians, seen from an origin."""
    walls = [each.endpoints_xy - origin_xy for each in found.walls]
    offsets = [np.array([each.normal_angle, each.offset - each.normal_xy @ origin_xy]) for each in found.walls]
    points = [each.position_xy - origin_xy for each in found.corners]
    circles = [np.array([*(each.center_xy - origin_xy), each.radius]) for each in found.cylinders]
    gaps = [each.endpoints_xy - origin_xy for each in found.openings]
    gaps += [each.endpoints_xy - origin_xy for each in found.unobserved]
    covariances = [each.covariance for each in found.corners] + [each.covariance for each in found.cylinders]
    return [*walls, *offsets, *points, *circles, *gaps, *covariances, found.poses[:, :2] - origin_xy]


def test_coordinates_of_a_country_change_nothing_but_the_frame(
    mapper: Mapper, found: FeatureMap, method: Method, cell: Simulation, sweeps: list[Sweep]
) -> None:
    there = method.build(cell.rig)
    far = map_sweeps(there, [shifted(sweep, FAR) for sweep in sweeps])
    for one, other in zip(about(found, np.zeros(2)), about(far, FAR), strict=True):
        assert other == pytest.approx(one, abs=1e-8)
    assert points_of(there) - FAR == pytest.approx(points_of(mapper), abs=1e-8)
    hubs = [np.array([each.point.hub_xy for each in observations_of(one)]).reshape(-1, 2) for one in (mapper, there)]
    assert hubs[1] - FAR == pytest.approx(hubs[0], abs=1e-8)
    grids = [grid_of(one) for one in (mapper, there)]
    if grids[0] is not None:
        assert grids[1] is not None
        assert grids[1].origin_xy - FAR == pytest.approx(grids[0].origin_xy, abs=1e-8)
        assert (grids[1].values == grids[0].values).all()


@pytest.mark.parametrize("driven", [True, False])
def test_the_path_of_the_robot_is_known_unless_it_may_have_driven_around_walls(
    cell: Simulation, sweeps: list[Sweep], *, driven: bool
) -> None:
    settings = JointSettings(segments=SegmentSettings(driven=driven))
    mapper = METHODS["joint"].build(cell.rig, settings)
    found = map_sweeps(mapper, [shifted(sweep, FAR) for sweep in sweeps])
    views, path = mapper.looks()
    assert path == pytest.approx(found.poses[: len(POSES) * driven, :2], abs=1e-6)
    assert len(views)
    assert (np.hypot(*(views[:, 0, None] - POSES[:, :2] - FAR).T).min(axis=0) < 0.1).all()


def test_a_wall_far_away_is_as_sure_as_it_is_near(
    found: FeatureMap, method: Method, cell: Simulation, sweeps: list[Sweep]
) -> None:
    shift = np.array([64.0, -128.0])
    far = map_sweeps(method.build(cell.rig), [shifted(sweep, shift) for sweep in sweeps])
    for one, other in zip(found.walls, far.walls, strict=True):
        # Offset = n . (p - shift): its derivative by the angle of n is the shift along the wall.
        along = np.array([-one.normal_xy[1], one.normal_xy[0]]) @ shift
        back = np.array([[1.0, 0.0], [-along, 1.0]])
        assert back @ other.covariance @ back.T == pytest.approx(one.covariance, rel=1e-6)


@pytest.fixture(scope="module")
def bad_sweeps(sweeps: list[Sweep]) -> dict[str, tuple[Sweep, str]]:
    """Sweeps that no mapper can take after the first two, and what is said about them."""
    third = sweeps[2]
    return {
        "unknown sensor": (replace(third, sensor_ids=np.full(len(third), 99)), "unknown sensor id '99'"),
        "index repeated": (replace(third, index=sweeps[1].index), "index of a sweep must increase, not go from 1 to 1"),
        "index going back": (replace(third, index=0), "index of a sweep must increase, not go from 1 to 0"),
        "time going back": (
            replace(third, stamps_ns=third.stamps_ns - third.stamps_ns[0]),
            "sweep 2 begins at 0 s, before sweep 1 ends",
        ),
    }


def test_bad_sweeps_are_refused_and_change_nothing(
    found: FeatureMap,
    method: Method,
    cell: Simulation,
    sweeps: list[Sweep],
    bad_sweeps: dict[str, tuple[Sweep, str]],
) -> None:
    disturbed = method.build(cell.rig)
    map_sweeps(disturbed, sweeps[:2])
    for bad, message in bad_sweeps.values():
        with pytest.raises(EchoplanError, match=message):
            disturbed.add(bad)
    again = map_sweeps(disturbed, sweeps[2:])
    for one, other in zip(about(found, np.zeros(2)), about(again, np.zeros(2)), strict=True):
        assert (one == other).all()


def test_a_bad_first_sweep_does_not_set_the_frame(
    method: Method, cell: Simulation, sweeps: list[Sweep], bad_sweeps: dict[str, tuple[Sweep, str]]
) -> None:
    mapper = method.build(cell.rig)
    with pytest.raises(EchoplanError, match="unknown sensor id"):
        mapper.add(shifted(bad_sweeps["unknown sensor"][0], FAR))
    assert len(map_sweeps(mapper, sweeps[:1]).poses) == 1


def test_a_sweep_without_pings_has_no_time_and_no_place(method: Method, cell: Simulation, sweeps: list[Sweep]) -> None:
    empty = Sweep(
        index=0,
        stamps_ns=np.zeros(0, dtype=np.int64),
        sensor_ids=np.zeros(0, dtype=np.int64),
        servo_angles=np.zeros(0),
        ranges=np.zeros(0),
        map_from_base=np.zeros((0, 3)),
    )
    mapper = method.build(cell.rig)
    mapper.add(empty)
    mapper.add(replace(sweeps[1], index=1))
    assert mapper.result().poses[-1] == pytest.approx(sweeps[1].station)


def test_a_sweep_that_is_refused_for_being_far_away_changes_nothing(
    method: Method, cell: Simulation, sweeps: list[Sweep]
) -> None:
    plain, disturbed = method.build(cell.rig), method.build(cell.rig)
    map_sweeps(plain, sweeps[:2])
    map_sweeps(disturbed, sweeps[:2])
    try:
        disturbed.add(shifted(sweeps[2], FAR))
    except EchoplanError:
        expected, found = about(plain.result(), np.zeros(2)), about(disturbed.result(), np.zeros(2))
        assert all((one == other).all() for one, other in zip(expected, found, strict=True))

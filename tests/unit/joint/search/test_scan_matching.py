import tracemalloc
from functools import cache

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import compose, directions, wrap
from echoplan.joint.arcs import ArcSettings, find_arcs
from echoplan.joint.search import scan_matching
from echoplan.joint.search.scan_matching import (
    LandmarkMap,
    LocalisationSettings,
    LocalScan,
    local_scans,
    locate,
    score_poses,
)
from helpers.expectations import ROOM, SONAR, corner, cylinder, landmark_map, listening, pings_of

COLUMN = cylinder(0.2, 0.9, 0.1)
SETTINGS = LocalisationSettings()
SIGMAS = np.array([0.03, 0.03, np.radians(3.0)])
HERE = np.array([0.4, -0.3, 0.5])


def room(*more: FloatArray) -> LandmarkMap:
    return landmark_map(np.array([*ROOM, *more]))


def sight_from(pose: FloatArray) -> LocalScan:
    """Return the arcs of the four walls and the column from a pose."""
    depths, normals = [], []
    for row in [*ROOM, COLUMN]:
        if row[0] == Kind.WALL:
            depths.append(row[2] - float(pose[:2] @ directions(row[1])))
            normals.append(row[1] - pose[2])
        else:
            away = row[1:3] - pose[:2]
            depths.append(float(np.hypot(*away)) - row[3])
            normals.append(float(np.arctan2(away[1], away[0])) - pose[2])
    return LocalScan(np.zeros((5, 2)), wrap(normals), np.array(depths), np.ones(5))


@cache
def detected() -> LocalScan:
    """Return the arcs of one simulated station at the origin of its own frame."""
    measurements = pings_of(listening([(0.4, -0.3)], step=np.radians(1.0)), [*ROOM, COLUMN])
    arcs = find_arcs(measurements, resolution=0.001, settings=ArcSettings())
    return local_scans(arcs, measurements, SONAR.tabulated(), np.array([0.4, -0.3, 0.0]))


@pytest.mark.parametrize("error", [(0.05, 0.0, 0.0), (0.0, -0.06, 0.0), (0.0, 0.0, 0.12), (-0.04, 0.05, -0.1)])
def test_a_pose_is_recovered(error: tuple[float, float, float]) -> None:
    guess = compose(HERE, np.array(error))
    pose, score = locate(sight_from(HERE), room(COLUMN), guess, SIGMAS, SETTINGS)
    assert pose[:2] == pytest.approx(HERE[:2], abs=0.01)
    assert np.degrees(abs(wrap(pose[2] - HERE[2]))) < 0.7
    assert score > 5.0


@pytest.mark.parametrize("turn", [-0.5, -0.3, -0.13, 0.08, 0.22, 0.41])
def test_a_large_turn_is_recovered_with_arcs_of_distant_origins(turn: float) -> None:
    away = [(0.0, 0.0), (1.6, 0.3), (-1.4, 1.0)]
    sights = [sight_from(compose(HERE, np.array([*place, 0.0]))) for place in away]
    together = LocalScan(
        np.repeat(away, 5, axis=0),
        np.concatenate([each.normals for each in sights]),
        np.concatenate([each.depths for each in sights]),
        np.ones(15),
    )
    guess, sigmas = compose(HERE, np.array([0.02, -0.02, turn])), np.array([0.03, 0.03, np.radians(17.0)])
    pose, _ = locate(together, room(COLUMN), guess, sigmas, SETTINGS)
    assert pose[:2] == pytest.approx(HERE[:2], abs=0.01)
    assert np.degrees(abs(wrap(pose[2] - HERE[2]))) < 0.7


def test_without_landmarks_the_predicted_pose_is_kept() -> None:
    empty = landmark_map(np.zeros((0, 4)))
    pose, score = locate(sight_from(HERE), empty, HERE, SIGMAS, SETTINGS)
    assert pose == pytest.approx(HERE)
    assert score == 0.0


def test_without_arcs_the_predicted_pose_is_kept() -> None:
    deaf = LocalScan(np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0))
    pose, score = locate(deaf, room(), HERE, SIGMAS, SETTINGS)
    assert pose == pytest.approx(HERE)
    assert score == 0.0


def test_a_single_wall_fixes_distance_and_heading_but_not_the_place_along_it() -> None:
    scan = sight_from(HERE)
    only = LocalScan(scan.origins_xy[:1], scan.normals[:1], scan.depths[:1], scan.weights[:1])
    guess = compose(HERE, np.array([0.04, 0.04, 0.05]))
    pose, _ = locate(only, landmark_map(ROOM[:1]), guess, SIGMAS, SETTINGS)
    assert pose[0] == pytest.approx(HERE[0], abs=0.01)
    assert abs(pose[1] - guess[1]) < 0.01


def test_a_corner_is_matched_only_from_the_directions_in_which_it_was_detected() -> None:
    at = corner(2.0, 1.5)
    away = at[1:3] - HERE[:2]
    bearing = float(np.arctan2(away[1], away[0]))
    scan = LocalScan(np.zeros((1, 2)), np.array([bearing - HERE[2]]), np.array([np.hypot(*away)]), np.ones(1))
    alone = landmark_map(at[None])
    seen, behind = (alone._replace(fronts=np.array([[wrap(bearing + turn), np.pi / 4]])) for turn in (np.pi + 0.7, 0.7))
    scores = [
        score_poses(scan, each, poses=HERE[None], tolerances=(0.01, 0.02), settings=SETTINGS)[0]
        for each in (alone, seen, behind)
    ]
    assert scores[1] == pytest.approx(scores[0])
    assert scores[0] > 3.0
    assert scores[2] == 0.0


def test_outlying_arcs_do_not_move_the_pose() -> None:
    scan = sight_from(HERE)
    strays = LocalScan(
        np.zeros((8, 2)),
        np.append(scan.normals, [0.3, -1.2, 2.0]),
        np.append(scan.depths, [0.7, 0.9, 1.1]),
        np.ones(8),
    )
    pose, _ = locate(strays, room(COLUMN), compose(HERE, np.array([0.04, -0.04, 0.08])), SIGMAS, SETTINGS)
    assert pose[:2] == pytest.approx(HERE[:2], abs=0.012)


def test_arcs_do_not_match_a_wall_far_beyond_its_ends() -> None:
    short = room()._replace(extents=np.tile([5.0, 6.0], (4, 1)))
    guess = compose(HERE, np.array([0.04, 0.0, 0.0]))
    pose, _ = locate(sight_from(HERE), short, guess, SIGMAS, SETTINGS)
    assert pose == pytest.approx(guess, abs=1e-9)


def test_arcs_become_planes_about_the_robot() -> None:
    scan = detected()
    assert len(scan.depths) == 5
    for normal, depth in ((0.0, 1.6), (np.pi / 2, 1.8), (np.pi, 2.4), (-np.pi / 2, 1.2)):
        nearest = int(np.argmin(np.abs(wrap(scan.normals - normal))))
        assert np.degrees(abs(wrap(scan.normals[nearest] - normal))) < 0.5
        away = scan.depths[nearest] + float(scan.origins_xy[nearest] @ directions(normal))
        assert away == pytest.approx(depth, abs=0.004)


def test_simulated_arcs_recover_the_pose() -> None:
    here = np.array([0.4, -0.3, 0.0])
    pose, _ = locate(detected(), room(COLUMN), compose(here, np.array([0.05, -0.04, 0.06])), SIGMAS, SETTINGS)
    assert pose[:2] == pytest.approx(here[:2], abs=0.012)
    assert np.degrees(abs(wrap(pose[2]))) < 1.0


def test_a_sweep_without_arcs_gives_an_empty_scan() -> None:
    measurements = listening([(0.0, 0.0)])
    assert len(local_scans([], measurements, SONAR.tabulated(), np.zeros(3)).depths) == 0


@pytest.mark.parametrize("seed", range(8))
def test_restricting_matches_to_likely_landmarks_loses_nothing(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng, scan = np.random.default_rng(seed), sight_from(HERE)
    # Arcs of distant origins, as of other stations, and a pose error at the limit of the search.
    origins = np.concatenate([rng.uniform(-1.5, 1.5, (4, 2)), np.zeros((1, 2))])
    depths = scan.depths - (origins * directions(scan.normals)).sum(axis=1)
    scan, sigmas = scan._replace(origins_xy=origins, depths=depths), 3.0 * SIGMAS
    guess = compose(HERE, 2.8 * sigmas * rng.choice([-1.0, 1.0], 3))
    pose, score = locate(scan, room(COLUMN), guess, sigmas, SETTINGS)
    monkeypatch.setattr(scan_matching, "_likely", lambda *_: np.ones((5, 5), dtype=bool))
    everywhere, best = locate(scan, room(COLUMN), guess, sigmas, SETTINGS)
    assert pose == pytest.approx(everywhere, abs=1e-12)
    assert score == pytest.approx(best, abs=1e-9)


def test_a_sensor_far_from_its_robot_costs_no_more_memory() -> None:
    scan = sight_from(HERE)
    far = scan._replace(origins_xy=scan.origins_xy + 1e5)
    tracemalloc.start()
    try:
        locate(far, room(COLUMN), HERE, SIGMAS, SETTINGS)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 50e6

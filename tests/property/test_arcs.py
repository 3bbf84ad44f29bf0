"""Laws of arcs: crossings, medians, votes, carving and thinning, whatever the arcs."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from echoplan.arrays import FloatArray
from echoplan.classical.features.ballots import Ballot
from echoplan.classical.loci import (
    Loci,
    MedianSettings,
    ReflectorKind,
    TriangulationSettings,
    VoteSettings,
    arc_map,
    directional_maxima,
    find_crossings,
    find_reflectors,
    transversal_medians,
    triangulate,
)
from echoplan.classical.loci.carving import carve, longest_runs, sample_turns
from echoplan.geometry import compose, directions, transform_points

SEEDS = st.integers(0, 10_000)
POSES = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-3, 3))


def some_arcs(seed: int, *, count: int = 40) -> Loci:
    """Arcs anywhere in a room, six to a sweep."""
    rng = np.random.default_rng(seed)
    return Loci(
        centers_xy=rng.uniform(0, 3, size=(count, 2)),
        ranges=rng.uniform(0.2, 2.5, size=count),
        bearings=rng.uniform(-np.pi, np.pi, size=count),
        half_apertures=rng.uniform(0.1, 0.6, size=count),
        sweeps=np.arange(count) // 6,
    )


def moved(loci: Loci, pose: tuple[float, float, float]) -> Loci:
    """The same arcs seen from elsewhere."""
    poses = compose(pose, np.column_stack([loci.centers_xy, loci.bearings]))
    return Loci(
        centers_xy=poses[:, :2],
        ranges=loci.ranges,
        bearings=poses[:, 2],
        half_apertures=loci.half_apertures,
        sweeps=loci.sweeps,
    )


def widened(loci: Loci, factor: float) -> Loci:
    """The same arcs in a world of another size."""
    return Loci(
        centers_xy=factor * loci.centers_xy,
        ranges=factor * loci.ranges,
        bearings=loci.bearings,
        half_apertures=loci.half_apertures,
        sweeps=loci.sweeps,
    )


def crossing_angles(first: Loci, second: Loci, points_xy: FloatArray) -> FloatArray:
    """Angles between the radii of two arcs in their crossings [rad]."""
    radii = [points_xy - loci.centers_xy for loci in (first, second)]
    cosines = np.sum(radii[0] * radii[1], axis=1) / first.ranges / second.ranges
    angles: FloatArray = np.arccos(np.clip(cosines, -1, 1))
    return angles


@given(SEEDS, st.floats(0.05, 1.4))
def test_crossings_lie_on_both_arcs_and_are_transversal(seed: int, min_angle: float) -> None:
    loci = some_arcs(seed)
    crossings = find_crossings(loci, loci, min_angle=min_angle)
    one, other = loci[crossings.first], loci[crossings.second]
    for arc in (one, other):
        np.testing.assert_allclose(np.hypot(*(crossings.points_xy - arc.centers_xy).T), arc.ranges, atol=1e-6)
        assert (np.abs(arc.turns(crossings.points_xy)) <= arc.half_apertures + 1e-6).all()
    angles = crossing_angles(one, other, crossings.points_xy)
    assert (np.minimum(angles, np.pi - angles) >= min_angle - 1e-6).all()


@settings(max_examples=15)
@given(SEEDS)
def test_every_transversal_crossing_of_two_arcs_is_found(seed: int) -> None:
    loci = some_arcs(seed, count=12)
    turns = sample_turns(loci, 4001)
    points = loci.points_xy(turns)
    found = find_crossings(loci, loci, min_angle=0.2)
    pairs = set(zip(found.first.tolist(), found.second.tolist(), strict=True))
    for first in range(12):
        for second in range(first + 1, 12):
            away = points[first] - loci.centers_xy[second]
            gap = np.hypot(*away.T) - loci.ranges[second]
            beside = np.arctan2(away[:, 1], away[:, 0]) - loci.bearings[second]
            inside = np.cos(beside) > np.cos(loci.half_apertures[second]) + 1e-3
            crossed = np.flatnonzero((gap[:-1] * gap[1:] < 0) & inside[:-1] & inside[1:])
            angles = crossing_angles(
                loci[np.full(len(crossed), first)], loci[np.full(len(crossed), second)], points[first][crossed]
            )
            steep = np.minimum(angles, np.pi - angles) > 0.22
            assert not steep.any() or (first, second) in pairs


@given(SEEDS, POSES)
def test_medians_turn_and_move_with_the_arcs(seed: int, pose: tuple[float, float, float]) -> None:
    loci, rules = some_arcs(seed, count=80), MedianSettings()
    here, there = (transversal_medians(each, each, rules) for each in (loci, moved(loci, pose)))
    assert here.arcs.tolist() == there.arcs.tolist()
    np.testing.assert_allclose(here.turns, there.turns, atol=1e-6)


@given(SEEDS)
def test_a_median_lies_between_the_crossings_of_its_arc(seed: int) -> None:
    loci, rules = some_arcs(seed, count=60), MedianSettings()
    crossings = find_crossings(loci, loci, min_angle=rules.min_angle)
    turns = loci[crossings.first].turns(crossings.points_xy)
    medians = transversal_medians(loci, loci, rules)
    for arc, median in zip(medians.arcs, medians.turns, strict=True):
        assert np.isclose(median, np.median(turns[crossings.first == arc]))


@given(SEEDS)
def test_triangulated_points_have_the_witnesses_that_they_count(seed: int) -> None:
    loci = some_arcs(seed, count=120)
    newest, earlier, rules = loci[:20], loci[20:], TriangulationSettings(gate=0.2)
    found = triangulate(newest, earlier, rules)
    crossings = find_crossings(newest, earlier, min_angle=rules.min_angle)
    for point, count in zip(found.points_xy, found.counts, strict=True):
        near = np.hypot(*(crossings.points_xy - point).T) <= rules.gate
        assert len(np.unique(earlier.sweeps[crossings.second[near]])) >= count >= rules.min_sweeps


@given(SEEDS)
def test_carving_only_takes_and_never_twice(seed: int) -> None:
    loci = some_arcs(seed)
    points = loci.points_xy(sample_turns(loci, 15))
    whole = np.ones((len(loci), 15), dtype=bool)
    once = carve(points, whole, loci[:10], margin=0.05)
    assert (carve(points, once, loci[:10], margin=0.05) == once).all()
    both = carve(points, once, loci[10:], margin=0.05)
    assert (both <= once).all()
    assert (both == carve(points, whole, loci, margin=0.05)).all()


@given(SEEDS)
def test_a_wider_margin_carves_less(seed: int) -> None:
    loci = some_arcs(seed)
    points, whole = loci.points_xy(sample_turns(loci, 15)), np.ones((len(loci), 15), dtype=bool)
    narrow, wide = (carve(points, whole, loci, margin=margin) for margin in (0.02, 0.3))
    assert (narrow <= wide).all()


@given(SEEDS)
def test_carving_is_what_geometry_says(seed: int) -> None:
    loci = some_arcs(seed)
    points, whole = loci.points_xy(sample_turns(loci, 15)), np.ones((len(loci), 15), dtype=bool)
    away = points[:, :, None] - loci.centers_xy
    depths = np.hypot(away[..., 0], away[..., 1])
    ahead = np.sum(away * directions(loci.bearings), axis=-1)
    free = (depths < loci.ranges - 0.05) & (ahead > 0) & (ahead >= depths * np.cos(loci.half_apertures))
    assert (carve(points, whole, loci, margin=0.05) == ~free.any(axis=2)).all()


@given(SEEDS)
def test_the_longest_run_is_left_whole(seed: int) -> None:
    left = np.random.default_rng(seed).random((30, 9)) < 0.5
    turns = np.tile(np.arange(9.0), (30, 1))
    runs = longest_runs(left, turns)
    assert runs.arcs.tolist() == np.flatnonzero(left.any(axis=1)).tolist()
    for arc, middle, width in zip(runs.arcs, runs.turns, runs.widths, strict=True):
        inside = np.abs(turns[arc] - middle) < width / 2
        assert left[arc][inside].all()
        assert inside.sum() == width


@given(SEEDS)
def test_no_cell_counts_more_arcs_than_there_are(seed: int) -> None:
    loci = some_arcs(seed)
    cells = arc_map(loci, resolution=0.05)
    assert cells.counts.max() <= len(loci)
    # An arc passes through about as many cells as it is long, and never through more than its two shadows have.
    lengths = 2 * loci.ranges * loci.half_apertures / 0.05
    assert 0.6 * lengths.sum() <= cells.counts.sum() <= 1.5 * lengths.sum() + 2 * len(loci)


@given(SEEDS, st.integers(1, 12))
def test_each_line_of_each_direction_keeps_one_cell_and_a_densest(seed: int, count: int) -> None:
    cells = arc_map(some_arcs(seed), resolution=0.05)
    leads = directional_maxima(cells, count=count, resolution=0.05)
    lines = [
        len(np.unique(np.floor(cells.points_xy @ directions(np.pi * number / count + np.pi / 2) / 0.05)))
        for number in range(count)
    ]
    assert leads.sum() == sum(lines)
    assert leads[cells.counts == cells.counts.max()].max() == count


@given(SEEDS, POSES)
def test_reflectors_move_with_the_arcs_that_touch_them(seed: int, pose: tuple[float, float, float]) -> None:
    stations = np.random.default_rng(seed).uniform(-0.6, 0.6, size=(5, 2))
    wall = Loci(
        centers_xy=stations,
        ranges=2.0 - stations[:, 0],
        bearings=np.array([-0.2, -0.1, 0.0, 0.1, 0.2]),
        half_apertures=np.full(5, 0.4),
        sweeps=np.arange(5),
    )
    found = find_reflectors(moved(wall, pose), VoteSettings(offset_step=0.1))
    face = transform_points(pose, np.array([[2.0, -0.5], [2.0, 0.5]]))
    (line,) = [each for each in found if each.kind is ReflectorKind.LINE]
    assert line.members.tolist() == [0, 1, 2, 3, 4]
    np.testing.assert_allclose(face @ directions(line.parameters[0]), line.parameters[1], atol=1e-6)


@given(SEEDS, st.floats(0.5, 4.0))
def test_crossings_grow_with_the_world(seed: int, factor: float) -> None:
    loci = some_arcs(seed)
    small, large = (find_crossings(each, each, min_angle=0.3) for each in (loci, widened(loci, factor)))
    assert len(small.first) == len(large.first)
    np.testing.assert_allclose(factor * small.points_xy, large.points_xy, atol=1e-6)


@given(SEEDS)
def test_a_ballot_counts_as_one_would_by_hand(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cells, weights = rng.integers(-5, 5, size=(20, 3)), rng.integers(1, 5, size=20).astype(np.float64)
    gone = rng.permutation(20)[:7]
    ballot = Ballot(cells, weights)
    ballot.withdraw(gone)
    weights[gone] = 0
    tally = {cell: float(weights @ (cells == cell).sum(axis=1)) for cell in np.unique(cells).tolist()}
    cell, votes = ballot.leader()
    assert votes == max(tally.values()) == tally[cell]
    assert set(ballot.voters(cell).tolist()) == set(np.flatnonzero((cells == cell).any(axis=1) & (weights > 0)))

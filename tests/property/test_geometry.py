import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from echoplan.arrays import FloatArray
from echoplan.geometry import (
    along,
    circular_mean,
    compose,
    crosses_discs,
    crosses_segments,
    directions,
    distances_to_segments,
    feet,
    identity,
    intersections,
    invert,
    lines_through,
    signed_distances,
    transform_points,
    wrap,
)

# A house, and a hundred turns of the servo; values below rounding are zero.
metres = st.floats(-30, 30).map(lambda value: round(value, 6))
angles = st.floats(-600, 600)
points = arrays(np.float64, (4, 2), elements=metres)
segments = arrays(np.float64, (3, 2, 2), elements=metres)
poses = st.builds(lambda x, y, yaws: np.stack([x, y, yaws], axis=-1), *[arrays(np.float64, 4, elements=metres)] * 2,
                  arrays(np.float64, 4, elements=angles))  # fmt: skip
lines = st.builds(lambda angle, offset: np.array([angle, offset]), angles, metres)


def same_poses(first: FloatArray, second: FloatArray) -> bool:
    near = np.allclose(first[..., :2], second[..., :2], atol=1e-9)
    return near and np.allclose(directions(first[..., 2]), directions(second[..., 2]), atol=1e-9)


@given(poses, poses, poses)
def test_composition_is_associative(a: FloatArray, b: FloatArray, c: FloatArray) -> None:
    assert same_poses(compose(compose(a, b), c), compose(a, compose(b, c)))


@given(poses)
def test_the_identity_and_the_inverse_are_those_of_a_group(pose: FloatArray) -> None:
    assert same_poses(compose(identity(), pose), pose)
    assert same_poses(compose(pose, identity()), pose)
    assert same_poses(compose(pose, invert(pose)), identity())
    assert same_poses(compose(invert(pose), pose), identity())


@given(poses, poses, points)
def test_to_chain_poses_is_to_move_points_twice(a: FloatArray, b: FloatArray, xy: FloatArray) -> None:
    assert np.allclose(transform_points(compose(a, b), xy), transform_points(a, transform_points(b, xy)), atol=1e-9)


@given(poses, points)
def test_a_pose_keeps_distances(pose: FloatArray, xy: FloatArray) -> None:
    moved = transform_points(pose[0], xy)
    assert np.allclose(np.hypot(*(moved - moved[::-1]).T), np.hypot(*(xy - xy[::-1]).T), atol=1e-9)


@given(angles)
def test_wrapping_keeps_the_direction_within_one_turn_and_does_nothing_twice(angle: float) -> None:
    wrapped = wrap(angle)
    assert -np.pi <= wrapped < np.pi
    assert np.allclose(directions(wrapped), directions(angle), atol=1e-12)
    assert wrap(wrapped) == wrapped


@given(st.integers(-500, 500), st.integers(-3, 3))
def test_wrapped_angles_keep_their_bounds_near_every_seam(turns: int, steps: int) -> None:
    seam = (2 * turns + 1) * np.pi
    beside = seam + steps * np.spacing(abs(seam))
    assert -np.pi <= wrap(beside) < np.pi


@given(arrays(np.float64, 3, elements=st.floats(-1.5, 1.5)), angles)
def test_the_mean_direction_turns_with_the_directions(offsets: FloatArray, turn: float) -> None:
    mean = circular_mean(offsets)
    assert offsets.min() - 1e-9 <= mean <= offsets.max() + 1e-9
    assert np.allclose(directions(circular_mean(offsets + turn)), directions(mean + turn), atol=1e-9)


@given(points, points)
def test_a_line_goes_through_the_points_that_made_it_and_runs_from_the_first_to_the_second(
    starts: FloatArray, ends: FloatArray
) -> None:
    lengths = np.hypot(*(ends - starts).T)
    assume((lengths > 1e-3).all())
    made = lines_through(starts, ends)
    assert np.allclose(signed_distances(made, starts), 0, atol=1e-9)
    assert np.allclose(signed_distances(made, ends), 0, atol=1e-9)
    assert np.allclose(along(made, ends) - along(made, starts), lengths, atol=1e-9)


@given(lines, points)
def test_a_foot_lies_on_the_line_straight_below_the_point(line: FloatArray, xy: FloatArray) -> None:
    below = feet(line, xy)
    assert np.allclose(signed_distances(line, below), 0, atol=1e-9)
    assert np.allclose(along(line, below), along(line, xy), atol=1e-9)
    assert np.allclose(np.hypot(*(xy - below).T), np.abs(signed_distances(line, xy)), atol=1e-9)
    assert np.allclose(feet(line, below), below, atol=1e-9)


@given(lines, lines)
def test_lines_cross_in_one_point_of_both_whichever_comes_first(first: FloatArray, second: FloatArray) -> None:
    assume(abs(np.sin(first[0] - second[0])) > 1e-3)
    crossing = intersections(first, second)
    assert np.allclose([signed_distances(line, crossing) for line in (first, second)], 0, atol=1e-7)
    assert np.allclose(intersections(second, first), crossing, atol=1e-7)


@given(lines, points)
def test_a_line_is_the_same_by_either_of_its_normals(line: FloatArray, xy: FloatArray) -> None:
    other = np.array([line[0] + np.pi, -line[1]])
    assert np.allclose(signed_distances(other, xy), -signed_distances(line, xy), atol=1e-9)
    assert np.allclose(feet(other, xy), feet(line, xy), atol=1e-9)


@given(poses, points, segments)
def test_distances_from_segments_move_with_the_room(pose: FloatArray, xy: FloatArray, faces: FloatArray) -> None:
    moved = distances_to_segments(transform_points(pose[0], xy), transform_points(pose[0], faces))
    assert np.allclose(moved, distances_to_segments(xy, faces), atol=1e-6)


@given(points, segments)
def test_no_point_of_a_segment_is_nearer_than_its_distance(xy: FloatArray, faces: FloatArray) -> None:
    shares = np.linspace(0, 1, 7)[:, None, None]
    on_faces = (1 - shares) * faces[:, 0] + shares * faces[:, 1]
    sampled = np.linalg.norm(xy[None, :, None] - on_faces[:, None], axis=-1).min(axis=0)
    distances = distances_to_segments(xy, faces)
    assert (distances <= sampled + 1e-9).all()
    assert (sampled - distances <= np.linalg.norm(faces[:, 1] - faces[:, 0], axis=-1) / 12 + 1e-9).all()


@given(poses, points, points, segments)
def test_occlusion_moves_with_the_room_and_is_symmetric(
    pose: FloatArray, eyes: FloatArray, targets: FloatArray, faces: FloatArray
) -> None:
    crossed = crosses_segments(eyes, targets, faces)
    ends = [distances_to_segments(faces.reshape(-1, 2), np.stack([eyes, targets], axis=1)).min(),
            distances_to_segments(np.concatenate([eyes, targets]), faces).min()]  # fmt: skip
    assume(min(ends) > 1e-6)  # a graze is decided by rounding
    assert np.array_equal(crosses_segments(targets, eyes, faces), crossed)
    moved = [transform_points(pose[0], xy) for xy in (eyes, targets, faces)]
    assert np.array_equal(crosses_segments(*moved), crossed)


@given(poses, points, points, arrays(np.float64, (3, 3), elements=st.floats(0.01, 5)))
def test_what_a_disc_hides_moves_with_the_room(
    pose: FloatArray, eyes: FloatArray, targets: FloatArray, discs: FloatArray
) -> None:
    clearance = distances_to_segments(discs[:, :2], np.stack([eyes, targets], axis=1)).T - discs[:, 2]
    assume(np.abs(clearance).min() > 1e-6)
    moved = np.column_stack([transform_points(pose[0], discs[:, :2]), discs[:, 2]])
    crossed = crosses_discs(transform_points(pose[0], eyes), transform_points(pose[0], targets), moved)
    assert np.array_equal(crossed, crosses_discs(eyes, targets, discs))
    assert np.array_equal(crossed, clearance < 0)

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from echoplan.arrays import FloatArray
from echoplan.evaluation import Consistency, evaluate
from echoplan.evaluation.consistency import nees, pool_consistency, wall_error
from echoplan.geometry import directions
from echoplan.model import FeatureClass, FeatureMap, Wall, translated_wall
from helpers import maps

# The line 3x + 4y = 10 from (2, 1) to (-2, 4).
TRUE_ENDS = np.array([[2.0, 1.0], [-2.0, 4.0]])
ANGLE = float(np.arctan2(4.0, 3.0))


def line(normal_angle: float, offset: float) -> Wall:
    return Wall(normal_angle=normal_angle, offset=offset, endpoints_xy=TRUE_ENDS, covariance=np.eye(2))


def consistency(values: list[float], parameters: int = 2) -> Consistency:
    return Consistency(parameters=parameters, nees=np.array(values))


def test_the_error_of_a_line_is_in_angle_and_offset() -> None:
    assert wall_error(line(ANGLE + 0.02, 2.05), TRUE_ENDS) == pytest.approx([0.02, 0.05])


@pytest.mark.parametrize("ends", [TRUE_ENDS, TRUE_ENDS[::-1]])
@pytest.mark.parametrize("turns", [-1, 0, 1])
def test_a_line_with_the_opposite_normal_has_the_same_error_with_the_other_sign_of_offset(
    ends: FloatArray, turns: int
) -> None:
    angle = ANGLE + 0.02 + 2 * np.pi * turns
    assert wall_error(line(angle, 2.05), ends) == pytest.approx([0.02, 0.05])
    assert wall_error(line(angle + np.pi, -2.05), ends) == pytest.approx([0.02, -0.05])


def test_the_nearer_normal_is_taken_up_to_a_quarter_turn() -> None:
    assert wall_error(line(ANGLE + 1.5, 2.05), TRUE_ENDS) == pytest.approx([1.5, 0.05])
    assert wall_error(line(ANGLE + 1.6, -2.05), TRUE_ENDS) == pytest.approx([1.6 - np.pi, -0.05])


def test_errors_count_against_their_covariance() -> None:
    # Inverse of [[4, 2], [2, 3]] is [[3, -2], [-2, 4]] / 8; of (1, 2): (3 - 8 + 16) / 8.
    assert nees([1.0, 2.0], np.array([[4.0, 2.0], [2.0, 3.0]])) == pytest.approx(11 / 8)


def test_units_of_very_different_size_do_not_matter() -> None:
    scale = np.diag([1e-7, 1.0])
    covariance = scale @ np.array([[4.0, 2.0], [2.0, 3.0]]) @ scale
    assert nees([1e-7, 2.0], covariance) == pytest.approx(11 / 8)


@pytest.mark.parametrize("covariance", [np.zeros((2, 2)), np.diag([1.0, 0.0]), np.ones((2, 2))])
def test_a_covariance_without_meaning_gives_no_number(covariance: FloatArray) -> None:
    assert np.isnan(nees([0.1, 0.1], covariance))


def test_each_class_is_compared_with_its_own_number_of_parameters() -> None:
    # Every error is two standard deviations of one parameter, but for the cylinder's, of all three.
    wall = maps.wall((1, 0.02), (3, 0.02), covariance=np.diag([1e-4, 1e-4]))
    corner = maps.corner((5.02, 0.0), sigma=0.01)
    cylinder = maps.cylinder((3.52, 0.58), 0.12, sigma=0.01)
    found = evaluate(maps.drawn(wall, corner, cylinder), maps.ROOM).consistency
    assert {name: each.parameters for name, each in found.items()} == {"wall": 2, "corner": 2, "cylinder": 3}
    assert found[FeatureClass.WALL].nees == pytest.approx([4.0])
    assert found[FeatureClass.CORNER].nees == pytest.approx([4.0])
    assert found[FeatureClass.CYLINDER].nees == pytest.approx([12.0])


def test_features_without_a_covariance_are_left_out() -> None:
    walls = maps.wall((1, 0), (3, 0), covariance=np.zeros((2, 2))), maps.wall((5, 0.2), (5, 1.0))
    found = evaluate(maps.drawn(*walls), maps.ROOM).consistency[FeatureClass.WALL]
    assert found.nees == pytest.approx([0.0], abs=1e-9)


def test_the_ellipse_is_that_of_the_chi_square_distribution() -> None:
    inside, outside = chi2.ppf([0.9499, 0.9501], 2)
    assert consistency([inside, outside, outside, outside]).share_inside == 0.25
    inside, outside = chi2.ppf([0.9499, 0.9501], 3)
    assert consistency([inside, outside], parameters=3).share_inside == 0.5


def test_a_mean_is_accepted_within_the_quantiles_of_the_sum() -> None:
    pooled = consistency([1.0, 2.0, 4.5])
    assert pooled.mean == 2.5
    assert pooled.accepted == pytest.approx(chi2.ppf([0.025, 0.975], 6) / 3)


def test_without_features_the_consistency_is_unknown() -> None:
    nothing = consistency([])
    assert np.isnan([nothing.mean, nothing.share_inside, *nothing.accepted]).all()


def test_features_of_several_maps_are_pooled() -> None:
    pooled = pool_consistency([consistency([1.0]), consistency([]), consistency([2.0, 3.0])], parameters=2)
    assert pooled.nees.tolist() == [1.0, 2.0, 3.0]
    assert pool_consistency([], parameters=3).nees.shape == (0,)


def test_walls_drawn_from_their_own_covariance_are_consistent_and_overconfident_ones_are_not() -> None:
    rng = np.random.default_rng(2)
    sigmas = np.diag([0.01, 0.008])
    covariance = sigmas @ np.array([[1.0, -0.7], [-0.7, 1.0]]) @ sigmas
    honest, bold = [], []
    for angle, offset in rng.multivariate_normal([ANGLE, 2.0], covariance, size=400):
        error = wall_error(line(angle, offset), TRUE_ENDS)
        honest.append(nees(error, covariance))
        bold.append(nees(error, covariance / 4))
    low, high = consistency(honest).accepted
    assert low < consistency(honest).mean < high
    assert consistency(honest).share_inside == pytest.approx(0.95, abs=0.03)
    assert consistency(bold).mean > 3 * high
    assert consistency(bold).share_inside < 0.7


def test_a_wall_is_as_consistent_about_a_far_origin() -> None:
    # The covariance of a line moves with the origin: offset' = offset + n . shift, and n turns with the angle.
    shift, error = np.array([30.0, -20.0]), np.array([1e-4, 2e-3])
    normal, tangent = directions(ANGLE), directions(ANGLE + np.pi / 2)
    jacobian = np.array([[1.0, 0.0], [tangent @ shift, 1.0]])
    moved_line = line(ANGLE + error[0], 2.0 + error[1] + float(directions(ANGLE + error[0]) @ shift))
    moved = wall_error(moved_line, TRUE_ENDS + shift)
    covariance = np.diag([1e-8, 1e-6])
    assert normal @ shift == pytest.approx(2.0)
    assert nees(moved, jacobian @ covariance @ jacobian.T) == pytest.approx(nees(error, covariance), rel=1e-3)


def test_an_empty_map_is_neither_consistent_nor_not() -> None:
    for each in evaluate(FeatureMap(method="none"), maps.ROOM).consistency.values():
        assert np.isnan(each.share_inside)


def test_coordinates_of_a_country_do_not_hide_the_consistency_of_a_wall() -> None:
    shift = np.array([500_000.0, 5_200_000.0])
    wall = maps.wall((1, 0.002), (3, 0.002), covariance=np.diag([1e-8, 1e-6]))
    far_truth = replace(maps.ROOM, walls_xy=maps.ROOM.walls_xy + shift)
    near = evaluate(maps.drawn(wall), maps.ROOM).consistency[FeatureClass.WALL]
    far = evaluate(maps.drawn(translated_wall(wall, shift)), far_truth).consistency[FeatureClass.WALL]
    assert far.nees == pytest.approx(near.nees, rel=1e-2)

import numpy as np
import pytest

from echoplan.classical.points import Cloud
from echoplan.errors import InvalidValueError


def test_a_cloud_has_a_weight_and_a_centroid() -> None:
    cloud = Cloud(points_xy=np.array([[0.0, 0.0], [4.0, 2.0]]), weights=np.array([1.0, 3.0]))
    assert cloud.weight == 4.0
    assert cloud.centroid_xy == pytest.approx([3.0, 1.5])
    assert len(cloud[np.array([True, False])]) == 1


def test_points_of_one_stretch_say_as_much_as_one() -> None:
    cloud = Cloud(points_xy=np.zeros((5, 2)), weights=np.ones(5))
    assert cloud.information(np.array([0.0, 0.01, 0.02, 0.03, 1.0]), spacing=0.1).sum() == pytest.approx(2.0)


def test_points_of_little_weight_say_no_more_than_they_weigh() -> None:
    cloud = Cloud(points_xy=np.zeros((3, 2)), weights=np.full(3, 0.1))
    assert cloud.information(np.array([0.0, 1.0, 2.0]), spacing=0.1).sum() == pytest.approx(0.3)


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan])
def test_a_weight_must_be_positive(weight: float) -> None:
    with pytest.raises(InvalidValueError, match="weights must be"):
        Cloud(points_xy=np.zeros((1, 2)), weights=np.array([weight]))

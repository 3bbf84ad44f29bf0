import numpy as np
import pytest

from echoplan.classical.loci import Loci
from echoplan.errors import InvalidValueError
from helpers import arcs, scenes


def test_each_valid_reading_is_an_arc_about_its_acoustic_centre() -> None:
    ranges = np.full(360, np.inf)
    ranges[[45, 100]] = 1.0, 2.0
    ranges[200] = 9.9
    loci = Loci.of(scenes.sweep_of(ranges, index=3, pose=(1.0, 0.0, 0.0)), scenes.rig())
    assert loci.ranges.tolist() == [2.0, 1.0]
    assert loci.bearings == pytest.approx(np.radians([55.0, 0.0]))
    assert loci.centers_xy[1] == pytest.approx([1.05, 0.0])
    assert loci.half_apertures.tolist() == [0.61, 0.61]
    assert loci.sweeps.tolist() == [3, 3]


def test_points_of_arcs_and_their_turns_belong_together() -> None:
    loci = arcs.on_point((3.0, 1.0), [(0.0, 0.0), (2.0, -1.0)], turns=(0.1, -0.2))
    assert loci.turns(np.tile([3.0, 1.0], (4, 1))) == pytest.approx([-0.1, 0.2, -0.1, 0.2])
    assert loci.points_xy(np.array([-0.1, 0.2, -0.1, 0.2])) == pytest.approx(np.tile([3.0, 1.0], (4, 1)))
    assert loci.points_xy(np.zeros((4, 3)))[:, 1] == pytest.approx(loci.middles_xy)


def test_arcs_can_be_chosen_and_put_together() -> None:
    loci = arcs.on_point((3.0, 1.0), [(0.0, 0.0), (2.0, -1.0), (1.0, 5.0)])
    again = Loci.joined([loci[:1], loci[np.array([1, 2])]])
    assert again.ranges.tolist() == loci.ranges.tolist()
    assert again.sweeps.tolist() == [0, 1, 2]
    assert len(Loci.joined([])) == 0


def test_an_arc_has_a_finite_radius() -> None:
    with pytest.raises(InvalidValueError, match="ranges must be finite"):
        Loci(
            centers_xy=np.zeros((1, 2)),
            ranges=np.array([np.inf]),
            bearings=np.zeros(1),
            half_apertures=np.ones(1),
            sweeps=np.array([0]),
        )

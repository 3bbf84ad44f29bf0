import numpy as np
import pytest

from echoplan.classical.grids import Raster, box_about, chosen_cones, trace_for
from echoplan.classical.grids.sectors import trace_sector
from helpers import cells

RASTER = Raster(-4.0, -4.0, 0.1, 80, 80)


@pytest.mark.parametrize("seed", range(5))
def test_the_cells_of_a_cone_are_those_whose_centres_a_plain_look_at_all_cells_finds(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed))
    radii = np.minimum(cones.readings, cones.reaches)
    trace = trace_for(cones, radii, RASTER.resolution)
    for ping, seen in enumerate(cells.seen(cones, RASTER)):
        count = trace_sector(trace, RASTER, cones, ping, radii[ping])
        wanted = np.argwhere(seen.inside & (seen.distances <= radii[ping]))
        rows, columns = trace.rows[:count], trace.columns[:count]
        assert np.array_equal(np.column_stack([rows, columns]), wanted)
        np.testing.assert_allclose(trace.distances[:count], seen.distances[rows, columns])
        np.testing.assert_allclose(trace.turns[:count], np.abs(seen.turns[rows, columns]), atol=1e-12)


def test_cells_beyond_the_edge_of_the_raster_are_left_out() -> None:
    cones = cells.cone(reading=3.0, half_aperture=np.pi / 2)
    small = Raster(-0.5, -0.5, 0.1, 10, 10)
    trace = trace_for(cones, np.array([3.0]), 0.1)
    count = trace_sector(trace, small, cones, 0, 3.0)
    assert count == 50
    assert trace.rows[:count].max() == trace.columns[:count].max() == 9


def test_a_radius_of_nothing_or_less_has_no_cell() -> None:
    cones = cells.cone(0.02, 0.03)
    trace = trace_for(cones, np.array([-1.0]), 0.1)
    assert [trace_sector(trace, RASTER, cones, 0, radius) for radius in (0.0, -1.0)] == [0, 0]


@pytest.mark.parametrize("bearing", np.arange(8) * np.pi / 4)
def test_a_sensor_in_the_middle_of_a_cell_sees_as_much_in_opposite_directions(bearing: float) -> None:
    counts = []
    for turned in (bearing, bearing + np.pi):
        cones = cells.cone(0.05, 0.05, bearing=turned)
        trace = trace_for(cones, np.array([1.04]), 0.1)
        count = trace_sector(trace, RASTER, cones, 0, 1.04)
        # Its own cell, whose centre is the tip of the cone, may belong to it or not.
        counts.append(int((trace.distances[:count] > 0.01).sum()))
    assert counts[0] == counts[1] > 50


@pytest.mark.parametrize("seed", range(3))
def test_the_box_about_cones_touches_them_on_all_sides(seed: int) -> None:
    cones = cells.random_cones(np.random.default_rng(seed))
    radii = np.minimum(cones.readings, cones.reaches)
    shares = np.linspace(-1.0, 1.0, 4001)
    angles = np.arctan2(cones.uy, cones.ux)[:, None] + cones.half_apertures[:, None] * shares
    x = np.column_stack([cones.x, cones.x[:, None] + radii[:, None] * np.cos(angles)])
    y = np.column_stack([cones.y, cones.y[:, None] + radii[:, None] * np.sin(angles)])
    assert box_about(cones, radii) == pytest.approx(np.array([[x.min(), y.min()], [x.max(), y.max()]]), abs=1e-6)
    for ping in range(len(radii)):
        alone = box_about(chosen_cones(cones, slice(ping, ping + 1)), radii[ping : ping + 1])
        wanted = [[x[ping].min(), y[ping].min()], [x[ping].max(), y[ping].max()]]
        assert alone == pytest.approx(np.array(wanted), abs=1e-6)

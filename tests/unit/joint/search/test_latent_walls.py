import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.joint.search.latent_walls import log_densities_over_latent_walls
from echoplan.joint.search.refinement import approach
from helpers.expectations import feature, likelihood, listening, returning, wall
from helpers.single_ping import PLAIN

# A wall to the north, and the place where a latent wall abuts on it; the known wall was detected west of it.
NORTH, VERTEX = wall(np.pi / 2, 1.5), (1.2, 1.5)
EAST_END = -VERTEX[0]
STATIONS = ((-0.4, -0.3), (0.3, -0.1))


def north_wall(*, to: float = EAST_END + 0.4, gain: float = 200.0) -> Hypothesis:
    """Return the wall to the north, detected up to a place along it, counted to the west."""
    return feature(NORTH, extent=(to, 0.9), llr_by_station=(gain, gain))


def detected(opening: float, beside: Hypothesis) -> tuple[float, FloatArray]:
    """Return the ratio of the best wall across the corner, and the log densities by latent walls."""
    measurements = returning(listening(STATIONS), VERTEX, opening)
    estimate, schedule = likelihood(measurements, sonar=PLAIN), [(0.02, 0.2, 20), (0.003, 0.03, 20)]
    ahead = np.flatnonzero(np.isfinite(measurements.readings))
    across = approach(measurements, PLAIN.tabulated(), wall(0.9, 1.85), ahead, schedule)
    log_densities = estimate.log_densities([beside])
    alternative = estimate.rescored(estimate.score(across), log_densities, [beside])
    return alternative.llr, log_densities_over_latent_walls(estimate, alternative, [beside], log_densities)[ahead]


@pytest.mark.parametrize("opening", [65.0, 78.0, 86.0, 90.0, 93.0])
def test_multipath_over_a_latent_wall_explains_a_false_wall(opening: float) -> None:
    gain, log_densities = detected(opening, north_wall())
    assert gain > 12.0
    assert (log_densities > 2.0).mean() > 0.9


def test_there_is_no_latent_wall_where_the_known_wall_continues() -> None:
    assert detected(78.0, north_wall(to=EAST_END - 1.0))[1].max() < 0.0


def test_there_is_no_latent_wall_on_a_weaker_wall() -> None:
    assert detected(78.0, north_wall(gain=1.0))[1].max() == NO_ECHO


def test_without_detections_there_is_no_latent_wall() -> None:
    measurements = listening(STATIONS)
    estimate = likelihood(measurements, sonar=PLAIN)
    log_densities = estimate.log_densities([])
    silent = estimate.rescored(estimate.score(wall(0.8, 1.7)), log_densities, [])
    assert log_densities_over_latent_walls(estimate, silent, [north_wall()], log_densities).max() == NO_ECHO

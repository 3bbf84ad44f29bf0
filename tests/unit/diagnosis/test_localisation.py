from dataclasses import replace

import numpy as np
import pytest

from echoplan.diagnosis import assess_localisation
from echoplan.model import FeatureMap, Localisation, Quality, StartPose, TrajectorySegment, Verdict

MAP = FeatureMap(method="joint", quality=Quality(verdict=Verdict.GOOD))


def localisation(share: float, *weights: float) -> Localisation:
    """One sweep at the origin, and poses with these probabilities at which it may have been made."""
    starts = tuple(StartPose(pose=np.array([x, 0.5, np.pi]), weight=weight) for x, weight in enumerate(weights))
    return Localisation(
        sweeps=np.array([3]),
        poses=np.zeros((1, 3)),
        covariances=np.zeros((1, 3, 3)),
        segments=(TrajectorySegment(first=3, starts=starts),),
        inlier_ratio=share,
        jaccard_index=share,
    )


def test_a_localisation_that_the_map_explains_is_good() -> None:
    assert assess_localisation(localisation(0.95, 1.0), MAP) == Quality(verdict=Verdict.GOOD)


@pytest.mark.parametrize(
    ("share", "verdict"), [(0.89, "good"), (0.87, "doubtful"), (0.71, "doubtful"), (0.69, "failed")]
)
def test_the_verdict_is_worse_the_less_the_map_explains(share: float, verdict: str) -> None:
    assert assess_localisation(localisation(share, 1.0), MAP).verdict == verdict


def test_a_failed_localisation_says_how_little_fits_and_what_to_check() -> None:
    found = assess_localisation(localisation(0.43, 1.0), MAP)
    assert found.reasons == ("Only 43 % of the echoes fit the map.",)
    assert "the map is of this place" in found.next_step


def test_poses_that_fit_as_well_are_listed_with_their_probabilities() -> None:
    found = assess_localisation(localisation(0.99, 0.6, 0.398, 0.002), MAP)
    assert found.verdict is Verdict.DOUBTFUL
    assert found.reasons == (
        "Sweep 3 may be at x 0.00 m, y 0.50 m, yaw 180° (60 %) or x 1.00 m, y 0.50 m, yaw 180° (40 %).",
    )
    assert "--start" in found.next_step


def test_poses_in_a_doubtful_map_are_doubtful() -> None:
    doubtful = replace(MAP, quality=Quality(verdict=Verdict.DOUBTFUL))
    found = assess_localisation(localisation(0.99, 1.0), doubtful)
    assert (found.verdict, found.reasons) == (Verdict.DOUBTFUL, ("The map itself is doubtful.",))

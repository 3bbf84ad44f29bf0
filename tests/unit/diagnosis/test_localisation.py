from dataclasses import replace

import numpy as np
import pytest

from echoplan.diagnosis import assess_localisation
from echoplan.model import FeatureMap, Localisation, Quality, StartPose, TrajectorySegment, Verdict

MAP = FeatureMap(method="joint", quality=Quality(verdict=Verdict.GOOD))


def localisation(jaccard_index: float, *weights: float) -> Localisation:
    """One sweep at the origin, and poses with these probabilities at which it may have been made."""
    starts = tuple(StartPose(pose=np.array([x, 0.5, np.pi]), weight=weight) for x, weight in enumerate(weights))
    return Localisation(
        sweeps=np.array([3]),
        poses=np.zeros((1, 3)),
        covariances=np.zeros((1, 3, 3)),
        segments=(TrajectorySegment(first=3, starts=starts),),
        inlier_ratio=0.95,
        jaccard_index=jaccard_index,
    )


def test_a_localisation_that_the_map_explains_is_good() -> None:
    assert assess_localisation(localisation(0.95, 1.0), MAP) == Quality(verdict=Verdict.GOOD)


@pytest.mark.parametrize(
    ("jaccard_index", "verdict"), [(0.71, "good"), (0.69, "doubtful"), (0.61, "doubtful"), (0.59, "failed")]
)
def test_the_verdict_is_worse_the_less_echoes_and_map_agree(jaccard_index: float, verdict: str) -> None:
    assert assess_localisation(localisation(jaccard_index, 1.0), MAP).verdict == verdict


def test_a_failed_localisation_says_how_little_agrees_and_what_to_check() -> None:
    found = assess_localisation(localisation(0.43, 1.0), MAP)
    assert found.reasons == ("Echoes and map agree to only 43 % (70 % are needed).",)
    assert "the map is of this place" in found.next_step


def test_an_agreement_below_the_limit_is_not_printed_as_the_limit() -> None:
    (reason,) = assess_localisation(localisation(0.6999, 1.0), MAP).reasons
    assert "agree to only 69 % (70 % are needed)" in reason
    assert localisation(0.69, 1.0).percent_in_common == 69


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

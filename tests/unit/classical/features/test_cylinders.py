import numpy as np
import pytest

from echoplan.classical.features import AssociationSettings, CylinderSettings, Observation, cylinder_of
from helpers import scenes

GATES = AssociationSettings()
HUBS = [(0.6, 1.0), (1.4, 0.7), (2.2, 1.3)]


def observations_of(circle: tuple[float, float, float], hubs: list[tuple[float, float]]) -> tuple[Observation, ...]:
    return tuple(scenes.observed_circle(circle, hub, sweep=sweep) for sweep, hub in enumerate(hubs))


def test_a_cylinder_has_the_radius_of_its_circle() -> None:
    cylinder = cylinder_of(
        observations_of((1.5, 1.6, 0.12), HUBS), CylinderSettings(radius_sigma=10.0), association=GATES
    )
    assert cylinder is not None
    assert cylinder.center_xy == pytest.approx([1.5, 1.6], abs=1e-4)
    assert cylinder.radius == pytest.approx(0.12, abs=1e-4)
    assert (cylinder.stations, cylinder.pings) == (3, 120)
    assert cylinder.class_probabilities.cylinder == 1.0


def test_what_only_a_hollow_circle_explains_is_no_cylinder() -> None:
    hollow = observations_of((1.5, 1.6, -0.2), [(0.5, 1.6), (2.5, 1.6)])
    assert cylinder_of(hollow, CylinderSettings(), association=GATES) is None


def test_from_one_side_the_radius_is_what_was_expected_and_as_unsure() -> None:
    one = observations_of((2.0, 1.0, 0.3), [(0.5, 1.0)])
    cylinder = cylinder_of(one, CylinderSettings(radius=0.08, radius_sigma=0.05), association=GATES)
    assert cylinder is not None
    assert cylinder.radius == pytest.approx(0.08, abs=1e-6)
    assert np.sqrt(cylinder.covariance[2, 2]) == pytest.approx(0.05, rel=0.01)
    # Its face is where it was detected, whatever the radius.
    assert cylinder.center_xy[0] - cylinder.radius == pytest.approx(1.7, abs=1e-6)


def test_more_views_determine_the_radius_better() -> None:
    around = [(0.5, 1.6), (1.5, 0.6), (2.5, 1.6), (1.5, 2.6)]
    sigmas = []
    for count in (1, 2, 4):
        cylinder = cylinder_of(observations_of((1.5, 1.6, 0.12), around[:count]), CylinderSettings(), association=GATES)
        assert cylinder is not None
        sigmas.append(float(np.sqrt(cylinder.covariance[2, 2])))
    assert sigmas[0] > 5 * sigmas[1] > 5 * sigmas[2]


def test_what_the_echoes_of_a_sweep_have_in_common_makes_it_less_sure() -> None:
    members = observations_of((1.5, 1.6, 0.12), HUBS)
    vague = AssociationSettings(common_distance_sigma=0.02)
    sure, unsure = (cylinder_of(members, CylinderSettings(), association=gates) for gates in (GATES, vague))
    assert sure is not None
    assert unsure is not None
    assert np.trace(unsure.covariance) > np.trace(sure.covariance)

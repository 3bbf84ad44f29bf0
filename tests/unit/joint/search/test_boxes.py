from collections.abc import Sequence

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray
from echoplan.joint.arcs import ArcSettings, find_arcs
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.boxes import with_boxes
from echoplan.joint.search.search import Search, SearchSettings
from helpers.expectations import NOISE, ROOM, SONAR, cylinder, edge, likelihood, listening, pings_of, rescored

CONE = 0.26
SEEING = SONAR.as_ray_cone(CONE)
# All around a box of 0.3 m.
STATIONS = ((-0.6, -0.6), (-0.7, 0.5), (0.9, -0.5), (0.8, 0.8), (-0.1, -0.8), (0.1, 0.9))
EDGES = [edge(x, y) for x in (-0.15, 0.15) for y in (-0.15, 0.15)]
COLUMN = cylinder(0.0, 0.0, 0.15)


def before_and_after(*standing: FloatArray, sonar: EchoModel = SEEING) -> tuple[list[Hypothesis], list[Hypothesis]]:
    """Return the landmarks before and after, starting from a cylinder in the room."""
    silent, rng = listening(STATIONS), np.random.default_rng(1)
    measurements = pings_of(silent, [*ROOM, *standing], sonar=sonar, noise=NOISE, rng=rng)
    estimate = likelihood(measurements, sonar=sonar)
    arcs = find_arcs(measurements, resolution=0.005, settings=ArcSettings())
    search = Search(estimate, arcs, half_aperture=CONE, settings=SearchSettings())
    before = rescored(estimate, [*ROOM, COLUMN])
    return before, with_boxes(search, before)


def points(features: Sequence[Hypothesis]) -> FloatArray:
    return np.array([each.reflector[1:3] for each in features if each.kind is Kind.EDGE]).reshape(-1, 2)


def test_edges_of_a_box_replace_a_cylinder() -> None:
    _, found = before_and_after(*EDGES)
    assert not [each for each in found if each.kind is Kind.CYLINDER]
    assert len(points(found)) >= 3
    assert np.abs(np.abs(points(found)) - 0.15).max() < 0.01


def test_a_cylinder_is_not_replaced_by_edges() -> None:
    before, found = before_and_after(COLUMN)
    assert [each.key for each in found] == [each.key for each in before]


def test_boxes_are_not_searched_with_sound() -> None:
    before, found = before_and_after(*EDGES, sonar=SONAR)
    assert found == before

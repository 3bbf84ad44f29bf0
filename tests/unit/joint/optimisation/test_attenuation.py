"""Partially occluded walls return weak echoes, which read long: without attenuation their direction is biased."""

from collections.abc import Sequence

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import Kind, walk_of
from echoplan.arrays import FloatArray
from echoplan.joint.optimisation.attenuation import shadowed
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.range_factors import Features, associate
from echoplan.methods import find_method, map_sweeps
from echoplan.preprocessing.measurements import Measurements
from helpers import simulated_worlds
from helpers.expectations import REACH, SONAR, expected, listening, wall

EAST = wall(0.0, 1.6)
# Whether the wall may be soft.
HARD, SOFT = np.array([False]), np.array([True])
STATIONS = ((-0.2, -0.6), (0.1, -0.2), (-0.1, 0.2), (0.2, 0.6))


def detected(attenuations: Sequence[float]) -> Measurements:
    """Return pings of a wall with an attenuation per station [dB]."""
    pings, sonar = listening(STATIONS, step=np.radians(2.0)), SONAR.tabulated()
    readings = np.full(len(pings.readings), np.inf)
    for station, attenuation in enumerate(attenuations):
        excesses, is_detected_at = expected(pings, EAST)
        later = np.array([walk_of(sonar, each - attenuation) - walk_of(sonar, each) for each in excesses])
        readings = np.where((pings.stations == station) & (excesses > attenuation), is_detected_at + later, readings)
    return pings._replace(readings=readings)


def features(*, unheard_from: Sequence[int] = ()) -> Features:
    attenuations = np.where(np.isin(np.arange(len(STATIONS)), unheard_from), np.inf, 0.0)
    extents = np.array([[-REACH, REACH]])
    return Features(
        EAST[None], extents, attenuations[None], np.zeros((1, len(attenuations))), edges_of(EAST[None], extents)
    )


def found(pings: Measurements, landmarks: Features | None = None) -> FloatArray:
    attenuations: FloatArray = shadowed(pings, SONAR.tabulated(), landmarks or features(), HARD).attenuations[0]
    return attenuations


def test_attenuations_are_estimated_from_detections() -> None:
    attenuations = found(detected([0.0, 6.0, 9.0, 12.0]))
    assert attenuations[0] == 0.0
    assert attenuations == pytest.approx([0.0, 6.0, 9.0, 12.0], abs=1.5)


def test_one_decibel_of_attenuation_is_ignored() -> None:
    assert found(detected([0.0, 1.0, -1.0, 1.0])).tolist() == [0.0] * 4


def test_what_all_stations_have_in_common_is_the_reflection_loss_of_a_soft_wall() -> None:
    north, one = wall(np.pi / 2, 5.0), features()
    two = Features(
        np.array([EAST, north]),
        np.tile(one.extents, (2, 1)),
        np.vstack([one.attenuations, np.full((1, len(STATIONS)), np.inf)]),
        np.zeros((2, len(STATIONS))),
        edges_of(np.array([EAST, north]), np.tile(one.extents, (2, 1))),
    )
    softened = shadowed(detected([12.4] * 4), SONAR.tabulated(), two, np.array([True, True]))
    assert softened.reflectors[:, 3] == pytest.approx([12.4, 0.0], abs=1.0)
    assert softened.attenuations[0].tolist() == [0.0] * 4


def test_if_all_walls_seem_soft_the_sonar_is_fainter_than_assumed() -> None:
    softened = shadowed(detected([12.4] * 4), SONAR.tabulated(), features(), SOFT)
    assert softened.reflectors[0, 3] == 0.0
    assert softened.attenuations[0] == pytest.approx([12.4] * 4, abs=1.5)


def test_a_wall_that_single_stations_attenuate_is_hard() -> None:
    softened = shadowed(detected([0.0, 6.0, 9.0, 12.0]), SONAR.tabulated(), features(), SOFT)
    assert softened.reflectors[0, 3] == 0.0


def test_masked_pings_give_no_attenuation() -> None:
    pings = detected([12.0] * 4)
    masked = pings._replace(readings=np.minimum(pings.readings, 0.5 + 9.0 * np.isfinite(pings.readings)))
    assert found(pings).min() > 9.0
    assert found(masked).tolist() == [0.0] * 4
    assert shadowed(masked, SONAR.tabulated(), features(), SOFT).reflectors[0, 3] == 0.0


def test_an_undetermined_attenuation_becomes_a_common_error() -> None:
    pings, sonar = detected([0.0] * 4), SONAR.tabulated()
    # If all pings more than ten degrees aside are masked, half a wall is possible, too.
    aside = np.abs(np.angle(np.exp(1j * pings.bearings))) > np.radians(10.0)
    masked = pings._replace(readings=np.where(aside & (pings.stations == 2), 0.5, pings.readings))
    clear, open_ = (shadowed(each, sonar, features(), HARD).bias_variances[0] for each in (pings, masked))
    assert 0.0 < np.sqrt(clear).max() < 0.0003
    assert open_[[0, 1, 3]] == pytest.approx(clear[[0, 1, 3]])
    assert 0.0005 < np.sqrt(open_[2]) < 0.01


def test_only_walls_have_common_errors_by_attenuation() -> None:
    pings = detected([0.0] * 4)
    column = np.array([[Kind.CYLINDER, 1.7, 0.0, 0.1]])
    readings = np.where(np.isfinite(pings.readings), expected(pings, column[0])[1], np.inf)
    landmarks = features()._replace(reflectors=column, extents=np.zeros((1, 2)))
    assert shadowed(pings._replace(readings=readings), SONAR.tabulated(), landmarks, HARD).bias_variances.tolist() == [
        [0.0] * 4
    ]


def test_attenuation_is_estimated_only_for_detecting_stations() -> None:
    attenuations = found(detected([12.0] * 4), features(unheard_from=[1, 3]))
    assert attenuations[[1, 3]].tolist() == [np.inf, np.inf]
    assert attenuations[[0, 2]] == pytest.approx([12.0, 12.0], abs=1.5)


@pytest.mark.parametrize(
    ("unheard_from", "silent"), [((), [0, 3]), ((1, 2), [1, 2]), ((2,), [0, 2, 3])], ids=["all", "past it only", "both"]
)
def test_stations_past_the_ends_of_a_wall_are_used_only_without_others(
    unheard_from: tuple[int, ...], silent: list[int]
) -> None:
    # Only the second and the third station are before the wall.
    ends = np.array([[[-0.3, 0.0, 0.0, 0.0, 0.0, -1.0], [0.3, 0.0, 0.0, 0.0, 0.0, -1.0]]])
    attenuations = found(detected([0.0] * 4), features(unheard_from=unheard_from)._replace(ends=ends))
    assert np.flatnonzero(np.isinf(attenuations)).tolist() == silent


def test_the_range_walk_of_attenuated_echoes_is_predicted() -> None:
    pings, sonar = detected([0.0, 0.0, 7.0, 12.0]), SONAR.tabulated()
    landmarks = features()
    plain, asked = (
        associate(pings, sonar, each, 0.05) for each in (landmarks, shadowed(pings, sonar, landmarks, HARD))
    )
    for station, least in ((2, 0.004), (3, 0.008)):
        own = (pings.stations == station) & np.isfinite(pings.readings)
        assert np.median(plain.residuals[own]) > least
        assert abs(np.median(asked.residuals[own])) < 0.002


def test_the_sides_of_a_box_are_square_although_detected_past_their_ends() -> None:
    around, box = [[0, 0], [4, 0], [4, 3], [0, 3]], [[1.6, 1.2], [2.3, 1.2], [2.3, 1.7], [1.6, 1.7]]
    place = simulated_worlds.world([*around, around[0]], [*box, box[0]])
    # West of the box two stations before it and two past its ends, and likewise south of it.
    west, south = (
        [(0.9, 1.15), (0.7, 1.4), (0.8, 1.55), (0.9, 1.75)],
        [(1.55, 0.6), (1.8, 0.4), (2.1, 0.5), (2.36, 0.6)],
    )
    stations = [[x, y, 0.0] for x, y in (*west, *south)]
    source = simulated_worlds.simulation(place, using=simulated_worlds.array(resolution=0.005), poses=stations)
    walls = map_sweeps(find_method("joint").build(source.rig), source).walls
    sides = [each for each in walls if 1.4 < each.endpoints_xy.mean(axis=0)[0] < 2.5 and each.stations > 1]
    sides = [each for each in sides if 1.0 < each.endpoints_xy.mean(axis=0)[1] < 1.9]
    assert len(sides) >= 2
    for each in sides:
        askew = np.remainder(each.normal_angle + np.pi / 4, np.pi / 2) - np.pi / 4
        assert abs(askew) < np.radians(0.6), np.degrees(askew)

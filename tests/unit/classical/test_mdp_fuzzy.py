from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper, MdpFuzzySettings
from echoplan.model import Sweep
from helpers import chamber, scenes

# A pillar of 16 cm radius, seen from three sides as an ideal array sees it.
PILLAR = (1.0, 1.0, 0.16)
AROUND = ((0.0, 0.2), (1.9, 0.1), (0.9, 2.1))


def seen(hub: tuple[float, float], *, index: int) -> Sweep:
    """The pillar over 23 degrees and a wall behind the array over 41."""
    ranges = np.full(360, np.inf)
    away = np.array(PILLAR[:2]) - hub
    normal, distance = float(np.arctan2(away[1], away[0])), float(np.hypot(*away)) - PILLAR[2]
    put(
        ranges, scenes.cylinder_ranges(chamber.BEARINGS, normal=normal, distance=distance, radius=PILLAR[2]), normal, 11
    )
    put(ranges, scenes.wall_ranges(chamber.BEARINGS, normal=normal + np.pi, distance=1.4), normal + np.pi, 20)
    return scenes.sweep_of(ranges, index=index, pose=(*hub, 0.0))


def put(ranges: FloatArray, own: FloatArray, normal: float, half_width: float) -> None:
    turns = np.angle(np.exp(1j * (chamber.BEARINGS - normal)))
    near = np.abs(turns) <= np.radians(half_width) + 1e-9
    ranges[near] = own[near] + chamber.LATENESS * turns[near] ** 2


def mapped(sweeps: Iterable[Sweep], settings: MdpFuzzySettings | None = None) -> MdpFuzzyMapper:
    mapper = MdpFuzzyMapper(scenes.rig(), settings)
    for sweep in sweeps:
        mapper.add(sweep)
    return mapper


def around(*, scans: int = 1) -> list[Sweep]:
    hubs = [hub for hub in AROUND for _ in range(scans)]
    return [seen(hub, index=number) for number, hub in enumerate(hubs)]


def test_without_repeated_scans_the_greatest_width_is_the_median_over_sweeps() -> None:
    sweeps = [chamber.recorded(hub, index=number) for number, hub in enumerate(((0.0, 0.0), (0.1, 0.0), (0.2, 0.0)))]
    assert np.degrees(mapped(sweeps).max_width) == pytest.approx(40.0, abs=1e-6)


def test_of_a_station_swept_twice_the_greatest_width_is_the_mean_of_both_scans() -> None:
    sweeps = [chamber.recorded((0.0, 0.0)), chamber.recorded((0.0, 0.0), index=1)]
    # The echo at one end of every wall is missing in the second scan.
    bearings = np.round(np.degrees(sweeps[1].servo_angles) + 90 * sweeps[1].sensor_ids) % 360
    ends = np.round(np.degrees(chamber.LINES[:, 0]) + 20) % 360
    second = replace(sweeps[1], ranges=np.where(np.isin(bearings, ends), np.inf, sweeps[1].ranges))
    assert np.degrees(mapped([sweeps[0], second]).max_width) == pytest.approx(39.5, abs=1e-6)


def test_two_scans_of_one_station_confirm_nothing() -> None:
    here = mapped([chamber.recorded((0.0, 0.0), index=number) for number in range(2)])
    assert here.result().walls == ()
    assert len(mapped([chamber.recorded(hub, index=k) for k, hub in enumerate(chamber.HUBS)]).result().walls) == 4


def test_the_radius_in_equation_five_comes_from_the_fitted_circle() -> None:
    cylinder = mapped(around()).result().cylinders[0]
    # The expected radius is 0.10 m, the true one 0.16 m: without a prior nothing draws the circle to the former.
    assert cylinder.radius == pytest.approx(PILLAR[2], abs=0.004)
    assert cylinder.center_xy == pytest.approx(PILLAR[:2], abs=0.004)


def test_a_radius_does_not_depend_on_where_the_rounds_start() -> None:
    radii = [
        mapped(around(), MdpFuzzySettings.model_validate({"assembly": {"cylinders": {"radius": start}}}))
        .result()
        .cylinders[0]
        .radius
        for start in (0.06, 0.14)
    ]
    assert radii[0] == pytest.approx(radii[1], abs=2e-4)


def test_a_prior_draws_the_radius_to_what_is_expected() -> None:
    tight = {"circle": "prior", "assembly": {"cylinders": {"radius": 0.1, "radius_sigma": 0.001}}}
    assert mapped(around(), MdpFuzzySettings.model_validate(tight)).result().cylinders[0].radius < 0.13


def test_clustering_once_finds_the_same_objects_in_a_quiet_room() -> None:
    sweeps = [chamber.recorded(hub, index=number) for number, hub in enumerate(chamber.HUBS)]
    twice, once = (mapped(sweeps, MdpFuzzySettings(order=order)) for order in ("paper", "cluster once"))
    assert [each.pings for each in twice.observations] == [each.pings for each in once.observations]

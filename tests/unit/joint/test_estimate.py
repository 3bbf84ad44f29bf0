from dataclasses import replace

import numpy as np
import pytest

from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.mapper import JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.sources import find_rig, find_route, find_world


def estimate_of(temperature: float) -> Estimate:
    """Return the initial estimate of a square room at an air temperature [degC] that the rig does not state."""
    settings = SimulationSettings.model_validate({"air": {"temperature": temperature}})
    rig = find_rig("rotary-array")
    sweeps = list(
        Simulation(world=find_world("square"), rig=rig, route=find_route("square"), settings=settings, seed=2)
    )
    pings = join_measurements([measurements_of(sweep, rig) for sweep in sweeps])
    poses = np.array([sweep.map_from_base[0] for sweep in sweeps])
    return initial_estimate(rig, pings, poses, JointSettings(poses=PoseMode.TRUST))


@pytest.mark.parametrize(("temperature", "is_repeated"), [(20.0, False), (13.0, True)])
def test_the_first_search_is_repeated_if_the_range_scale_changes(
    monkeypatch: pytest.MonkeyPatch, temperature: float, *, is_repeated: bool
) -> None:
    scales, search = list[float](), Estimate.search

    def noted(self: Estimate, *, rounds: int | None = None) -> Estimate:
        scales.append(self.model.range_scale)
        return search(self, rounds=rounds)

    monkeypatch.setattr(Estimate, "search", noted)
    found = estimate_of(temperature).initialise()
    assert (len(scales) > 1) == is_repeated
    assert scales[-1] == pytest.approx(found.model.range_scale, abs=found.settings.scale_step)


def test_landmarks_are_optimised_once_more_after_the_last_of_them_is_removed(monkeypatch: pytest.MonkeyPatch) -> None:
    prune = Estimate.prune_and_reclassify

    def without_last(self: Estimate) -> Estimate:
        found = prune(self)
        return replace(found, features=found.features[:-1])

    monkeypatch.setattr(Estimate, "prune_and_reclassify", without_last)
    found = estimate_of(20.0).initialise().explain()
    assert found.solution is not None
    assert found.solution.reflectors == pytest.approx(np.array([each.reflector for each in found.features]))

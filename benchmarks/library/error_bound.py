"""The Cramer-Rao bound: how exactly walls and cylinders can be known from the pings of a simulation."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.acoustics import Air, piston_ka
from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray
from echoplan.evaluation.consistency import nees, wall_error
from echoplan.evaluation.matches import Matches
from echoplan.geometry import along
from echoplan.joint.optimisation.attenuation import shadowed
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.optimiser import Features, OptimiserSettings, Priors, optimise
from echoplan.joint.optimisation.values import Values
from echoplan.model import FeatureMap, Sweep, Truth
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.simulation import Simulation

__all__ = ["against_bound", "true_scale"]

# One step at the true room, in which no reading is an outlier.
_AT_THE_TRUTH = OptimiserSettings(max_iterations=1, geman_mcclure_scale=1e6)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Error:
    """Error of an estimate, and the true feature: kind and parameters, extent."""

    error: FloatArray
    reflector: FloatArray
    extent: FloatArray


def against_bound(
    feature_map: FeatureMap, truth: Truth, matches: Matches, *, simulation: Simulation, sweeps: Sequence[Sweep]
) -> dict[str, list[float]]:
    """Compare the errors of right walls and cylinders with the least covariance that the same pings allow.

    The information is that of the readings at the true room with the true sonar and noise, each reading on its own.
    The numbers of the sonar are as unknown as they are to the method, with the same priors.  Echoes of corners are
    left out, so an estimate may be a little better than this bound.

    Parameters
    ----------
    feature_map : FeatureMap
        The estimates.
    truth : Truth
        The true objects.
    matches : Matches
        Which is of which.
    simulation : Simulation
        What made the sweeps.
    sweeps : sequence of Sweep
        What the map was made of.

    Returns
    -------
    dict of str to list of float
        NEES of each with the bound for its covariance.
    """
    walls = [_of_wall(feature_map, truth, each.estimate, each.truth) for each in matches.walls.right]
    cylinders = [_of_cylinder(feature_map, truth, each.estimate, each.truth) for each in matches.cylinders.right]
    every = [*walls, *cylinders]
    squares = [nees(each.error, bound) for each, bound in zip(every, _bounds(every, simulation, sweeps), strict=True)]
    return {"wall": squares[: len(walls)], "cylinder": squares[len(walls) :]}


def true_scale(simulation: Simulation) -> float:
    """Share by which the modules of a simulation read too short: they assume another temperature."""
    settings = simulation.settings
    return settings.air.speed_of_sound / Air(temperature=settings.assumed_temperature).speed_of_sound - 1.0


def _of_wall(feature_map: FeatureMap, truth: Truth, estimate: int, true: int) -> _Error:
    wall, ends_xy = feature_map.walls[estimate], truth.walls_xy[true]
    error = wall_error(wall, ends_xy)
    line = np.array([wall.normal_angle, wall.offset]) - error
    return _Error(error=error, reflector=np.array([Kind.WALL, *line, 0.0]), extent=np.sort(along(line, ends_xy)))


def _of_cylinder(feature_map: FeatureMap, truth: Truth, estimate: int, true: int) -> _Error:
    found, circle = feature_map.cylinders[estimate], truth.cylinders[true]
    error = np.array([*found.center_xy, found.radius]) - circle
    return _Error(error=error, reflector=np.array([Kind.CYLINDER, *circle]), extent=np.zeros(2))


def _bounds(features: Sequence[_Error], simulation: Simulation, sweeps: Sequence[Sweep]) -> list[FloatArray]:
    measurements, model = (
        join_measurements([measurements_of(sweep, simulation.rig) for sweep in sweeps]),
        _true_model(simulation),
    )
    reflectors = np.array([each.reflector for each in features]).reshape(-1, 4)
    extents = np.array([each.extent for each in features]).reshape(-1, 2)
    everything = Features(
        reflectors=reflectors,
        extents=extents,
        attenuations=np.zeros((len(features), len(sweeps))),
        bias_variances=np.zeros((len(features), len(sweeps))),
        ends=edges_of(reflectors, extents),
    )
    hard = np.zeros(len(features), dtype=bool)
    # What no method knows of shadows is no nuisance to the bound.
    everything = shadowed(measurements, model.tabulated(), everything, hard)._replace(
        bias_variances=everything.bias_variances
    )
    start = Values(features=everything, model=model)
    single = measurements._replace(weights=np.ones(len(measurements.weights)))
    solution = optimise(single, start, _priors(simulation, start.model), _AT_THE_TRUTH)
    places = [solution.layout.feature(number) for number in range(len(features))]
    return [solution.covariance[place, place] for place in places]


def _true_model(simulation: Simulation) -> EchoModel:
    transducer, air = simulation.rig.transducer, simulation.settings.air
    assert transducer is not None
    return replace(
        EchoModel.of(transducer),
        ka=piston_ka(transducer, air),
        absorption=air.absorption(transducer.frequency),
        range_scale=true_scale(simulation),
        range_offset=simulation.settings.zero_error,
        excess_scale=0.0,
    )


def _priors(simulation: Simulation, model: EchoModel) -> Priors:
    """Model whose range noise is jitter and rounding."""
    rounding = simulation.rig.sensors[0].resolution / float(np.sqrt(12.0))
    return Priors(
        noise=float(np.hypot(simulation.settings.jitter, rounding)),
        offset_sigma=rounding,
        walk_gain=model.walk_gain,
        has_servo=True,
        scale_sigma=_AT_THE_TRUTH.scale_sigma,
    )

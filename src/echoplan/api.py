"""Shorter ways of calling the library, for scripts and notebooks."""

from collections.abc import Iterable, Sequence
from os import PathLike

from echoplan.comparison import MethodScore, Subject, Trial, run_trials, score_methods
from echoplan.evaluation import Evaluation, EvaluationSettings
from echoplan.evaluation import evaluate as evaluate_map
from echoplan.io import read_map, read_truth
from echoplan.mapping import MapResult
from echoplan.methods import METHODS, find_method
from echoplan.model import FeatureMap, Recording, Source, Truth
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.sources import find_rig, find_route, find_truth, find_world, open_source

__all__ = ["compare", "evaluate", "simulate"]


def simulate(
    world: str,
    *,
    rig: str = "rotary-array",
    route: str | None = None,
    settings: SimulationSettings | None = None,
    seed: int = 0,
) -> Simulation:
    """Simulate a drive through a world: a source like any other, with the truth in its attribute ``truth``.

    Parameters
    ----------
    world : str
        A built-in world (``"square"``, ``"two-room-flat"``, ...) or a ``world.toml``.
    rig : str, optional
        A built-in rig or a ``rig.toml``.
    route : str, optional
        A built-in route or a ``route.csv``; by default that of the world.
    settings : SimulationSettings, optional
        Noise, dropouts, multipath and the rest.
    seed : int, optional
        Seed of all noise.

    Returns
    -------
    Simulation
        Sweeps are simulated while it is iterated over.

    Raises
    ------
    InputError
        If a file cannot be used.
    UnknownNameError
        If nothing of a name is built in.

    Examples
    --------
    >>> recording = simulate("square", seed=1)
    >>> len(recording), len(recording.truth.walls_xy)
    (5, 4)
    """
    return Simulation(
        world=find_world(world),
        rig=find_rig(rig),
        route=find_route(route or world),
        settings=settings or SimulationSettings(),
        seed=seed,
    )


def evaluate(
    found: MapResult | FeatureMap | str | PathLike[str],
    truth: Truth | str | PathLike[str],
    *,
    settings: EvaluationSettings | None = None,
) -> Evaluation:
    """Compare a map with ground truth.

    Parameters
    ----------
    found : MapResult or FeatureMap or str or Path
        The map, or a ``map.json``.
    truth : Truth or str or Path
        The truth, or a ``truth.json``.
    settings : EvaluationSettings, optional
        How to match and what counts.

    Returns
    -------
    Evaluation
        Recall, precision, errors and consistency.

    Raises
    ------
    InputError
        If a file cannot be used.

    Examples
    --------
    >>> import echoplan as ep
    >>> recording = ep.simulate("square", seed=1)
    >>> found = ep.map(recording, method="mdp-fuzzy")
    >>> ep.evaluate(found, recording.truth).matches.by_class["wall"].tally.found
    4
    """
    if isinstance(found, MapResult):
        found = found.feature_map
    drawn = found if isinstance(found, FeatureMap) else read_map(found)
    return evaluate_map(drawn, truth if isinstance(truth, Truth) else read_truth(truth), settings)


def compare(
    sources: Iterable[Source | str | PathLike[str]], *, methods: Sequence[str] | None = None, workers: int = 1
) -> Sequence[MethodScore]:
    """Map the same sources with several methods and score them.

    Parameters
    ----------
    sources : iterable of Source or str or Path
        What ``open_source`` returns, or what it takes.
    methods : sequence of str, optional
        Names of methods; all of ``METHODS`` by default.
    workers : int, optional
        Processes at a time.

    Returns
    -------
    sequence of MethodScore
        One for each method, in the order given.

    Raises
    ------
    InputError
        If a source cannot be used.
    UnknownNameError
        If there is no such method.
    """
    names = [find_method(name).name for name in (METHODS if methods is None else methods)]
    subjects = [_subject(each) for each in sources]
    trials = [Trial(subject=subject, method=name) for subject in subjects for name in names]
    return score_methods(list(run_trials(trials, workers=workers)), names)


def _subject(source: Source | str | PathLike[str]) -> Subject:
    opened = open_source(source) if isinstance(source, str | PathLike) else source
    return Subject(
        name=opened.name,
        recording=Recording(name=opened.name, rig=opened.rig, sweeps=tuple(opened)),
        truth=find_truth(opened),
    )

"""Shorter ways of calling the library, for scripts and notebooks."""

from collections.abc import Iterable, Sequence
from os import PathLike
from typing import cast

from echoplan.comparison import MethodScore, Subject, Trial, measure, run_trials, score_methods
from echoplan.errors import InvalidValueError
from echoplan.evaluation import Evaluation, EvaluationSettings
from echoplan.evaluation import evaluate as evaluate_map
from echoplan.io import read_map
from echoplan.io.text import names_in
from echoplan.io.truth import as_truth
from echoplan.mapping import MapResult, locate_source, map_source
from echoplan.methods import METHODS, find_method
from echoplan.model import FeatureMap, Recording, Source, Truth
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.sources import as_source, find_rig, find_route, find_truth, find_world, open_source

__all__ = ["compare", "evaluate", "locate", "map", "open", "simulate"]

# `echoplan.map`, `echoplan.open` and `echoplan.locate`: short names that a module of its own can give them.
map = map_source  # noqa: A001
open = open_source  # noqa: A001
locate = locate_source


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
        The map, or a ``map.json`` or its folder.
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
    InvalidValueError
        If one of them is something else.

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
    elif isinstance(found, str | PathLike):
        found = read_map(found)
    if not isinstance(found, FeatureMap):
        raise InvalidValueError(f"found must be a map or the path of a map.json, not {type(found).__name__}")
    return evaluate_map(found, as_truth(truth), settings)


def compare(
    sources: Source | str | PathLike[str] | Iterable[Source | str | PathLike[str]],
    *,
    methods: str | Sequence[str] | None = None,
    workers: int = 1,
) -> Sequence[MethodScore]:
    """Map the same sources with several methods and score them.

    Parameters
    ----------
    sources : Source or str or Path, or iterable of them
        What ``echoplan.open`` returns, or what it takes.
    methods : str or sequence of str, optional
        Names of methods, as in ``"joint,rcd"`` or ``["joint", "rcd"]``; all of ``METHODS`` by default.
    workers : int, optional
        Number of processes; 1 maps in this one.  More are spawned: a script then needs the usual guard
        ``if __name__ == "__main__":``.

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
    names = [find_method(name).name for name in names_in(METHODS if methods is None else methods)]
    subjects = [_subject(each) for each in _listed(sources)]
    trials = [Trial(subject=subject, method=name) for subject in subjects for name in names]
    if workers == 1:
        return score_methods([measure(trial) for trial in trials], names)
    return score_methods(list(run_trials(trials, workers=workers)), names)


def _listed(
    sources: Source | str | PathLike[str] | Iterable[Source | str | PathLike[str]],
) -> Iterable[Source | str | PathLike[str]]:
    """Make a list of a single source; a source is an iterable, too, of sweeps."""
    is_one = isinstance(sources, str | PathLike) or hasattr(sources, "rig")
    return cast("Iterable[Source]", [sources] if is_one else sources)


def _subject(source: Source | str | PathLike[str]) -> Subject:
    opened = as_source(source)
    return Subject(
        name=opened.name,
        recording=Recording(name=opened.name, rig=opened.rig, sweeps=tuple(opened)),
        truth=find_truth(opened),
    )

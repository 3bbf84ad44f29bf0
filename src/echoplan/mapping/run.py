"""Map one source from its first sweep to the assessed map."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from os import PathLike, fspath

from pydantic import BaseModel

from echoplan.config import Run
from echoplan.diagnosis import assess
from echoplan.errors import InputError
from echoplan.io.structure import validated
from echoplan.io.truth import as_truth
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.trace import collect_events
from echoplan.mapping.progress import SILENT, Progress
from echoplan.mapping.recordings import OneOrSeveral, check_options, check_sensors, map_recordings, open_recordings
from echoplan.mapping.result import MapResult
from echoplan.mapping.start import StartingMap, sensors_of
from echoplan.methods import LocalMapper, Method, find_method, grid_of, observations_of
from echoplan.model import Rig, Sweep, Truth
from echoplan.sources import conventions_of, find_truth, has_rig_file
from echoplan.viewer import EchoListener, Plan, decisions_in_words

__all__ = ["map_source"]


def map_source(
    source: OneOrSeveral,
    *,
    method: str = "joint",
    settings: BaseModel | Mapping[str, object] | None = None,
    start: str | PathLike[str] | None = None,
    truth: Truth | str | PathLike[str] | None = None,
    name: str | None = None,
    progress: Progress = SILENT,
) -> MapResult:
    """Map a source, or several recordings of one place, and assess the map.

    Parameters
    ----------
    source : Source or str or Path, or list of them
        What ``echoplan.open`` returns, or what it takes: a recording's folder, a bag, or ``sim:WORLD``.  Of several
        recordings, each may have poses in a frame of its own, and must begin where another one was; the map is in the
        frame of the first one.
    method : str, optional
        Name of the method, one of ``METHODS``.
    settings : BaseModel or mapping, optional
        Settings of the method: those of its ``settings_type``, or some of its keys, as in ``{"poses": "trust"}``.
    start : str or Path, optional
        Folder of a map that joint made of the same place before; the new one goes on from it, in its frame, and says
        what has changed.  The recording must begin where that map has walls.  None by default.
    truth : Truth or str or Path, optional
        Ground truth, or a ``truth.json``; by default that of the simulator, or the ``truth.json`` beside the
        recording, if there is one.
    name : str, optional
        How to name the source in the record of the run; by default what was opened, or the name of the source.
    progress : Progress, optional
        Shows how far it is; nothing by default.

    Returns
    -------
    MapResult
        The map; ``result.quality`` says whether it can be trusted.

    Raises
    ------
    InputError
        If the source or a setting cannot be used.
    UnknownNameError
        If there is no such method, or no such simulated world.

    Examples
    --------
    >>> result = map_source("sim:square,seed=1", method="mdp-fuzzy")
    >>> len(result.walls), result.evaluate().matches.by_class["wall"].tally.found
    (4, 4)
    """
    chosen = find_method(method)
    settings = _checked(settings, chosen.settings_type)
    recordings = open_recordings(source)
    known = check_options(method, settings, recordings=len(recordings.sources), start=start)
    check_sensors(recordings, known)
    opened, rig = recordings.first, recordings.first.rig
    truth = find_truth(opened) if truth is None else as_truth(truth)
    read = recordings.read(progress)
    mapper, listener = _mapper(chosen, rig, settings, known=known), EchoListener(rig)
    mapped: list[Sweep] = []
    with collect_events() as events, ExitStack() as shown:

        def follow(cleaned: Sequence[Sweep]) -> Iterator[Sweep]:
            """Pass on the cleaned sweeps, collect their echoes and show progress."""
            mapped.extend(cleaned)
            yield from listener.listen(progress.track(cleaned, total=len(cleaned), task="mapping"))
            shown.enter_context(progress.busy("putting the map together"))

        known_map = None if known is None else known.feature_map
        found, sweeps = map_recordings(mapper, read, known=known_map, follow=follow)
        prior = mapper.prior()
    conventions = conventions_of(opened)
    with progress.busy("checking the map"):
        quality = assess(found, rig, sweeps, conventions=conventions, has_rig_file=has_rig_file(opened))
        found = replace(found, quality=quality)
    offset_xy = (float(mapper.origin_xy[0]), float(mapper.origin_xy[1]))
    decisions = decisions_in_words([each.translated(offset_xy) for each in events], found)
    return MapResult(
        title=f"Map of {recordings.in_words}",
        run=Run(source=name or " ".join(read.names), method=method, start=None if start is None else fspath(start)),
        settings={"method": settings},
        plan=Plan(
            feature_map=found,
            truth=truth,
            detections=observations_of(mapper),
            echoes_xy=listener.points_xy,
            conventions=conventions,
        ),
        rig=rig,
        sweeps=tuple(mapped),
        decisions=decisions,
        grid=grid_of(mapper),
        known=None
        if prior is None
        else StartingMap(feature_map=found, prior=prior, origin_xy=mapper.origin_xy, sensors=sensors_of(rig)),
    )


def _mapper(method: Method, rig: Rig, settings: BaseModel, *, known: StartingMap | None) -> LocalMapper:
    """Return a mapper that begins anew, or that goes on from a map."""
    if known is None or not isinstance(settings, JointSettings):
        return method.build(rig, settings)
    mapper = JointMapper(rig, settings, prior=known.prior)
    return LocalMapper(mapper, rig, origin_xy=known.origin_xy)


def _checked(settings: BaseModel | Mapping[str, object] | None, settings_type: type[BaseModel]) -> BaseModel:
    if isinstance(settings, BaseModel) and not isinstance(settings, settings_type):
        remedy = f"pass {settings_type.__name__}, or a mapping"
        raise InputError("settings", f"{type(settings).__name__} has those of another method", remedy=remedy)
    return (
        settings if isinstance(settings, settings_type) else validated(settings_type, settings or {}, source="settings")
    )

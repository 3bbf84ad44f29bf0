"""What the commands that map leave in a folder: the map, its drawing, the report and the settings of the run."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from echoplan.cli.evaluate import evaluation_tables
from echoplan.cli.terminal import busy, put, report_files, show, tracked

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from pydantic import BaseModel

    from echoplan.arrays import FloatArray
    from echoplan.config import Run
    from echoplan.methods import Mapper
    from echoplan.model import FeatureMap, OccupancyGrid, Sweep
    from echoplan.viewer import Definitions, Plan, Section

__all__ = ["PICTURES", "RESULTS", "Results", "mapped", "results_folder", "say_what_was_found", "write_results"]

RESULTS = ("map.json", "map.svg", "report.html", "trajectory.tum", "run.toml")
# The folder of pictures in that of a demo.
PICTURES = "pictures"
_GRID = ("map.yaml", "map.pgm")


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """The results of a run.

    Parameters
    ----------
    title : str
        Title of the report.
    run : Run
        What was run.
    settings : mapping of str to BaseModel
        Settings of the stages by the name of their table.
    plan : Plan
        The map, and what lies beneath it.
    times : ndarray, shape (s,)
        When each sweep began [s].
    sections : tuple of Section, optional
        What else the report says, before the tables of the evaluation.
    grid : OccupancyGrid, optional
        What lies beneath the map of a method of grids.
    """

    title: str
    run: "Run"
    settings: "dict[str, BaseModel]"
    plan: "Plan"
    times: "FloatArray"
    sections: "tuple[Section, ...]" = ()
    grid: "OccupancyGrid | None" = None


def write_results(folder: Path, results: Results) -> None:
    """Write the files of ``RESULTS``, and ``map.yaml`` with its picture if there is a grid; all or none, and say so.

    Parameters
    ----------
    folder : Path
        Where to; it is made if it is not there. The grid that an earlier run left there goes.
    results : Results
        What the run came to.

    Raises
    ------
    OutputError
        If one of them cannot be written.
    """
    with results_folder(folder, results):
        pass
    report_files(folder, (*RESULTS, *(_GRID if results.grid is not None else ())))


@contextmanager
def results_folder(folder: Path, results: Results) -> Iterator[Path]:
    """Write the files of a run together with what the block writes; all or none.

    Parameters
    ----------
    folder : Path
        Where to; it is made if it is not there. Files of an earlier run that this one does not make go.
    results : Results
        What the run came to.

    Yields
    ------
    Path
        Where to write, instead of the folder.

    Raises
    ------
    OutputError
        If one of them cannot be written.
    """
    from echoplan.config import write_run  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import write_grid, write_map, write_text, write_trajectory, written_whole  # noqa: PLC0415
    from echoplan.viewer import PAPER_FIGURES, Report, plan_svg, report_html  # noqa: PLC0415

    plan = results.plan
    sections = (*results.sections, *_learned(plan), *_evaluated(plan), *_settings(results))
    optional = (*_GRID, *(f"{PICTURES}/{name}.png" for name in PAPER_FIGURES))
    with written_whole(folder, stale=optional if (folder / "run.toml").exists() else ()) as draft:
        write_map(draft / "map.json", plan.feature_map)
        write_text(draft / "map.svg", plan_svg(plan))
        write_text(draft / "report.html", report_html(Report(title=results.title, plan=plan, sections=sections)))
        write_trajectory(draft / "trajectory.tum", results.times, plan.feature_map.poses)
        write_run(draft / "run.toml", results.run, results.settings)
        if results.grid is not None:
            write_grid(draft / "map.yaml", results.grid)
        yield draft


def mapped(
    mapper: "Mapper", sweeps: "Sequence[Sweep]", listen: "Callable[[Iterable[Sweep]], Iterable[Sweep]]" = iter
) -> "FeatureMap":
    """Map sweeps, and show how far that is.

    Parameters
    ----------
    mapper : Mapper
        The mapper.
    sweeps : sequence of Sweep
        All sweeps, as recorded.
    listen : callable, optional
        Passes the cleaned sweeps on.

    Returns
    -------
    FeatureMap
        The map.
    """
    from echoplan.methods import map_sweeps  # noqa: PLC0415

    with ExitStack() as shown:

        def follow(cleaned: "Sequence[Sweep]") -> "Iterator[Sweep]":
            yield from listen(tracked(cleaned, total=len(cleaned), task="mapping"))
            shown.enter_context(busy("putting the map together"))

        return map_sweeps(mapper, sweeps, follow=follow)


def say_what_was_found(plan: "Plan") -> None:
    """Print whether a map can be trusted, a line about what is in it, and a table of its openings if it has any.

    Parameters
    ----------
    plan : Plan
        The map.
    """
    from echoplan.viewer import found_in_words, opening_table, quality_lines  # noqa: PLC0415

    if plan.feature_map.quality:
        for line in quality_lines(plan.feature_map.quality):
            put(line)
        put()
    put(found_in_words(plan.feature_map))
    if plan.feature_map.openings:
        put()
        show(opening_table(plan.feature_map.openings))
    for section in _learned(plan):
        for name, text in section.items:
            put(f"{name}: {text}")


def _learned(plan: "Plan") -> "tuple[Definitions, ...]":
    from echoplan.viewer import learned_in_words  # noqa: PLC0415

    return learned_in_words(plan.feature_map, plan.conventions)


def _evaluated(plan: "Plan") -> "tuple[Section, ...]":
    if plan.truth is None:
        return ()
    from echoplan.evaluation import evaluate  # noqa: PLC0415

    return evaluation_tables(evaluate(plan.feature_map, plan.truth))


def _settings(results: Results) -> "tuple[Section, ...]":
    from echoplan.viewer import Definitions, flattened  # noqa: PLC0415

    run = (("echoplan", results.run.version), ("source", results.run.source), ("method", results.run.method or ""))
    seed = () if results.run.seed is None else (("seed", str(results.run.seed)),)
    settings = {name: stage.model_dump(mode="json") for name, stage in results.settings.items()}
    return (Definitions(title="Settings of the run", items=(*run, *seed, *flattened(settings)), folded=True),)

"""The folder of results: the map, its drawing, the report, the trajectory and the settings of the run."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from echoplan.config import write_run
from echoplan.errors import EchoplanError
from echoplan.evaluation import evaluate, evaluation_tables
from echoplan.io import write_grid, write_map, write_text, write_trajectory, written_whole
from echoplan.mapping.exports import EXPORTS, Exportable, ExportFormat
from echoplan.mapping.start import PRIOR, write_prior
from echoplan.viewer import (
    PAPER_FIGURES,
    Definitions,
    Plan,
    Report,
    Section,
    changes_in_words,
    flattened,
    learned_in_words,
    plan_svg,
    report_html,
)

if TYPE_CHECKING:
    from echoplan.mapping.result import MapResult

__all__ = ["GRID", "PICTURES", "RESULTS", "results_folder"]

RESULTS = ("map.json", "map.svg", "report.html", "trajectory.tum", "run.toml")
# The folder of pictures in that of a demo.
PICTURES = "pictures"
GRID = ("map.yaml", "map.pgm")


@contextmanager
def results_folder(folder: Path, result: "MapResult", *, exports: Iterable[ExportFormat] = ()) -> Iterator[Path]:
    """Write the results of a run together with what the block writes; all or none.

    Parameters
    ----------
    folder : Path
        Where to; it is made if it does not exist.  Files of an earlier run that this one does not make go.
    result : MapResult
        The result of the run.
    exports : iterable of ExportFormat, optional
        Further formats.

    Yields
    ------
    Path
        Where to write, instead of the folder.

    Raises
    ------
    OutputError
        If one of them cannot be written.
    """
    plan = result.plan
    decisions = (result.decisions,) if result.decisions.items else ()
    learned = learned_in_words(plan.feature_map, plan.conventions)
    changes = changes_in_words(plan.feature_map.changes)
    sections = (*result.sections, *changes, *decisions, *learned, *_evaluated(plan), _settings(result))
    exported = (name for each in EXPORTS.values() for name in each.files)
    optional = {PRIOR, *GRID, *exported, *(f"{PICTURES}/{name}.png" for name in PAPER_FIGURES)}
    with written_whole(folder, stale=sorted(optional) if (folder / "run.toml").exists() else ()) as draft:
        write_map(draft / "map.json", plan.feature_map)
        write_text(draft / "map.svg", plan_svg(plan))
        write_text(draft / "report.html", report_html(Report(title=result.title, plan=plan, sections=sections)))
        write_trajectory(draft / "trajectory.tum", result.stamps_ns, plan.feature_map.poses)
        write_run(draft / "run.toml", result.run, result.settings)
        _write_other_forms(draft, result)
        failure = _export(draft, result.exportable, exports=exports)
        yield draft
    # A map may have taken hours: it is kept if it cannot be written in one more format.
    if failure:
        raise failure


def _write_other_forms(folder: Path, result: "MapResult") -> None:
    """Write the grid of a method that maps on one, and what a map can go on from."""
    if result.grid is not None:
        write_grid(folder / "map.yaml", result.grid)
    if result.known is not None:
        write_prior(folder, result.known)


def _export(folder: Path, content: Exportable, *, exports: Iterable[ExportFormat]) -> EchoplanError | None:
    """Write the formats that can be written, and return the error of one that cannot."""
    failure = None
    for each in exports:
        try:
            each.write(folder / each.files[0], content)
        except EchoplanError as error:
            failure = error
    return failure


def _evaluated(plan: Plan) -> tuple[Section, ...]:
    return () if plan.truth is None else evaluation_tables(evaluate(plan.feature_map, plan.truth))


def _settings(result: "MapResult") -> Definitions:
    run = (("echoplan", result.run.version), ("source", result.run.source), ("method", result.run.method or ""))
    start = (("start", result.run.start),) if result.run.start else ()
    seed = () if result.run.seed is None else (("seed", str(result.run.seed)),)
    settings = {name: stage.model_dump(mode="json") for name, stage in result.settings.items()}
    return Definitions(title="Settings of the run", items=(*run, *start, *seed, *flattened(settings)), folded=True)

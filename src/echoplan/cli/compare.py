"""``echoplan compare``: methods compared on the same recordings."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.evaluate import MinHeard, MinStations, replaces_min_heard
from echoplan.cli.source_options import FieldOption, MountOption, OdomOption, TopicOption, bag_options, put_notes
from echoplan.cli.terminal import Progressing, put, report_files, show, tracked
from echoplan.signals import raised_signals

if TYPE_CHECKING:
    from collections.abc import Sequence

    from echoplan.comparison import MethodScore, Subject
    from echoplan.io.ros import BagOptions

__all__ = ["run"]

_RESULTS = ("comparison.json", "comparison.csv", "comparison.html")


def run(
    sources: Annotated[
        list[str], typer.Argument(help="Recordings' folders, ROS bags, or sim:WORLD.", metavar="SOURCE...")
    ],
    truth: Annotated[
        Path | None, typer.Option(help="truth.json or its folder, for all; else the one beside each recording.")
    ] = None,
    methods: Annotated[str, typer.Option(help="Names of methods, separated by commas, or all.")] = "all",
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Folder for the page and the numbers.")] = None,
    min_stations: MinStations = 2,
    min_heard: MinHeard = None,
    jobs: Annotated[int, typer.Option(min=1, help="Processes at a time.")] = os.cpu_count() or 1,
    topic: TopicOption = None,
    odom: OdomOption = None,
    field: FieldOption = None,
    mount: MountOption = None,
) -> None:
    """Map the same recordings with several methods and compare the results.

    Example: echoplan compare sim:square sim:paper-room --methods mdp-fuzzy,rcd --out comparison/
    """
    # --help must not wait for NumPy.
    from echoplan.comparison import Trial, comparison_tables, run_trials, score_methods  # noqa: PLC0415
    from echoplan.io import check_folder  # noqa: PLC0415

    names = _chosen(methods)
    if out is not None:
        check_folder(out, _RESULTS)
    min_stations = replaces_min_heard(min_stations, min_heard)
    bag = bag_options(topic, odom, field, mount)
    distinct = list(dict.fromkeys(sources))
    subjects = [_subject(source, truth, bag, min_stations=min_stations) for source in distinct]
    trials = [Trial(subject=subject, method=name) for subject in subjects for name in names]
    done = tracked(run_trials(trials, workers=jobs), total=len(trials), task="comparing")
    with raised_signals():
        outcomes = sorted(done, key=lambda outcome: distinct.index(outcome.trial.subject.name))
    scores = score_methods(outcomes, names)
    for table in comparison_tables(scores):
        show(table)
    if out is not None:
        _write(out, scores)


def _chosen(methods: str) -> list[str]:
    from echoplan.methods import METHODS, find_method  # noqa: PLC0415 - --help must not wait for NumPy

    names = list(METHODS) if methods == "all" else methods.split(",")
    return [find_method(name).name for name in dict.fromkeys(names)]


def _subject(text: str, truth: Path | None, bag: "BagOptions | None", *, min_stations: int) -> "Subject":
    from echoplan.comparison import Subject  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.diagnosis import faults_in_words  # noqa: PLC0415
    from echoplan.io import read_truth  # noqa: PLC0415
    from echoplan.model import Recording  # noqa: PLC0415
    from echoplan.preprocessing import find_faults  # noqa: PLC0415
    from echoplan.sources import find_truth, open_source  # noqa: PLC0415

    opened = open_source(text, bag=bag)
    put_notes(opened)
    sweeps = tuple(Progressing(opened, f"reading {text}"))
    for sentence in faults_in_words(find_faults(sweeps, opened.rig)):
        put(f"{text}: {sentence}")
    return Subject(
        name=text,
        recording=Recording(name=opened.name, rig=opened.rig, sweeps=sweeps),
        truth=read_truth(truth) if truth else find_truth(opened),
        min_stations=min_stations,
    )


def _write(folder: Path, scores: "Sequence[MethodScore]") -> None:
    from echoplan.comparison import comparison_csv, comparison_document, comparison_page  # noqa: PLC0415
    from echoplan.io import write_text, written_whole  # noqa: PLC0415
    from echoplan.io.text import format_json  # noqa: PLC0415

    with written_whole(folder) as draft:
        write_text(draft / "comparison.json", format_json(comparison_document(scores)))
        write_text(draft / "comparison.csv", comparison_csv(scores))
        write_text(draft / "comparison.html", comparison_page(scores))
    report_files(folder, _RESULTS)

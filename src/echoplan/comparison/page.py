"""The page of a comparison: the table, and all maps over the truth."""

from collections.abc import Sequence
from math import isnan

from echoplan.comparison.scores import MethodScore
from echoplan.comparison.tables import comparison_tables
from echoplan.comparison.trials import Outcome
from echoplan.viewer import Exhibit, Gallery, Plan, gallery_html

__all__ = ["comparison_page"]


def comparison_page(scores: Sequence[MethodScore]) -> str:
    """Write a comparison as one page, a group of maps a recording, a map a method.

    Parameters
    ----------
    scores : sequence of MethodScore
        What each method reached.

    Returns
    -------
    str
        An HTML document without references to other files.
    """
    outcomes = [outcome for score in scores for outcome in score.outcomes]
    subjects = {outcome.trial.subject.name: outcome.trial.subject for outcome in outcomes}
    return gallery_html(
        Gallery(
            title=f"{_counted(len(scores), 'method')}, side by side",
            lead=f"{_counted(len(subjects), 'recording')}, "
            f"{_counted(sum(subject.pings for subject in subjects.values()), 'ping')}.",
            rooms=tuple(
                (name, tuple(_exhibit(each) for each in outcomes if each.trial.subject.name == name))
                for name in subjects
            ),
            sections=comparison_tables(scores),
        )
    )


def _counted(count: int, noun: str) -> str:
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def _exhibit(outcome: Outcome) -> Exhibit:
    if outcome.feature_map is None:
        return Exhibit(name=outcome.trial.method, words=f"failed: {outcome.failure}")
    plan = Plan(
        feature_map=outcome.feature_map,
        truth=outcome.trial.subject.truth,
        echoes_xy=outcome.points_xy,
        grid=outcome.grid,
    )
    numbers = (*_rightness(outcome), ("time", f"{outcome.seconds:.2f} s"))
    return Exhibit(name=outcome.trial.method, plan=plan, numbers=numbers)


def _rightness(outcome: Outcome) -> tuple[tuple[str, str], ...]:
    if outcome.evaluation is None:
        return ()
    tally, error = outcome.evaluation.matches.walls.tally, outcome.evaluation.map_error.mean
    return (
        ("walls", f"{tally.found} of {tally.wanted}"),
        ("extra walls", f"{tally.estimates - tally.right}"),
        ("error", "-" if isnan(error) else f"{1000 * error:.1f} mm"),
    )

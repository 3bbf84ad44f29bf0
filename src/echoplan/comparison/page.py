"""The page of a comparison: the table, and all maps over the truth."""

from collections.abc import Sequence

from echoplan.comparison.scores import MethodScore
from echoplan.comparison.tables import failure_table, score_table
from echoplan.comparison.trials import Outcome
from echoplan.viewer import Exhibit, Gallery, Plan, gallery_html

__all__ = ["comparison_page"]


def comparison_page(scores: Sequence[MethodScore]) -> str:
    """Write a comparison as one page, a row of maps a recording, a column a method.

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
    subjects = dict.fromkeys(outcome.trial.subject.name for outcome in outcomes)
    tables = (score_table(scores), failure_table(outcomes))
    return gallery_html(
        Gallery(
            title="Comparison of methods",
            lead=f"Methods: {len(scores)}. Recordings: {len(subjects)}.",
            sections=tuple(table for table in tables if table.rows),
            columns=tuple(score.method for score in scores),
            rows=tuple(
                (name, tuple(_exhibit(each) for each in outcomes if each.trial.subject.name == name))
                for name in subjects
            ),
        )
    )


def _exhibit(outcome: Outcome) -> Exhibit:
    if outcome.feature_map is None:
        return Exhibit(caption=f"failed: {outcome.failure}")
    return Exhibit(
        caption=_caption(outcome), plan=Plan(feature_map=outcome.feature_map, truth=outcome.trial.subject.truth)
    )


def _caption(outcome: Outcome) -> str:
    cost = f"{1000 * outcome.seconds_per_thousand_pings:.0f} ms / 1000 pings"
    if outcome.evaluation is None:
        return cost
    tally = outcome.evaluation.matches.walls.tally
    return (
        f"walls {tally.found} of {tally.wanted}, {tally.estimates - tally.right} too many; "
        f"map error {1000 * outcome.evaluation.map_error.mean:.0f} mm; {cost}"
    )

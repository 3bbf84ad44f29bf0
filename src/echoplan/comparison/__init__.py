"""Methods compared on the same recordings: run apart, scored alike, shown side by side."""

from echoplan.comparison.documents import comparison_csv, comparison_document
from echoplan.comparison.page import comparison_page
from echoplan.comparison.running import run_trials
from echoplan.comparison.scores import MethodScore, score_methods
from echoplan.comparison.tables import comparison_tables, failure_table, score_table
from echoplan.comparison.trials import Outcome, Subject, Trial, measure

__all__ = [
    "MethodScore",
    "Outcome",
    "Subject",
    "Trial",
    "comparison_csv",
    "comparison_document",
    "comparison_page",
    "comparison_tables",
    "failure_table",
    "measure",
    "run_trials",
    "score_methods",
    "score_table",
]

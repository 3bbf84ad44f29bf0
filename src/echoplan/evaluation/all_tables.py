"""All tables of an evaluation, as the terminal and the report show them."""

from echoplan.evaluation.evaluation import Evaluation
from echoplan.evaluation.floor_plan_tables import floor_plan_tables
from echoplan.evaluation.tables import (
    confusion_table,
    consistency_table,
    cylinder_table,
    tally_table,
    wall_table,
)
from echoplan.evaluation.trajectory import trajectory_table
from echoplan.model import Table

__all__ = ["evaluation_tables"]


def evaluation_tables(evaluation: Evaluation) -> tuple[Table, ...]:
    """Lay out an evaluation as tables.

    Parameters
    ----------
    evaluation : Evaluation
        Of one map.

    Returns
    -------
    tuple of Table
        Walls, cylinders, recall and precision, wall lengths, openings, classes, consistency, poses; without those that
        would be empty.
    """
    tables = (
        wall_table(evaluation.matches.walls),
        cylinder_table(evaluation.matches.cylinders),
        tally_table({name: matching.tally for name, matching in evaluation.matches.by_class.items()}),
        *floor_plan_tables({evaluation.method: evaluation.floor_plan}, rows="method"),
        confusion_table(evaluation.confusion),
        consistency_table(evaluation.consistency),
        trajectory_table(evaluation.trajectory),
    )
    return tuple(table for table in tables if table.rows)

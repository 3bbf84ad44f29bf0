"""What the commands that map print about the result."""

from typing import TYPE_CHECKING

from echoplan.cli.terminal import put, show

if TYPE_CHECKING:
    from echoplan.viewer import Plan

__all__ = ["say_what_was_found"]


def say_what_was_found(plan: "Plan") -> None:
    """Print whether a map can be trusted, a line about what is in it, and a table of its openings if it has any."""
    from echoplan.viewer import (  # noqa: PLC0415
        changes_in_words,
        found_in_words,
        learned_in_words,
        opening_table,
        quality_lines,
    )

    if plan.feature_map.quality:
        for line in quality_lines(plan.feature_map.quality):
            put(line)
        put()
    put(found_in_words(plan.feature_map))
    if plan.feature_map.openings:
        put()
        show(opening_table(plan.feature_map.openings))
    changes = changes_in_words(plan.feature_map.changes)
    for section in (*changes, *learned_in_words(plan.feature_map, plan.conventions)):
        for name, text in section.items:
            put(f"{name}: {text}")

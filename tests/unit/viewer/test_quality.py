"""Whether a map can be trusted is said first, wherever a map is shown."""

from dataclasses import replace

import pytest

from echoplan.model import FeatureMap, Quality, Verdict
from echoplan.viewer import Plan, Report, plan_svg, quality_lines, report_html

FAILED = Quality(verdict=Verdict.FAILED, reasons=("Nothing fits.",), next_step="Record again.")
EMPTY = FeatureMap(method="joint")


def plan(quality: Quality | None) -> Plan:
    return Plan(feature_map=replace(EMPTY, quality=quality))


def test_the_verdict_comes_first_and_the_next_step_last() -> None:
    assert quality_lines(FAILED) == (
        "Failed map: it does not show the room.",
        "Nothing fits.",
        "Next step: Record again.",
    )


@pytest.mark.parametrize("verdict", Verdict)
def test_every_verdict_has_a_headline_that_begins_with_it(verdict: Verdict) -> None:
    assert quality_lines(Quality(verdict=verdict))[0].lower().startswith(verdict)


def test_a_report_has_the_verdict_at_its_head() -> None:
    page = report_html(Report(title="Map of a room", plan=plan(FAILED)))
    assert page.index("Failed map") < page.index("Record again.") < page.index("<main>")


def test_a_drawing_of_a_failed_map_says_so_and_one_of_a_good_map_nothing() -> None:
    assert plan_svg(plan(FAILED)).count("Failed map") == 2
    assert "map:" not in plan_svg(plan(Quality(verdict=Verdict.GOOD)))
    assert "map:" not in plan_svg(plan(None))

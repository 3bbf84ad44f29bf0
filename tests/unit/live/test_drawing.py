import json

import numpy as np
import pytest

from echoplan.live.drawing import drawing_of
from echoplan.live.mapping import draw_map
from echoplan.live.survey import Survey
from echoplan.viewer.plan import Plan
from helpers.drawings import full_plan, gapped_map
from helpers.fed import RIG


def test_all_that_a_map_has_is_drawn_with_what_is_known_of_it() -> None:
    plan = full_plan()
    drawn = json.loads(json.dumps(drawing_of(plan), allow_nan=False))
    found = plan.feature_map
    for kind in ("walls", "corners", "cylinders", "poses"):
        assert len(drawn[kind]) == len(getattr(found, kind))
        assert all(each["facts"] for each in drawn[kind])
    face = np.array(drawn["walls"][0]["observed"][0])[:2]
    assert face == pytest.approx(found.walls[0].endpoints_xy, abs=1e-4)
    assert {each["kind"] for each in drawn["corners"]} == {"concave", "convex"}
    assert drawn["echoes"] == plan.echoes_xy.tolist()


def test_gaps_and_inferred_ends_are_drawn_apart() -> None:
    found = gapped_map()
    drawn = drawing_of(Plan(feature_map=found))
    assert [each["width"] for each in drawn["openings"]] == ["0.90 m", "0.25 m"]  # type: ignore[attr-defined]
    assert len(drawn["unobserved"]) == 1  # type: ignore[arg-type]
    inferred = [len(each["inferred"]) for each in drawn["walls"]]  # type: ignore[attr-defined]
    assert inferred == [0, 0, 0, 1]


def test_uncertainty_is_enlarged_as_often_as_the_drawing_says() -> None:
    plan = full_plan()
    drawn = drawing_of(plan)
    times, ellipse = drawn["magnification"], plan.ellipses[0]
    assert isinstance(times, int)
    _, _, long, short, _ = drawn["corners"][0]["ellipse"]  # type: ignore[index]
    assert [long, short] == pytest.approx((times * ellipse.semi_axes).tolist(), abs=1e-4)


def test_a_survey_without_sweeps_has_an_empty_map() -> None:
    drawn = json.loads(draw_map(Survey(name="bench", rig=RIG)))
    assert drawn["topic"] == "map"
    assert not any(drawn[kind] for kind in ("walls", "openings", "corners", "cylinders", "poses", "echoes"))

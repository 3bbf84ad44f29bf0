from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from echoplan.model import FeatureClass, FeatureMap, Truth
from echoplan.viewer import pictures
from echoplan.viewer.pictures import map_picture, paper_pictures
from echoplan.viewer.plan import Plan
from echoplan.viewer.sections import Picture
from echoplan.viewer.stages import Located, SweepStages, WallProfile, wall_profile
from helpers import chamber
from helpers.drawings import full_plan
from helpers.maps import drawn, wall

NOTHING = Plan(feature_map=FeatureMap(method="none"))
SQUARE = (wall([1.0, -0.6], [1.0, 0.8]), wall([1.0, 0.8], [-1.2, 0.8]))
STEMS = [
    "figure-02-ranges",
    "figure-05-fit",
    "figure-07-memberships",
    "figure-10-filter",
    "figure-11-clusters",
    "figure-12-classes",
    "figure-13-map",
]


@pytest.fixture(scope="module")
def made() -> tuple[Picture, ...]:
    return paper_pictures(chamber.staged(), Plan(feature_map=drawn(*SQUARE)))


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which pictures are made matters here, not their pixels."""
    monkeypatch.setattr(pictures, "png", lambda figure: b"")


def stems(*args: object) -> list[str]:
    return [each.name for each in paper_pictures(*args)]  # type: ignore[arg-type]


def test_all_figures_come_in_the_order_of_the_paper(made: tuple[Picture, ...]) -> None:
    assert [each.name for each in made] == STEMS


def test_every_picture_has_a_title_and_says_what_is_to_be_seen(made: tuple[Picture, ...]) -> None:
    assert len({each.title for each in made}) == len({each.caption for each in made}) == 7
    for each in made:
        assert each.caption.endswith(".")
        assert len(each.caption) > len(each.title)


def test_every_picture_is_a_png_of_one_width(made: tuple[Picture, ...]) -> None:
    for each in made:
        assert each.png.startswith(b"\x89PNG\r\n\x1a\n")
        assert Image.open(BytesIO(each.png)).size[0] == 1260


def test_a_map_by_any_method_is_the_same_picture_under_another_name(made: tuple[Picture, ...]) -> None:
    drawing = map_picture(Plan(feature_map=drawn(*SQUARE)))
    assert (drawing.name, drawing.png) == ("map", made[-1].png)


def test_no_two_pictures_show_the_same(made: tuple[Picture, ...]) -> None:
    assert len({each.png for each in made}) == 7


@pytest.mark.usefixtures("unrendered")
def test_no_detections_leave_the_membership_functions_and_the_map() -> None:
    assert stems([], NOTHING) == ["figure-07-memberships", "figure-13-map"]


@pytest.mark.usefixtures("unrendered")
def test_where_no_wall_was_detected_there_is_neither_its_profile_nor_its_fit() -> None:
    stages = chamber.staged()[0]
    others = tuple(each for each in stages.located if each.feature_class is not FeatureClass.WALL)
    assert stems([replace(stages, located=others)], full_plan()) == STEMS[2:]


@pytest.mark.usefixtures("unrendered")
def test_a_wall_that_is_in_no_map_has_a_fit_and_no_profile() -> None:
    assert stems(chamber.staged(), NOTHING) == STEMS[1:]


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("known", [True, False])
def test_distances_are_compared_with_the_true_wall_where_it_is_known(
    monkeypatch: pytest.MonkeyPatch,
    known: bool,  # noqa: FBT001 - both cases
) -> None:
    profiles = []

    def spy(located: Located, lines: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> WallProfile | None:
        profiles.append(wall_profile(located, lines))
        return profiles[-1]

    monkeypatch.setattr(pictures, "wall_profile", spy)
    truth = Truth(walls_xy=np.array([[[1.03, -1.0], [1.03, 1.0]]]), walls_detected_by=np.array([1]))
    stems(chamber.staged(), Plan(feature_map=drawn(*SQUARE), truth=truth if known else None))
    (profile,) = profiles
    assert profile is not None
    assert profile.distance == pytest.approx(1.03 if known else 1.0)


@pytest.mark.usefixtures("unrendered")
def test_clusters_are_shown_of_the_station_that_has_most(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[SweepStages] = []
    monkeypatch.setattr(pictures, "cluster_figure", shown.append)
    first, second = chamber.staged()
    poor = replace(first, located=first.located[:2])
    paper_pictures([poor, second, poor], NOTHING)
    assert shown == [second]

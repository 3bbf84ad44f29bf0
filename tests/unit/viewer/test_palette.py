"""What the palette claims of itself is computed here: contrast by WCAG 2.1, lightness and differences by CIE 1976."""

import itertools
import re
from importlib.resources import files

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.model import FeatureClass
from echoplan.viewer import palette
from echoplan.viewer.palette import COLORS, FAINT, INK, MARKERS, MUTED, TRUTH

# sRGB (IEC 61966-2-1) to XYZ, white D65.
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = XYZ.sum(axis=1)
# What eyes without one kind of receptor see, in linear sRGB (Machado, Oliveira and Fernandes 2009, severity 1).
BLIND = {
    "red": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "green": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]]),
    "blue": np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]]),
    "none": np.eye(3),
}


def linear(color: str) -> FloatArray:
    """Linear sRGB of a colour such as ``#17375e``."""
    values = np.array([int(color[start : start + 2], 16) for start in (1, 3, 5)]) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(light: FloatArray) -> FloatArray:
    """CIE L*a*b* of linear sRGB."""
    ratios = XYZ @ np.clip(light, 0.0, 1.0) / WHITE
    x, y, z = np.where(ratios > (6 / 29) ** 3, np.cbrt(ratios), ratios / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def contrast_with_white(color: str) -> float:
    return 1.05 / (float(XYZ[1] @ linear(color)) + 0.05)


def css(name: str) -> str:
    return files("echoplan.viewer").joinpath(name).read_text(encoding="utf-8")


def test_every_class_has_its_colour_and_its_mark() -> None:
    assert set(COLORS) == set(FeatureClass)
    assert set(MARKERS) == set(FeatureClass)
    assert len(set(COLORS.values())) == len(set(MARKERS.values())) == 3


@pytest.mark.parametrize(("feature_class", "lightness"), [("wall", 23), ("cylinder", 61), ("corner", 49)])
def test_the_classes_differ_in_lightness_as_documented(feature_class: str, lightness: int) -> None:
    assert str(lightness) in (palette.__doc__ or "")
    assert lab(linear(COLORS[FeatureClass(feature_class)]))[0] == pytest.approx(lightness, abs=0.5)


@pytest.mark.parametrize("feature_class", FeatureClass)
def test_each_class_stands_out_against_white(feature_class: FeatureClass) -> None:
    assert contrast_with_white(COLORS[feature_class]) >= 3.0


@pytest.mark.parametrize("color", [INK, MUTED])
def test_words_can_be_read_on_white(color: str) -> None:
    assert contrast_with_white(color) >= 4.5


@pytest.mark.parametrize("missing", BLIND)
@pytest.mark.parametrize("pair", list(itertools.combinations(FeatureClass, 2)), ids="-".join)
def test_the_colour_blind_can_distinguish_any_two_classes(
    pair: tuple[FeatureClass, FeatureClass], missing: str
) -> None:
    first, second = (lab(BLIND[missing] @ linear(COLORS[each])) for each in pair)
    assert np.linalg.norm(first - second) >= 38


def test_the_grid_is_fainter_than_words_about_it() -> None:
    assert contrast_with_white(FAINT) < 2.0 < contrast_with_white(MUTED)


def test_neither_colours_nor_marks_can_be_changed() -> None:
    with pytest.raises(TypeError):
        COLORS[FeatureClass.WALL] = "#000000"  # type: ignore[index]
    with pytest.raises(TypeError):
        MARKERS[FeatureClass.WALL] = "x"  # type: ignore[index]


@pytest.mark.parametrize("feature_class", FeatureClass)
def test_drawings_and_figures_agree_about_the_colour_of_a_class(feature_class: FeatureClass) -> None:
    rule = re.search(rf"\.beam\.{feature_class} {{ stroke: (#\w+); }}", css("map.css"))
    assert rule is not None
    assert rule[1] == COLORS[feature_class]


def test_drawings_use_no_colour_but_those_of_the_palette_and_white() -> None:
    own = {*COLORS.values(), INK, MUTED, FAINT, TRUTH, "#ffffff"}
    assert set(re.findall(r"#[0-9a-fA-F]{6}", css("map.css"))) <= own

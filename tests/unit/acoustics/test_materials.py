import numpy as np
import pytest

from echoplan.acoustics import material_names, reflection_coefficients
from echoplan.errors import UnknownNameError


def test_every_material_returns_some_sound_and_none_more_than_all() -> None:
    gains = reflection_coefficients(material_names())
    assert (gains > 0).all()
    assert (gains <= 1).all()


def test_metal_glass_concrete_and_wood_differ_by_less_than_a_third_of_a_decibel() -> None:
    gains = reflection_coefficients(["metal", "glass", "concrete", "wood"])
    assert np.ptp(20 * np.log10(gains)) < 0.33


def test_soft_materials_swallow_more_than_hard_ones() -> None:
    hard, door, carpet, curtain, foam = reflection_coefficients(["hard", "door", "carpet", "curtain", "foam"])
    assert hard == 1.0
    assert hard > door > carpet > curtain > foam


def test_no_material_has_no_coefficient() -> None:
    assert reflection_coefficients([]).shape == (0,)


def test_an_unknown_material_is_named_with_the_nearest_known_one() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown material 'curtian'; did you mean 'curtain'\?"):
        reflection_coefficients(["wood", "curtian"])

import numpy as np
import pytest

from echoplan.acoustics import cylinder_echo, plane_echo, plate_echo, strip_echo
from echoplan.arrays import FloatArray
from helpers.oracles import bistatic_cylinder_echo

WAVELENGTH = 0.0086


def test_a_plane_echoes_like_the_image_of_the_source() -> None:
    np.testing.assert_allclose(plane_echo([0.5, 1.0, 2.0]), [1.0, 0.5, 0.25])


@pytest.mark.parametrize("radius", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("distance", [0.3, 1.0, 2.5])
def test_a_cylinder_echoes_as_the_integral_of_kirchhoff_says(radius: float, distance: float) -> None:
    # The lit half of the cylinder radiates what it reflects: the integral over its angle and height, the latter by
    # stationary phase, relative to the same for a plane.
    wavenumber = 2 * np.pi / WAVELENGTH
    assert cylinder_echo(distance, radius) == pytest.approx(kirchhoff(distance, radius, wavenumber), rel=0.01)


def kirchhoff(distance: float, radius: float, wavenumber: float) -> float:
    horizon = np.arccos(radius / (radius + distance))
    angle = np.linspace(-horizon, horizon, 200_001)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    away = np.hypot(distance + radius - x, y)
    facing = (np.cos(angle) * (distance + radius - x) - np.sin(angle) * y) / away
    # Tapered towards the horizon, which would diffract if it were an edge.
    taper = np.cos(np.pi / 2 * angle / horizon) ** 2
    upright = np.sqrt(np.pi * away / wavenumber)
    integrand = facing * taper * upright * np.exp(-2j * wavenumber * away) / away**2
    return float(wavenumber / (2 * np.pi) * abs(np.trapezoid(integrand, radius * angle)))


def test_a_huge_cylinder_is_a_plane() -> None:
    assert cylinder_echo(1.0, 1e6) == pytest.approx(plane_echo(1.0), rel=1e-6)


def test_at_normal_incidence_and_equal_ways_the_bistatic_cylinder_is_the_plain_one() -> None:
    distance = np.array([0.2, 1.0, 3.0])
    np.testing.assert_allclose(
        bistatic_cylinder_echo(distance, distance, 0.1, incidence=0.0), cylinder_echo(distance, 0.1)
    )


def test_a_huge_bistatic_cylinder_is_a_plane() -> None:
    assert bistatic_cylinder_echo(0.7, 1.3, 1e9, incidence=0.5) == pytest.approx(1 / 2.0)


def test_the_bistatic_cylinder_thins_a_bundle_of_rays_as_geometry_does() -> None:
    # Two rays from a point source, a hair apart, in the plane: their distance at the receiver gives the amplitude.
    source, radius = np.array([-1.0, 0.9]), 0.3
    for angle in (1.5, 2.0, 2.9):
        reflected = [ray(source, radius, angle + shift) for shift in (-1e-6, 1e-6)]
        (start, way), (other, other_way) = reflected
        out = 0.8
        apart = (other + out * other_way) - (start + out * way)
        width = abs(way[0] * apart[1] - way[1] * apart[0])
        begun = np.arctan2(*(other - source)[::-1]) - np.arctan2(*(start - source)[::-1])
        incoming = float(np.hypot(*(start - source)))
        normal = np.array([np.cos(angle), np.sin(angle)])
        incidence = float(np.arccos(normal @ (source - start) / incoming))
        expected = np.sqrt(abs(begun) / width / (incoming + out))
        assert bistatic_cylinder_echo(incoming, out, radius, incidence=incidence) == pytest.approx(expected, rel=1e-4)


def ray(source: FloatArray, radius: float, angle: float) -> tuple[FloatArray, FloatArray]:
    normal = np.array([np.cos(angle), np.sin(angle)])
    point = radius * normal
    way = (point - source) / np.hypot(*(point - source))
    return point, way - 2 * (way @ normal) * normal


def test_a_narrow_strip_echoes_by_its_width_and_a_wide_one_as_a_plane() -> None:
    narrow = strip_echo(1.0, [0.005, 0.01], wavelength=WAVELENGTH)
    assert narrow[1] == pytest.approx(2 * narrow[0])
    assert strip_echo(1.0, 1.0, wavelength=WAVELENGTH) == plane_echo(1.0)


def test_a_narrow_strip_echoes_as_the_integral_of_kirchhoff_says() -> None:
    distance, width = 2.0, 0.0254
    across = np.linspace(-width / 2, width / 2, 2001)
    away = np.hypot(distance, across)
    bent = np.trapezoid(np.exp(-2j * np.pi * 2 / WAVELENGTH * (away - distance)), across)
    whole = np.sqrt(WAVELENGTH * distance / 2)  # the same integral over an endless plane
    expected = plane_echo(distance) * abs(bent) / whole
    assert strip_echo(distance, width, wavelength=WAVELENGTH) == pytest.approx(expected, rel=0.02)


def test_a_plate_is_a_strip_in_both_directions() -> None:
    wide = plate_echo(2.0, 0.03, 10.0, wavelength=WAVELENGTH)
    assert wide == strip_echo(2.0, 0.03, wavelength=WAVELENGTH)
    assert plate_echo(2.0, 0.03, 0.04, wavelength=WAVELENGTH) < wide

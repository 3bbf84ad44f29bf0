import numpy as np
import pytest
from scipy.integrate import quad

from echoplan.acoustics import edge_echo, fresnel_tail, plane_echo, wedge_coefficient
from echoplan.arrays import FloatArray
from helpers.oracles import transition

K = 732.3
BOX, BLADE = 1.5 * np.pi, 2 * np.pi


def keller(incident: float, observed: float, opening: float) -> float:
    """Keller's coefficient of a hard wedge, without its phase."""
    n = opening / np.pi
    minus, plus = observed - incident, observed + incident
    terms = sum(1 / (np.cos(np.pi / n) - np.cos(angle / n)) for angle in (minus, plus))
    return float(np.sin(np.pi / n) / (n * np.sqrt(2 * np.pi * K)) * terms)


@pytest.mark.parametrize(("distance", "level"), [(0.3, -31.0), (1.0, -36.0), (2.0, -39.0)])
def test_the_edge_of_a_box_is_that_much_fainter_than_a_plane(distance: float, level: float) -> None:
    echo = edge_echo(distance, angle=BOX / 2, opening=BOX, wavenumber=K)
    assert 20 * np.log10(abs(echo) / plane_echo(distance)) == pytest.approx(level, abs=0.5)


def test_on_its_bisector_a_box_has_kellers_coefficient() -> None:
    found = abs(wedge_coefficient(BOX / 2, BOX / 2, opening=BOX, wavenumber=K, distance_parameter=0.5))
    assert found == pytest.approx(0.0113, abs=5e-5)
    assert found == pytest.approx(abs(keller(BOX / 2, BOX / 2, BOX)), rel=0.01)


@pytest.mark.parametrize("opening", [BOX, BLADE, 1.2 * np.pi, 0.7 * np.pi])
def test_far_away_kellers_theory_remains(opening: float) -> None:
    incident, observed = 0.31 * opening, 0.47 * opening
    found = wedge_coefficient(incident, observed, opening=opening, wavenumber=K, distance_parameter=1e6)
    assert abs(found) == pytest.approx(abs(keller(incident, observed, opening)), rel=1e-3)


@pytest.mark.parametrize(
    "opening",
    [BLADE, BOX, 1.1 * np.pi, 0.8 * np.pi],
    ids=["end of a wall", "box", "blunt edge", "blunt corner"],
)
def test_the_field_before_a_face_goes_on_where_its_reflection_ends(opening: float) -> None:
    # A sonar 1 m before a face passes the end of it: the reflection jumps, the sum with the diffraction does not.
    shift = np.array([-2e-6, 2e-6])
    total = reflected(shift) + diffracted(shift, opening)
    assert abs(total[1] - total[0]) < 1e-3
    assert abs(total).mean() == pytest.approx(0.25, abs=0.02)


def reflected(shift: FloatArray) -> FloatArray:
    """Reflection of a face that begins at 0 and lies 1 m before the sonar."""
    return np.where(shift > 0, plane_echo(1.0), 0.0)


def diffracted(shift: FloatArray, opening: float) -> FloatArray:
    """Diffraction at its end, with the phase relative to the reflection."""
    away = np.hypot(shift, 1.0)
    angle = np.arctan2(1.0, shift)
    field: FloatArray = edge_echo(away, angle=angle, opening=opening, wavenumber=K) * np.exp(-2j * K * (away - 1.0))
    return field


def test_on_the_boundary_itself_no_face_leans_either_way() -> None:
    total = plane_echo(1.0) / 2 + diffracted(np.zeros(1), BLADE)
    beside = plane_echo(1.0) + diffracted(np.array([1e-6]), BLADE)
    assert abs(total[0]) == pytest.approx(abs(beside[0]), abs=1e-3)


@pytest.mark.parametrize("angle", np.radians([10.0, 30.0, 45.0, 80.0]))
def test_inside_a_right_angle_the_mirror_images_are_everything(angle: float) -> None:
    inside = wedge_coefficient(angle, angle, opening=np.pi / 2, wavenumber=K, distance_parameter=0.5)
    assert abs(inside) == pytest.approx(0.0, abs=1e-12)


def test_a_corner_a_little_off_the_right_angle_echoes_nearly_like_one() -> None:
    # Beyond 90 degrees the double bounce is lost to rays; by diffraction it fades within a few degrees.
    distance = 1.5
    openings = np.radians([90.001, 92.0, 95.0, 100.0])
    echo = abs(edge_echo(distance, angle=openings / 2, opening=openings, wavenumber=K)) / plane_echo(distance)
    assert echo[0] == pytest.approx(1.0, abs=0.01)
    assert (np.diff(echo) < 0).all()
    assert echo[-1] < 0.1


def test_faces_that_swallow_sound_diffract_less() -> None:
    edges = [
        wedge_coefficient(BOX / 2, BOX / 2, opening=BOX, wavenumber=K, distance_parameter=0.5, reflection=(gain, gain))
        for gain in (1.0, 0.2)
    ]
    hard, soft = np.abs(edges)
    assert soft < hard


def test_the_transition_function_is_its_integral() -> None:
    # The path of integration is turned to where the integrand falls.
    turn = np.exp(-0.25j * np.pi)

    def integrand(t: float, x: float) -> complex:
        return complex(turn * np.exp(-1j * (np.sqrt(x) + turn * t) ** 2))

    for x in (0.1, 1.0, 4.0):
        integral, _ = quad(integrand, 0, 12, args=(x,), complex_func=True)
        assert transition(x) == pytest.approx(2j * np.sqrt(x) * np.exp(1j * x) * integral, abs=1e-9)


def test_the_tail_begins_at_one_half_and_ends_as_its_asymptote() -> None:
    assert fresnel_tail(0.0) == pytest.approx(0.5 + 0.5j)
    z = 30.0
    assert fresnel_tail(z) == pytest.approx(1 / (np.pi * z) + 1j / (np.pi**2 * z**3), rel=1e-5)

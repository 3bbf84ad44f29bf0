import numpy as np
import pytest

from echoplan.acoustics import (
    Air,
    audible_half_angle,
    cylinder_echo,
    edge_echo,
    plane_echo,
    plate_echo,
    reach,
    signal_excess,
    strip_echo,
    typical_transducer,
    wavenumber,
)
from echoplan.arrays import FloatArray
from echoplan.model import Sensor, Transducer

HC_SR04 = Transducer()
ROOM = Air()
# G. Dyrkacz measured HC-SR04 in this air: https://github.com/GaryDyr/HC-SR04-beam-tests
MEASURED_IN = Air(temperature=16.7, relative_humidity=0.32)
WAVELENGTH = MEASURED_IN.speed_of_sound / HC_SR04.frequency


def full_width(amplitude: FloatArray, path_length: float, transducer: Transducer = HC_SR04) -> float:
    """Visible width [degrees] in a room."""
    return float(2 * np.degrees(audible_half_angle(amplitude, path_length, transducer=transducer, air=ROOM)))


def test_a_panel_is_detected_as_far_off_the_axis_as_measured() -> None:
    angle = audible_half_angle(plane_echo(2.0), 4.0, transducer=HC_SR04, air=MEASURED_IN)
    assert np.degrees(angle) == pytest.approx(23.5, rel=0.05)


def test_a_strip_is_detected_as_far_away_as_measured() -> None:
    found = reach(lambda r: strip_echo(r, 0.0254, wavelength=WAVELENGTH), transducer=HC_SR04, air=MEASURED_IN)
    assert found == pytest.approx(2.45, rel=0.05)


def test_a_plate_is_detected_as_far_away_as_measured() -> None:
    found = reach(lambda r: plate_echo(r, 0.033, 0.038, wavelength=WAVELENGTH), transducer=HC_SR04, air=MEASURED_IN)
    assert found == pytest.approx(1.70, rel=0.05)


def test_the_measured_cylinder_fades_within_the_measured_bracket() -> None:
    radius = 3.5 * 0.0254 / 2
    found = reach(lambda r: cylinder_echo(r, radius), transducer=HC_SR04, air=MEASURED_IN)
    assert found == pytest.approx(1.72, rel=0.05)
    assert 1.66 < found < 2.29


def test_a_wall_is_detected_as_far_as_data_sheets_say() -> None:
    found = reach(plane_echo, transducer=HC_SR04, air=ROOM)
    assert found == pytest.approx(4.3, rel=0.05)
    assert 4.0 < found < 4.5


@pytest.mark.parametrize(
    ("distance", "wall", "cylinders"),
    [
        (0.3, 66.7, (60.1, 62.2, 63.9, 65.3)),
        (0.5, 63.1, (52.7, 55.7, 58.2, 60.5)),
        (1.0, 56.2, (36.3, 41.8, 46.1, 50.5)),
        (1.5, 50.4, (15.9, 27.1, 34.3, 41.0)),
        (2.0, 44.8, (0.0, 0.0, 19.2, 30.5)),
        (3.0, 32.6, (0.0, 0.0, 0.0, 0.0)),
    ],
)
def test_walls_and_cylinders_are_as_wide_as_the_calibrated_model_has_them(
    distance: float, wall: float, cylinders: tuple[float, ...]
) -> None:
    assert full_width(plane_echo(distance), 2 * distance) == pytest.approx(wall, abs=0.2)
    for radius, width in zip((0.05, 0.1, 0.2, 0.5), cylinders, strict=True):
        assert full_width(cylinder_echo(distance, radius), 2 * distance) == pytest.approx(width, abs=0.2)


def test_a_convex_edge_is_narrow_when_near_and_gone_soon() -> None:
    k = float(wavenumber(HC_SR04.frequency, ROOM.speed_of_sound))
    for distance, width in ((0.3, 22.0), (0.5, 0.0)):
        echo = np.abs(edge_echo(distance, angle=0.75 * np.pi, opening=1.5 * np.pi, wavenumber=k))
        assert full_width(echo, 2 * distance) == pytest.approx(width, abs=0.5)


def test_the_rotary_arrays_transducer_has_the_widths_of_an_independent_waveform_simulation() -> None:
    paper = Transducer(piston_radius=0.0062, figure_of_merit=29.3)
    for distance, width in ((0.5, 88.0), (1.0, 76.0), (2.0, 60.0), (2.9, 44.0)):
        assert full_width(plane_echo(distance), 2 * distance, paper) == pytest.approx(width, abs=2.5)
    for distance, width in ((0.5, 70.0), (1.0, 52.0), (2.0, 0.0)):
        assert full_width(cylinder_echo(distance, 0.1), 2 * distance, paper) == pytest.approx(width, abs=4.6)


def test_the_excess_is_the_sum_of_its_decibels() -> None:
    found = signal_excess(0.25, 4.0, transducer=HC_SR04, air=ROOM, beams=0.1)
    assert found == pytest.approx(29.9 - 20 * np.log10(4.0) - 4 * ROOM.absorption(40_000.0) - 20.0)


def test_silence_is_infinitely_far_below_the_threshold() -> None:
    assert signal_excess(0.5, 2.0, transducer=HC_SR04, air=ROOM, beams=0.0) == -np.inf


def test_a_turned_over_side_lobe_is_as_loud_as_an_upright_one() -> None:
    lobes = signal_excess(0.5, 2.0, transducer=HC_SR04, air=ROOM, beams=[-0.1, 0.1])
    assert lobes[0] == lobes[1]


def test_what_is_never_detected_has_no_reach_and_what_is_always_detected_the_farthest() -> None:
    assert reach(lambda _: 0.0, transducer=HC_SR04, air=ROOM) == 0.0
    assert reach(plane_echo, transducer=Transducer(figure_of_merit=400.0), air=ROOM) == 100.0


def test_a_guessed_transducer_does_what_the_data_sheet_says() -> None:
    sensor = Sensor(sensor_id=0, half_aperture=0.4, min_range=0.02, max_range=4.0, resolution=0.003)
    guess = typical_transducer(sensor)
    assert signal_excess(plane_echo(4.0), 8.0, transducer=guess, air=ROOM) == pytest.approx(6.0)
    assert full_width(plane_echo(2.0), 4.0, guess) == pytest.approx(2 * np.degrees(0.4), abs=0.01)


def test_a_sensor_that_looks_everywhere_gets_a_piston_too() -> None:
    sensor = Sensor(sensor_id=0, half_aperture=np.pi, min_range=0.02, max_range=4.0, resolution=0.003)
    assert 0 < typical_transducer(sensor).piston_radius < 0.01

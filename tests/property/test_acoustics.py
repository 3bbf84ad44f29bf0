import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from echoplan.acoustics import (
    Air,
    absorption,
    audible_half_angle,
    burst_envelope,
    carrier_delay,
    crossing_delay,
    cylinder_echo,
    directivity,
    edge_echo,
    half_angle,
    ka_for,
    plane_echo,
    signal_excess,
    speed_of_sound,
    time_constant,
    two_way_loss,
    wedge_coefficient,
)
from echoplan.model import Transducer
from helpers.oracles import bistatic_cylinder_echo, first_null

temperatures = st.floats(-10, 40)
humidities = st.floats(0, 1)
pistons = st.floats(0.5, 20)
distances = st.floats(0.05, 5)
excesses = st.floats(0, 60)
wavenumbers = st.floats(300, 1500)
transducers = st.builds(
    Transducer,
    frequency=st.floats(20e3, 80e3),
    quality_factor=st.floats(5, 60),
    burst_cycles=st.floats(2, 16),
)


@given(temperatures, humidities)
def test_sound_is_faster_in_warmer_and_in_moister_air(temperature: float, humidity: float) -> None:
    here = speed_of_sound(temperature, relative_humidity=humidity)
    assert speed_of_sound(temperature + 1, relative_humidity=humidity) > here
    assert speed_of_sound(temperature, relative_humidity=humidity + 0.1) > here


@given(temperatures, humidities, st.floats(1e3, 2e5))
def test_higher_tones_are_absorbed_more(temperature: float, humidity: float, frequency: float) -> None:
    low, high = absorption([frequency, 1.1 * frequency], temperature=temperature, relative_humidity=humidity)
    assert 0 < low < high


@given(st.floats(0, np.pi), pistons)
def test_nothing_is_louder_than_the_axis(angle: float, ka: float) -> None:
    assert abs(directivity(angle, ka)) <= 1
    assert two_way_loss(angle, ka) >= 0


@given(st.floats(0.01, 80), pistons)
def test_the_half_angle_undoes_the_loss(loss: float, ka: float) -> None:
    angle = half_angle(loss, ka)
    assert angle <= first_null(ka)
    if angle < np.pi / 2:
        assert two_way_loss(angle, ka) == pytest.approx(loss, abs=1e-4)
    else:
        assert two_way_loss(angle, ka) <= loss + 1e-4


@given(st.floats(0.01, 80), st.floats(0.05, 1.5))
def test_the_piston_undoes_the_half_angle(loss: float, angle: float) -> None:
    assert half_angle(loss, ka_for(angle, loss)) == pytest.approx(angle, rel=1e-9)


@given(distances, distances, st.floats(0.02, 2), st.floats(0, 1.5))
def test_an_echo_of_a_cylinder_is_the_same_both_ways(there: float, back: float, radius: float, angle: float) -> None:
    forth = bistatic_cylinder_echo(there, back, radius, incidence=angle)
    assert forth == pytest.approx(bistatic_cylinder_echo(back, there, radius, incidence=angle))
    assert 0 < forth <= plane_echo((there + back) / 2)


@given(st.floats(0.02, 0.98), st.floats(0.02, 0.98), st.floats(np.pi * 0.6, 2 * np.pi), wavenumbers)
def test_an_edge_diffracts_the_same_both_ways(first: float, second: float, opening: float, k: float) -> None:
    angles = first * opening, second * opening
    forth = wedge_coefficient(*angles, opening=opening, wavenumber=k, distance_parameter=0.4)
    back = wedge_coefficient(*angles[::-1], opening=opening, wavenumber=k, distance_parameter=0.4)
    assert forth == pytest.approx(back, abs=1e-12)


@given(st.floats(0.02, 0.98), st.floats(np.pi * 0.6, 2 * np.pi), wavenumbers)
def test_an_edge_looks_the_same_from_its_other_face(share: float, opening: float, k: float) -> None:
    angle = share * opening
    one, other = (edge_echo(0.8, angle=seen, opening=opening, wavenumber=k) for seen in (angle, opening - angle))
    assert one == pytest.approx(other, abs=1e-9)


@given(distances, st.floats(0.001, 1), st.floats(np.pi, 2 * np.pi), wavenumbers)
def test_an_edge_never_echoes_louder_than_a_plane(distance: float, share: float, opening: float, k: float) -> None:
    echo = edge_echo(distance, angle=share * opening, opening=opening, wavenumber=k)
    assert np.isfinite(echo)
    assert abs(echo) <= 1.01 * plane_echo(distance)


@given(st.floats(np.pi * 1.05, 2 * np.pi), distances, wavenumbers)
def test_the_field_has_no_jump_where_a_reflection_ends(opening: float, distance: float, k: float) -> None:
    # A hair to either side of the perpendicular on the first face's end the sum of reflection and diffraction agrees.
    total = [
        edge_echo(distance, angle=np.pi / 2 + lean, opening=opening, wavenumber=k)
        + (plane_echo(distance) if lean < 0 else 0.0)
        for lean in (-1e-7, 1e-7)
    ]
    assert abs(total[0] - total[1]) < 1e-3 * plane_echo(distance)


@given(excesses, transducers)
def test_the_crossing_undoes_the_envelope(excess: float, transducer: Transducer) -> None:
    delay = crossing_delay(excess, transducer)
    assert burst_envelope(delay, transducer) * 10 ** (excess / 20) == pytest.approx(1, rel=1e-5)


@given(excesses, transducers)
def test_weaker_echoes_cross_later(excess: float, transducer: Transducer) -> None:
    assert crossing_delay(excess, transducer) >= crossing_delay(excess + 0.5, transducer)


@given(st.floats(0.5, 60), transducers)
def test_the_carrier_trips_within_a_period_after_its_envelope(excess: float, transducer: Transducer) -> None:
    envelope, carrier = crossing_delay(excess, transducer), carrier_delay(excess, transducer)
    assume(np.isfinite(carrier))
    assert envelope <= carrier <= envelope + 1 / transducer.frequency


@given(st.floats(0, 50), transducers)
def test_the_envelope_never_exceeds_its_peak(constants: float, transducer: Transducer) -> None:
    height = burst_envelope(constants * time_constant(transducer), transducer)
    assert 0 <= height <= 1 + 1e-12


@given(distances, st.floats(0.01, 2), st.floats(0.05, 1), temperatures)
def test_walls_are_wider_than_cylinders_and_far_things_narrower_than_near_ones(
    distance: float, radius: float, farther: float, temperature: float
) -> None:
    air = Air(temperature=temperature)

    def widths(r: float) -> tuple[float, float]:
        laws = plane_echo(r), cylinder_echo(r, radius)
        wall, cylinder = (audible_half_angle(law, 2 * r, transducer=Transducer(), air=air) for law in laws)
        return float(wall), float(cylinder)

    near, far = widths(distance), widths(distance + farther)
    assert near[0] > near[1] or near[0] == 0.0
    assert near[0] > far[0] or near[0] == 0.0
    assert near[1] > far[1] or near[1] == 0.0


@given(distances, temperatures, humidities)
def test_excess_falls_with_distance_and_absorption(distance: float, temperature: float, humidity: float) -> None:
    air = Air(temperature=temperature, relative_humidity=humidity)
    near, far = (
        signal_excess(plane_echo(r), 2 * r, transducer=Transducer(), air=air) for r in (distance, 2 * distance)
    )
    assert near - far == pytest.approx(20 * np.log10(2) + 2 * distance * air.absorption(40_000.0))

"""Sound in air: speed and absorption, the beam, the strength of echoes, their detection."""

from echoplan.acoustics.air import Air, absorption, speed_of_sound
from echoplan.acoustics.beam import directivity, half_angle, ka_for, two_way_loss, wavenumber
from echoplan.acoustics.detection import (
    burst_envelope,
    carrier_delay,
    crossing_delay,
    peak_delay,
    range_walk,
    time_constant,
)
from echoplan.acoustics.diffraction import edge_echo, fresnel_tail, wedge_coefficient
from echoplan.acoustics.echo import (
    cylinder_echo,
    plane_echo,
    plate_echo,
    strip_echo,
)
from echoplan.acoustics.materials import material_names, reflection_coefficients
from echoplan.acoustics.sonar import audible_half_angle, piston_ka, reach, signal_excess, typical_transducer

__all__ = [
    "Air",
    "absorption",
    "audible_half_angle",
    "burst_envelope",
    "carrier_delay",
    "crossing_delay",
    "cylinder_echo",
    "directivity",
    "edge_echo",
    "fresnel_tail",
    "half_angle",
    "ka_for",
    "material_names",
    "peak_delay",
    "piston_ka",
    "plane_echo",
    "plate_echo",
    "range_walk",
    "reach",
    "reflection_coefficients",
    "signal_excess",
    "speed_of_sound",
    "strip_echo",
    "time_constant",
    "two_way_loss",
    "typical_transducer",
    "wavenumber",
    "wedge_coefficient",
]

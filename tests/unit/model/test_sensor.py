import re

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.model import Sensor, Transducer

REACH = {"half_aperture": 0.26, "min_range": 0.02, "max_range": 4.0, "resolution": 0.003}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"half_aperture": 0.0}, "half_aperture must be greater than 0, not 0"),
        ({"half_aperture": 3.2}, "half_aperture must be at most 3.14159265359, not 3.2"),
        ({"min_range": -0.1}, "min_range must be at least 0, not -0.1"),
        ({"min_range": 4.0}, "min_range must be less than max_range, not 4 against 4"),
        ({"max_range": np.inf}, "max_range must be finite, not inf"),
        ({"resolution": -0.001}, "resolution must be at least 0, not -0.001"),
        ({"x": np.nan}, "x must be finite, not nan"),
        ({"y": np.nan}, "y must be finite, not nan"),
        ({"yaw": np.nan}, "yaw must be finite, not nan"),
    ],
)
def test_a_sensor_that_cannot_be_is_refused(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        Sensor(sensor_id=0, **{**REACH, **wrong})


def test_a_sensor_may_look_all_around_and_have_no_dead_distance() -> None:
    sensor = Sensor(sensor_id=0, half_aperture=np.pi, min_range=0.0, max_range=4.0, resolution=0.0)
    assert sensor.half_aperture == np.pi


@pytest.mark.parametrize("name", ["frequency", "piston_radius", "quality_factor", "burst_cycles"])
def test_a_transducer_has_no_zero_dimensions(name: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{name} must be greater than 0, not 0$"):
        Transducer(**{name: 0.0})


def test_a_transducer_may_be_deaf() -> None:
    assert Transducer(figure_of_merit=-10.0).figure_of_merit == -10.0

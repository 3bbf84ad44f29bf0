import tomllib
from dataclasses import replace

import numpy as np
import pytest

from echoplan.model import Conventions, FeatureMap
from echoplan.viewer import learned_in_words
from helpers.maps import wall


def items(conventions: Conventions | None = None, **changed: object) -> tuple[tuple[str, str], ...]:
    """A map of a recording of which one number is known."""
    found: dict[str, object] = {
        "range_scale": {"value": 0.0199, "sigma": 0.0003, "prior_sigma": 0.03},
        "noise": 0.0031,
        "poses": "used as recorded: 99 % of the echoes fit together",
    }
    walls = (wall([0.0, 0.0], [1.0, 0.0]),) * 9
    feature_map = FeatureMap(method="joint", walls=walls, parameters={"found": {**found, **changed}})
    (section,) = learned_in_words(feature_map, conventions)
    return section.items


def described(conventions: Conventions | None = None, **changed: object) -> dict[str, str]:
    return dict(items(conventions, **changed))


def test_a_number_comes_with_its_uncertainty_and_unit() -> None:
    assert described()["Ranges are too short by"] == "1.990 \N{PLUS-MINUS SIGN} 0.030 %"


def test_a_number_below_zero_is_worded_the_other_way_round() -> None:
    scale = {"value": -0.00086, "sigma": 0.0003, "prior_sigma": 0.03}
    assert described(range_scale=scale)["Ranges are too long by"] == "0.086 \N{PLUS-MINUS SIGN} 0.030 %"


@pytest.mark.parametrize("value", [0.0002, -0.0002])
def test_of_what_the_pings_do_not_narrow_down_not_even_the_sign_is_reported(value: float) -> None:
    scale = {"value": value, "sigma": 0.028, "prior_sigma": 0.03}
    assert described(range_scale=scale)["Ranges are off by"] == "not determined by this recording"


def test_what_the_thermometer_measured_is_said_to_come_from_it() -> None:
    scale = {"value": 0.0167, "sigma": 0.002, "prior_sigma": 0.002, "temperature": 29.04}
    assert described(range_scale=scale)["Ranges are too short by"] == (
        "1.67 \N{PLUS-MINUS SIGN} 0.20 %, in air of 29.0 \N{DEGREE SIGN}C by the thermometer"
    )


def test_gain_and_offset_of_a_servo_come_with_the_keys_that_make_them_permanent() -> None:
    gain = {"value": 0.9347, "sigma": 0.0021, "prior_sigma": 0.05}
    offset = {"value": np.radians(6.04), "sigma": np.radians(0.12), "prior_sigma": np.radians(5.0)}
    words = described(servo_gain=gain, servo_offset=offset)
    assert words["The servo turns"] == "0.935 \N{PLUS-MINUS SIGN} 0.002 of the recorded angle"
    assert words["Where it records 0 the servo stands at"] == "6.04 \N{PLUS-MINUS SIGN} 0.12\N{DEGREE SIGN}"
    assert (
        words["To make that permanent"] == "servo_gain = 0.93470, servo_offset = 0.10542 in [conventions] of rig.toml"
    )


def test_only_what_is_determined_of_a_servo_is_to_be_made_permanent() -> None:
    gain = {"value": 0.9347, "sigma": 0.0021, "prior_sigma": 0.05}
    offset = {"value": 0.05, "sigma": np.radians(3.0), "prior_sigma": np.radians(5.0)}
    words = described(servo_gain=gain, servo_offset=offset)
    assert words["Where it records 0 the servo stands at"] == "not determined by this recording"
    assert words["To make that permanent"] == "servo_gain = 0.93470 in [conventions] of rig.toml"


@pytest.mark.parametrize(
    "now",
    [
        Conventions(servo_offset=-np.pi / 2),
        Conventions(servo_gain=1.1),
        Conventions(servo_sign=-1, servo_offset=np.pi / 2, servo_gain=0.9),
    ],
    ids=["0 to 180 degrees", "a gain", "all"],
)
def test_what_makes_a_servo_permanent_comes_on_top_of_the_conventions_that_are_set(now: Conventions) -> None:
    gain, offset, recorded = 0.9347, 0.1054, np.array([0.0, 1.0, 3.0])
    words = described(
        now,
        servo_gain={"value": gain, "sigma": 0.0021, "prior_sigma": 0.05},
        servo_offset={"value": offset, "sigma": 0.002, "prior_sigma": 0.09},
    )
    keys = tomllib.loads(words["To make that permanent"].split(" in ")[0].replace(", ", "\n"))
    then = replace(now, **keys)
    assert then.servo_angles(recorded) == pytest.approx(gain * now.servo_angles(recorded) + offset, abs=1e-4)


def test_a_gain_alone_turns_the_offset_that_is_set() -> None:
    words = described(Conventions(servo_offset=-1.0), servo_gain={"value": 0.95, "sigma": 0.0021, "prior_sigma": 0.05})
    assert words["To make that permanent"].startswith("servo_gain = 0.95000, servo_offset = -0.95000 in")


def test_noise_is_reported_in_millimetres() -> None:
    assert described()["Readings scatter by"] == "3.1 mm"


def test_it_is_said_that_readings_are_those_of_rays() -> None:
    assert described(cone=np.radians(12.5))["Readings are"] == (
        "the nearest points in cones of rays of \N{PLUS-MINUS SIGN}12.5\N{DEGREE SIGN}, as robot simulators make them"
    )
    assert "Readings are" not in described()


@pytest.mark.parametrize(
    ("direction", "where"),
    [({}, ""), ({"along_axes": False}, ""), ({"along_axes": True}, ", along the axes")],
    ids=["an older map", "any", "axes"],
)
def test_it_is_said_how_many_walls_were_drawn_to_right_angles(direction: dict[str, bool], where: str) -> None:
    square = {"walls": 7, "sigma": np.radians(0.28), **direction}
    expected = f"7 of 9, \N{PLUS-MINUS SIGN} 0.28\N{DEGREE SIGN}{where}"
    assert described(right_angles=square)["Walls at right angles"] == expected
    assert "Walls at right angles" not in described(right_angles={})


def test_it_is_said_what_was_done_about_the_poses_and_why() -> None:
    assert described(poses="corrected: walls were there twice")["Poses"] == "corrected: walls were there twice"


def test_it_is_said_where_a_recording_leaves_the_way_open() -> None:
    way = {"first": 3, "last": 90, "direction": 0.5236, "along": 0.121, "across": 0.009}
    assert described(undetermined=[way])["Not determined"] == (
        "the position along 30\N{DEGREE SIGN} from sweep 3 to 90: known only from odometry, "
        "\N{PLUS-MINUS SIGN}121 mm along and \N{PLUS-MINUS SIGN}9 mm across at worst"
    )
    assert "Not determined" not in described(undetermined=[])


def test_stretches_of_one_corridor_are_reported_as_one_and_those_around_the_corner_apart() -> None:
    spans = [(3, 20, -0.002), (24, 40, 0.1), (45, 60, np.pi - 0.05), (90, 95, 0.0), (99, 110, 1.5)]
    ways = [
        {"first": first, "last": last, "direction": direction, "along": 0.001 * last, "across": 0.002}
        for first, last, direction in spans
    ]
    lines = [line for name, line in items(undetermined=ways) if name == "Not determined"]
    assert [line.split(":")[0] for line in lines] == [
        "the position along 1\N{DEGREE SIGN} from sweep 3 to 60, mostly",
        "the position along 0\N{DEGREE SIGN} from sweep 90 to 95",
        "the position along 86\N{DEGREE SIGN} from sweep 99 to 110",
    ]
    assert "60 mm along" in lines[0]


@pytest.mark.parametrize("sigma", [1e-9, 1.0])
def test_any_uncertainty_can_be_written(sigma: float) -> None:
    number = {"value": 0.5, "sigma": sigma, "prior_sigma": 1e9}
    assert "%" in described(range_scale=number)["Ranges are too short by"]


def test_methods_that_learn_nothing_say_nothing() -> None:
    assert learned_in_words(FeatureMap(method="rcd")) == ()
    assert learned_in_words(FeatureMap(method="joint", parameters={"found": {}})) == ()

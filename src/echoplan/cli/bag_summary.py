"""Tables of what is in a ROS bag, for ``echoplan info``."""

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from echoplan.cli.terminal import put, show

if TYPE_CHECKING:
    from echoplan.io.ros import BagSensor, BagSummary

__all__ = ["bag_document", "put_bag"]


# So many fields are shown that may be ranges: a message may have hundreds.
_SHOWN = 10


def put_bag(name: str, summary: "BagSummary") -> None:
    """Print the topics and sensors of a bag, and what is missing for a map."""
    from echoplan.model import Table  # noqa: PLC0415 - --help must not wait for NumPy

    topics = Table(
        title=f"Topics of {name}",
        columns=("topic", "type", "messages", "rate (1/s)", "frames"),
        rows=tuple(
            (each.name, each.type, str(each.messages), _number(each.rate, "{:.1f}"), each.frames or "-")
            for each in summary.topics
        ),
    )
    sensors = Table(
        title="Sensors",
        columns=(
            *("sensor", "topic", "frame", "readings", "beam (deg)", "limits (m)"),
            *("x (m)", "y (m)", "yaw (deg)", "turned by"),
        ),
        rows=tuple(_sensor_row(number, each) for number, each in enumerate(summary.sensors)),
    )
    show(topics)
    if summary.sensors:
        show(sensors)
    put(f"Poses of the robot: {summary.poses or 'unknown'}")
    for sentence in summary.missing:
        put(f"Missing for a map: {sentence}.")
    if summary.candidates:
        fields = ", ".join(summary.candidates[:_SHOWN])
        put(f"Fields that may be ranges, to be named with --field range=: {fields}")


def bag_document(summary: "BagSummary") -> dict[str, Any]:
    """Return the topics and sensors of a bag as JSON has them; what is unknown is null."""
    return {
        "topics": [_fields(asdict(each)) for each in summary.topics],
        "sensors": [_fields(asdict(each)) for each in summary.sensors],
        "poses": summary.poses,
        "missing": list(summary.missing),
        "candidates": list(summary.candidates),
    }


def _fields(values: dict[str, Any]) -> dict[str, Any]:
    return {key: None if isinstance(value, float) and math.isnan(value) else value for key, value in values.items()}


def _sensor_row(number: int, sensor: "BagSensor") -> tuple[str, ...]:
    return (
        str(number),
        sensor.topic,
        sensor.frame or "-",
        str(sensor.readings),
        _number(math.degrees(sensor.field_of_view), "{:.1f}"),
        f"{_number(sensor.min_range, '{:.2f}')} to {_number(sensor.max_range, '{:.2f}')}",
        _number(sensor.x, "{:.3f}"),
        _number(sensor.y, "{:.3f}"),
        _number(math.degrees(sensor.yaw), "{:.1f}"),
        sensor.joint or "fixed",
    )


def _number(value: float, form: str) -> str:
    return "-" if math.isnan(value) else form.format(value)

"""Convert messages to rows of numbers, for the ROS types that echoplan reads."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from echoplan.errors import InputError
from echoplan.io.ros.bag import Message
from echoplan.io.ros.options import BagOptions, Field
from echoplan.io.ros.series import Role, Row, SeriesKey

__all__ = ["LASER_SCAN", "ODOMETRY", "POSES", "RANGE", "TRANSFORMS", "rows_of"]

RANGE = "sensor_msgs/msg/Range"
LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
# Other types of poses, for topics that the user names.
POSES = (ODOMETRY, "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped")
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
_INFRARED = 1


def rows_of(message: Message, options: BagOptions) -> Iterator[Row]:
    """Yield the content of a message: readings, a pose, transforms, and fields that the user names."""
    fields = [field for field in options.fields if field.topic == message.topic.name]
    yield from _field_rows(message, fields)
    # A range field that the user names replaces the range of the message.
    if message.topic.type in _ROWS and not any(field.key == "range" for field in fields):
        yield from _ROWS[message.topic.type](message)


def _range_rows(message: Message) -> Iterator[Row]:
    body = message.body
    infrared = float(body.radiation_type == _INFRARED)
    yield Row(
        SeriesKey(Role.READING, message.topic.name, _frame(body)),
        message.log_ns,
        _stamp_ns(body),
        (body.range, body.min_range, body.max_range, body.field_of_view, infrared, 0.0),
    )


def _scan_rows(message: Message) -> Iterator[Row]:
    body = message.body
    key = SeriesKey(Role.READING, message.topic.name, _frame(body))
    start_ns, step_ns = _stamp_ns(body), body.time_increment * 1e9
    for place, distance in enumerate(body.ranges.tolist()):
        later_ns = round(place * step_ns)
        bearing = body.angle_min + place * body.angle_increment
        values = (distance, body.range_min, body.range_max, float("nan"), 0.0, bearing)
        yield Row(key, message.log_ns + later_ns, start_ns and start_ns + later_ns, values)


def _pose_rows(message: Message) -> Iterator[Row]:
    body = message.body
    pose = body.pose.pose if hasattr(body.pose, "pose") else body.pose
    child = getattr(body, "child_frame_id", "").strip("/")
    key = SeriesKey(Role.POSE, message.topic.name, _frame(body), child)
    values = (pose.position.x, pose.position.y, _yaw(pose.orientation))
    yield Row(key, message.log_ns, _stamp_ns(body), values)


def _transform_rows(message: Message) -> Iterator[Row]:
    role = Role.FIXED_TRANSFORM if message.topic.name.endswith("tf_static") else Role.MOVING_TRANSFORM
    for each in message.body.transforms:
        key = SeriesKey(role, message.topic.name, _frame(each), each.child_frame_id.strip("/"))
        shift, turn = each.transform.translation, each.transform.rotation
        values = (shift.x, shift.y, shift.z, turn.x, turn.y, turn.z, turn.w)
        yield Row(key, message.log_ns, _stamp_ns(each), values)


_ROWS: Mapping[str, Callable[[Message], Iterator[Row]]] = {
    RANGE: _range_rows,
    LASER_SCAN: _scan_rows,
    **dict.fromkeys(POSES, _pose_rows),
    **dict.fromkeys(TRANSFORMS, _transform_rows),
}


def _field_rows(message: Message, fields: list[Field]) -> Iterator[Row]:
    body, stamp_ns, nan = message.body, _stamp_ns(message.body), float("nan")
    numbers = {field: _number(_inner(body, field), field) for field in fields}
    for field, number in numbers.items():
        if field.key == "stamp":
            stamp_ns = round(number * 1e9)
    has_several = sum(field.key == "range" for field in fields) > 1
    for field, number in numbers.items():
        if field.key == "range":
            name = str(field).strip("/") if has_several else ""
            place = SeriesKey(Role.READING, message.topic.name, _frame(body), name)
            yield Row(place, message.log_ns, stamp_ns, (number, nan, nan, nan, 0.0, 0.0))
        else:
            yield Row(SeriesKey(Role.FIELD, message.topic.name, field.key), message.log_ns, stamp_ns, (number,))


def _inner(body: Any, field: Field) -> Any:
    """Follow the path of a field through a message."""
    value: Any = body
    names: Any = None
    for step in field.path:
        try:
            if step.startswith("["):
                place = step.strip("[]")
                value = value[int(place) if place.isdecimal() else list(names).index(place)]
            else:
                # A JointState names the joints in its arrays.
                value, names = getattr(value, step), getattr(value, "name", None)
        except (AttributeError, LookupError, TypeError, ValueError) as error:
            known = ", ".join(_fields_of(value) or map(str, names or ()))
            remedy = f"known here: {known}" if known else "indices of an array start at 0"
            problem = f"a message of {field.topic} has no {step.strip('[]')!r}"
            raise InputError("--field", problem, place=f"{field.key}={field}", remedy=remedy) from error
    return value


def _fields_of(value: Any) -> list[str]:
    return [name for name in getattr(value, "__dataclass_fields__", ()) if not name.startswith("__")]


def _number(value: Any, field: Field) -> float:
    """Convert a field to a number: a time to seconds, a quaternion to its yaw."""
    if hasattr(value, "nanosec"):
        return field.factor * (float(value.sec) + 1e-9 * float(value.nanosec))
    if field.key in ("yaw", "servo") and hasattr(value, "w"):
        return field.factor * _yaw(value)
    if isinstance(value, (int, float, np.number)):
        return field.factor * float(value)
    inside = _fields_of(value)
    remedy = f"name a field inside it: {', '.join(inside)}" if inside else "name a field that is a number"
    problem = f"it is not a number but {getattr(value, '__msgtype__', type(value).__name__)}"
    raise InputError("--field", problem, place=f"{field.key}={field}", remedy=remedy)


def _yaw(turn: Any) -> float:
    """Return the direction of the rotated x axis in the plane [rad]; nan for an all-zero quaternion."""
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    forward, left = w * w + x * x - y * y - z * z, 2.0 * (w * z + x * y)
    return float(np.arctan2(left, forward)) if forward or left else float("nan")


def _frame(body: Any) -> str:
    header = getattr(body, "header", None)
    return str(getattr(header, "frame_id", "")).strip("/")


def _stamp_ns(body: Any) -> int:
    stamp = getattr(getattr(body, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)

"""Options of a source, the same for every command that has them: what to read from a ROS bag, and which device."""

from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.terminal import put

if TYPE_CHECKING:
    from echoplan.io.ros import BagOptions
    from echoplan.model import Source

__all__ = [
    "SOURCE_HELP",
    "DeviceArgument",
    "DeviceRigOption",
    "FieldOption",
    "MountOption",
    "OdomOption",
    "TopicOption",
    "bag_options",
    "put_notes",
]

_PANEL = "ROS bags and ros2://"
SOURCE_HELP = "A recording's folder, a ROS bag, sim:WORLD, or a device: serial:///dev/... or tcp://HOST:PORT."

TopicOption = Annotated[
    list[str] | None,
    typer.Option("--topic", help="Topics with ranges, by name or pattern: '/sonar_*'.", rich_help_panel=_PANEL),
]
OdomOption = Annotated[
    str | None, typer.Option("--odom", help="Topic with the poses of the robot.", rich_help_panel=_PANEL)
]
FieldOption = Annotated[
    list[str] | None,
    typer.Option(
        "--field",
        help="A quantity from a field of any message: range=/echo.distance*0.01, or a number: x=0.",
        rich_help_panel=_PANEL,
    ),
]
MountOption = Annotated[
    list[str] | None,
    typer.Option("--mount", help="Pose of a sensor in the base: FRAME=X,Y,YAW in m and rad.", rich_help_panel=_PANEL),
]
DeviceArgument = Annotated[
    str, typer.Argument(help="serial:///dev/ttyUSB0 or tcp://HOST:PORT; without it, the only device that answers.")
]
DeviceRigOption = Annotated[
    str, typer.Option("--rig", help="A built-in rig or a rig.toml; else by the number of sensors of the device.")
]


def bag_options(
    topics: list[str] | None, odometry: str | None, fields: list[str] | None, mounts: list[str] | None
) -> "BagOptions | None":
    """Read the options of a bag; None if none is given."""
    from echoplan.io.ros import parse_bag_options  # noqa: PLC0415 - --help must not wait for NumPy

    if not (topics or odometry or fields or mounts):
        return None
    return parse_bag_options(topics=topics or (), odometry=odometry, fields=fields or (), mounts=mounts or ())


def put_notes(source: "Source") -> None:
    """Print what the user should know about how a source was read."""
    from echoplan.sources import notes_of  # noqa: PLC0415 - --help must not wait for NumPy

    for note in notes_of(source):
        put(f"Note: {note}")

"""``echoplan live``: a page in the browser on which a map grows."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.source_options import FieldOption, MountOption, OdomOption, TopicOption, bag_options, put_notes
from echoplan.cli.terminal import put

if TYPE_CHECKING:
    from echoplan.io.ros import BagOptions
    from echoplan.live import Feed
    from echoplan.model import Source

__all__ = ["run"]

_FLAT = "sim:two-room-flat"
# "echo" on the keys of a telephone.
_PORT = 3246


def run(
    source: Annotated[
        str,
        typer.Argument(
            help="A device, a recording's folder, a ROS bag, sim:WORLD, or a running ROS 2: ros2://",
            show_default="a furnished flat",
        ),
    ] = _FLAT,
    speed: Annotated[float, typer.Option(help="How many times faster than it was recorded.")] = 1.0,
    sweeps: Annotated[int, typer.Option(min=1, max=65535, help="Sweeps of a device at each station.")] = 1,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for what is saved.", show_default="downloads only")
    ] = None,
    port: Annotated[int, typer.Option(help="Port of the page; 0 for any free one.", min=0, max=65535)] = _PORT,
    host: Annotated[
        str | None,
        typer.Option(
            help="Address for other machines, such as 0.0.0.0; the page then needs a token.", show_default="none"
        ),
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page; never if the output is no terminal.")
    ] = True,
    topic: TopicOption = None,
    odom: OdomOption = None,
    field: FieldOption = None,
    mount: MountOption = None,
) -> None:
    """Show a source in the browser while its map grows.

    Example: echoplan live sim:two-room-flat --speed 4
    """
    from secrets import token_urlsafe  # noqa: PLC0415 - --help must not wait for NumPy

    from echoplan.io import check_folder  # noqa: PLC0415
    from echoplan.live import run_live  # noqa: PLC0415
    from echoplan.mapping import PRIOR, RESULTS  # noqa: PLC0415

    if out is not None:
        check_folder(out, [*RESULTS, PRIOR])
    feed = _open(source, bag=bag_options(topic, odom, field, mount), speed=speed, sweeps=sweeps)
    shown = browser and sys.stdout.isatty()

    def ready(address: str) -> None:
        """Print the address of the page and open it in the browser, once the server accepts connections."""
        put(f"Live map of {feed.name}: {address}")
        put("Press Ctrl-C to end.")
        if shown:
            import webbrowser  # noqa: PLC0415 - for this alone

            webbrowser.open(address)

    run_live(
        feed,
        host=host or "127.0.0.1",
        port=port,
        token=token_urlsafe(16) if host else "",
        out=out,
        ready=ready,
        publish=getattr(feed, "publish", None),
    )


def _open(text: str, *, bag: "BagOptions | None", speed: float, sweeps: int) -> "Feed":
    """Open a source as a feed, and print what the user should know about how it is read."""
    from echoplan.io.ros.wire import is_address, parse_address  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.live import Ros2Feed  # noqa: PLC0415
    from echoplan.sources import open_source  # noqa: PLC0415

    if is_address(text):
        _check_one_sweep(text, sweeps)
        feed = Ros2Feed(parse_address(text), options=bag, report=put)
        for note in feed.notes:
            put(f"Note: {note}")
        return feed
    source = open_source(text, bag=bag)
    put_notes(source)
    return _feed(source, speed=speed, sweeps=sweeps)


def _check_one_sweep(name: str, sweeps: int) -> None:
    """Refuse several sweeps at each station of what is no device."""
    from echoplan.errors import InputError  # noqa: PLC0415 - --help must not wait for NumPy

    if sweeps > 1:
        remedy = "leave it out: only a device makes sweeps at stations"
        raise InputError("--sweeps", f"{name} is no device", remedy=remedy)


def _feed(source: "Source", *, speed: float, sweeps: int) -> "Feed":
    from echoplan.hardware import DeviceSource  # noqa: PLC0415
    from echoplan.live import DeviceFeed, Player, SimulationPlayer  # noqa: PLC0415
    from echoplan.simulation import Simulation  # noqa: PLC0415

    if isinstance(source, DeviceSource):
        return DeviceFeed(source.name, rig=source.rig, conventions=source.conventions, sweeps=sweeps)
    _check_one_sweep(source.name, sweeps)
    if isinstance(source, Simulation):
        return SimulationPlayer(source, speed=speed)
    return Player(source, speed=speed)

"""``echoplan record``: what a device measures becomes a recording, sweep by sweep."""

import sys
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.source_options import DeviceArgument, DeviceRigOption
from echoplan.cli.terminal import put, report_files
from echoplan.signals import raised_signals

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from echoplan.arrays import FloatArray
    from echoplan.hardware import Device
    from echoplan.model import Rig

__all__ = ["run"]


def run(
    source: DeviceArgument = "",
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the recording.")] = Path("rec"),
    rig: DeviceRigOption = "",
    place: Annotated[
        list[str] | None,
        typer.Option(help='"x y heading" of a station [cm, cm, degrees]; repeatable. Without it you are asked.'),
    ] = None,
    places: Annotated[Path | None, typer.Option(help="File of such places, one a line.")] = None,
    sweeps: Annotated[int, typer.Option(min=1, max=65535, help="Sweeps at each station.")] = 1,
    append: Annotated[bool, typer.Option("--append", help="Continue a recording.")] = False,
) -> None:
    """Record sweeps of a device, at stations where you place it or to which it drives.

    Each sweep is on the disk when it is complete. A lost connection is made again; the sweep is repeated.

    Example: echoplan record serial:///dev/ttyUSB0 --out rec/
    """
    from echoplan.cli.sweep_progress import SweepProgress  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.hardware import Device, find_device  # noqa: PLC0415
    from echoplan.io import Recorder  # noqa: PLC0415
    from echoplan.io.text_logs import read_places  # noqa: PLC0415

    stations = [_pose(each.x, each.y, each.heading) for each in read_places(place or (), places)]
    if append and not rig and (out / "rig.toml").exists():
        rig = str(out / "rig.toml")
    with raised_signals(), SweepProgress() as progress, Device(source or find_device(), watch=progress.watch) as device:
        used, text = _rig_of(rig, device)
        put(f"{device.address}: {device.hello.board}, {device.hello.sensors} sensors; rig {used.name!r}")
        with Recorder(out, rig=text, append=append) as recorder:
            for number, pose in enumerate(_poses(device, stations), start=1):
                device.place(pose)
                progress.begin(f"station {number}", used, sweeps=sweeps)
                for sweep in device.sweeps(sweeps, rig=used):
                    recorder.add(sweep)
                    progress.check(sweep, used)
                progress.end()
        _report(device, out, sweeps=recorder.sweeps)


def _report(device: "Device", out: Path, *, sweeps: int) -> None:
    """Print what was recorded, and how often the connection failed."""
    put(f"{sweeps} sweeps")
    for problem, number in device.counts.items():
        put(f"{problem}: {number}")
    if sweeps:
        report_files(out, ["pings.csv", "rig.toml"])


def _rig_of(name: str, device: "Device") -> "tuple[Rig, str]":
    """Return a rig and the text of its file: a file is kept as it stands, with the conventions in it."""
    from echoplan.io import format_rig  # noqa: PLC0415
    from echoplan.io.files import read_text  # noqa: PLC0415
    from echoplan.sources import device_conventions, find_rig, names_file, rig_name  # noqa: PLC0415

    device_conventions(name)
    rig = find_rig(rig_name(name, device))
    return rig, read_text(Path(name)) if names_file(name) else format_rig(rig)


def _poses(device: "Device", stations: "Sequence[FloatArray]") -> "Iterator[FloatArray]":
    """Yield where the robot stands [m, m, rad], station by station."""
    # Without the geometry of its wheels, nobody knows where it has driven.
    if "drive" in device.capabilities and device.wheels is not None:
        return _driven_poses(device, stations)
    if stations:
        return _announced_poses(stations)
    return _pushed_poses(device) if device.wheels is not None else _asked_poses()


def _driven_poses(device: "Device", stations: "Sequence[FloatArray]") -> "Iterator[FloatArray]":
    """Let the device drive from station to station: those that are given, or those that its wheels measure."""
    from echoplan.errors import InputError  # noqa: PLC0415 - --help must not wait for NumPy

    yield stations[0] if stations else device.pose
    if len(stations) > 1:
        for number, station in enumerate(stations[1:], start=2):
            if not device.move():
                remedy = "give the places of its route only, and continue with --append"
                raise InputError(device.address, f"it does not drive to station {number}", remedy=remedy)
            yield station
    else:
        while device.move():
            yield device.pose


def _announced_poses(stations: "Sequence[FloatArray]") -> "Iterator[FloatArray]":
    """Let the user carry the robot from station to station."""
    for number, station in enumerate(stations, start=1):
        if sys.stdin.isatty():
            typer.prompt(f"Place the robot at station {number} and press Enter", default="", show_default=False)
        yield station


def _pushed_poses(device: "Device") -> "Iterator[FloatArray]":
    """Let the user push the robot from station to station while its wheels are counted."""
    put("The wheels measure where the robot is. The first station is 0 0 0.")
    typed = ["\n"]
    for number in count(2):
        yield device.pose
        if sys.stdin.isatty():
            sys.stderr.write(f"Push the robot to station {number} and press Enter (q: finish): ")
            sys.stderr.flush()
        device.push(lambda: typed.append(sys.stdin.readline()))
        if typed[-1].strip() or not typed[-1]:
            return


def _asked_poses() -> "Iterator[FloatArray]":
    """Ask for the place of each station until an empty line."""
    from echoplan.errors import InputError  # noqa: PLC0415
    from echoplan.io.text_logs import parse_place  # noqa: PLC0415

    is_terminal = sys.stdin.isatty()
    if is_terminal:
        put("Place the robot, then type where it stands: x y heading [cm, cm, degrees].")
    for number in count(1):
        if is_terminal:
            sys.stderr.write(f"station {number} (empty: finish): ")
            sys.stderr.flush()
        text = sys.stdin.readline().strip()
        if not text:
            return
        try:
            place = parse_place(text, option="place")
        except InputError as error:
            if not is_terminal:
                raise
            put(f"{error}")
            continue
        yield _pose(place.x, place.y, place.heading)


def _pose(x_cm: float, y_cm: float, heading_deg: float) -> "FloatArray":
    import numpy as np  # noqa: PLC0415

    return np.array([0.01 * x_cm, 0.01 * y_cm, np.radians(heading_deg)])

"""``echoplan calibrate``: guided steps that make a rig.toml for a device."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.source_options import DeviceArgument, DeviceRigOption
from echoplan.cli.terminal import put, report_files, show
from echoplan.signals import raised_signals

if TYPE_CHECKING:
    from echoplan.hardware.calibration import Calibration
    from echoplan.model import Table

__all__ = ["run"]


def run(
    source: DeviceArgument = "",
    out: Annotated[Path, typer.Option("--out", "-o", help="The rig file to write.")] = Path("rig.toml"),
    rig: DeviceRigOption = "",
) -> None:
    """Calibrate a device step by step: its sensors, the direction, offset and gain of its servo, ranges and beam.

    You need a hand, a tape measure, a flat wall and a right-angled corner. Each step says what to do; Enter continues,
    s and Enter skips the step.

    Example: echoplan calibrate serial:///dev/ttyUSB0 --out rig.toml
    """
    from echoplan.cli.calibration_steps import Guide, observe  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.cli.sweep_progress import SweepProgress  # noqa: PLC0415
    from echoplan.errors import InputError  # noqa: PLC0415
    from echoplan.hardware import Device, find_device  # noqa: PLC0415
    from echoplan.hardware.calibration import calibrate  # noqa: PLC0415
    from echoplan.io.files import check_folder, write_bytes, write_text  # noqa: PLC0415
    from echoplan.sources import device_conventions, find_rig, rig_name  # noqa: PLC0415
    from echoplan.viewer.rig_calibration import calibration_png  # noqa: PLC0415

    picture = f"{out.stem}-calibration.png"
    check_folder(out.parent, [out.name, picture])
    conventions = device_conventions(rig)
    with raised_signals(), SweepProgress() as progress, Device(source or find_device(), watch=progress.watch) as device:
        start = find_rig(rig_name(rig, device))
        if start.servo is None or "servo" not in device.capabilities:
            remedy = "fixed sensors need no calibration of this kind; measure their places for rig.toml"
            raise InputError(device.address, "it has no servo to calibrate", remedy=remedy)
        put(f"{device.address}: {device.hello.board}, {device.hello.sensors} sensors; rig {start.name!r}")
        seen = observe(Guide(device=device, progress=progress), start, conventions)
        address = device.address
    if seen is None:
        put("Every step was skipped: nothing is written.")
        return
    found = calibrate(seen)
    image = calibration_png(found)
    write_text(out, _text(found, address=address))
    write_bytes(out.parent / picture, image)
    put()
    show(_table(found))
    report_files(out.parent, [out.name, picture])


def _table(found: "Calibration") -> "Table":
    """Make the table of what was measured."""
    from echoplan.model import Table  # noqa: PLC0415 - --help must not wait for NumPy

    rows = tuple((value.name, value.text) for value in found.values)
    return Table(title="Calibration", columns=("", "value ± standard deviation"), rows=rows)


def _text(found: "Calibration", *, address: str) -> str:
    """Write the rig, with the standard deviations as comments."""
    import datetime as dt  # noqa: PLC0415

    from echoplan.io import format_rig  # noqa: PLC0415
    from echoplan.version import __version__  # noqa: PLC0415

    today = dt.datetime.now().astimezone().date()
    head = f"# Calibrated on {today} with {address} by echoplan {__version__}; value ± standard deviation:"
    lines = [head, *(f"# {value.name}: {value.text}" for value in found.values)]
    return "\n".join([*lines, "", format_rig(found.rig, conventions=found.conventions)])

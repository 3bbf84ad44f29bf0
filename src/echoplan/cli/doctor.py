"""``echoplan doctor``: whether echoplan can work here, and what is installed."""

import os
import platform
import sys
from dataclasses import asdict, dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryFile, gettempdir
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.terminal import put
from echoplan.errors import InputError
from echoplan.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["EXTRAS", "Check", "run"]

# Modules of each extra in pyproject.toml by the names of their packages. An extra brings all of them or is missing.
EXTRAS = {
    "ros": {"rosbags": "rosbags"},
    "ros-live": {"cyclonedds": "cyclonedds", "eclipse-zenoh": "zenoh", "rosbags": "rosbags"},
    "cad": {"ezdxf": "ezdxf"},
    "device": {"pyserial": "serial"},
    "view": {"websockets": "websockets"},
    "cluster": {"dask": "dask", "distributed": "distributed", "pyarrow": "pyarrow"},
}
# Modules that mapping cannot do without by the names of their packages: the last one brings the default method.
_ESSENTIAL = {"numpy": "numpy", "scipy": "scipy", "numba": "numba", "echoplan": "echoplan.joint.mapper"}
_NAME_WIDTH = len("temporary folder")


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One thing that was checked: what was found, and what to do if that is not good."""

    name: str
    found: str
    remedy: str = ""
    is_essential: bool = False


def run(as_json: Annotated[bool, typer.Option("--json", help="Print the checks as JSON.")] = False) -> None:
    """Show versions, extras, the cache of compiled code, serial ports, the temporary folder and the terminal.

    Exit status 2 if maps cannot be made here.

    Example: echoplan doctor
    """
    from echoplan.io.text import format_json  # noqa: PLC0415 - --help must not wait for it

    checks = (*_versions(), *_extras(), *_cache(), *_ports(), _temporary_folder(), _terminal())
    if as_json:
        put(format_json({"format": "echoplan-doctor/1", "checks": [asdict(each) for each in checks]}))
    else:
        for each in checks:
            put(f"{each.name:<{_NAME_WIDTH}} {each.found}" + (f"; {each.remedy}" if each.remedy else ""))
    for each in checks:
        if each.is_essential and each.remedy:
            raise InputError(each.name, each.found, remedy=each.remedy)


def _versions() -> "Iterator[Check]":
    """Import what mapping needs; a package that is broken, or fits no other one, raises an ``ImportError``."""
    from importlib.metadata import version  # noqa: PLC0415 - --help must not wait for it

    yield Check(name="echoplan", found=f"{__version__} in {Path(__file__).parents[1]}")
    yield Check(name="Python", found=f"{platform.python_version()} in {sys.prefix}")
    yield Check(name="platform", found=f"{platform.platform()}, {os.cpu_count() or 1} cores")
    for package, module in _ESSENTIAL.items():
        try:
            import_module(module)
        except ImportError as error:
            remedy = "reinstall echoplan: pip install --force-reinstall echoplan"
            reason = " ".join(str(error).split())
            yield Check(name=package, found=f"cannot be imported: {reason}", remedy=remedy, is_essential=True)
        else:
            if package != "echoplan":
                yield Check(name=package, found=version(package), is_essential=True)


def _extras() -> "Iterator[Check]":
    for extra, modules in EXTRAS.items():
        missing = [package for package, module in modules.items() if find_spec(module) is None]
        found = f"{', '.join(missing)} not installed" if missing else ", ".join(map(_versioned, modules))
        remedy = f"pip install {' '.join(missing)}" if missing else ""
        yield Check(name=f"extra {extra}", found=found, remedy=remedy)


def _versioned(package: str) -> str:
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415

    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:  # a module without metadata, as in a folder on PYTHONPATH
        return package


def _cache() -> "Iterator[Check]":
    name, remedy = "compiled code", "set NUMBA_CACHE_DIR to a folder that you may write to"
    try:
        from echoplan.compiled import cache_folders  # noqa: PLC0415
    except ImportError:
        return  # reported with the packages
    folders = cache_folders()
    if not folders:
        yield Check(name=name, found="nowhere: it is compiled in each run, for minutes", remedy=remedy)
        return
    root = os.path.commonpath(folders)
    size = sum(file.stat().st_size for file in Path(root).rglob("*.nb[ci]")) / 1e6
    is_writable = all(os.access(folder, os.W_OK) for folder in folders)
    yield Check(
        name=name,
        found=f"{size:.1f} MB in {root}, {'writable' if is_writable else 'not writable'}",
        remedy="" if is_writable else remedy,
    )


def _ports() -> "Iterator[Check]":
    ports = _port_names()
    if not ports:
        yield Check(name="serial ports", found="none")
    for port in ports:
        is_usable = not port.startswith("/dev/") or os.access(port, os.R_OK | os.W_OK)
        remedy = "" if is_usable else "join its group: sudo usermod -aG dialout $USER, then log in again"
        yield Check(name="serial port", found=port if is_usable else f"{port}: no permission", remedy=remedy)


def _port_names() -> list[str]:
    """List serial ports by pyserial, or without it the device files of USB adapters."""
    try:
        from serial.tools.list_ports import comports  # noqa: PLC0415
    except ImportError:
        devices = Path("/dev")
        return sorted(str(path) for kind in ("ttyUSB*", "ttyACM*") for path in devices.glob(kind))
    return sorted(port.device for port in comports())


def _temporary_folder() -> Check:
    name = "temporary folder"
    try:
        folder = gettempdir()
        with TemporaryFile(dir=folder) as file:
            file.write(b"echoplan")
            file.flush()
    except OSError as error:
        return Check(
            name=name, found=error.strerror or str(error), remedy="set TMPDIR to a folder that you may write to"
        )
    return Check(name=name, found=f"{folder}, writable")


def _terminal() -> Check:
    encoding = getattr(sys.stdout, "encoding", None) or "unknown"
    is_unicode = encoding.lower().replace("-", "") == "utf8"
    place = "a terminal" if sys.stdout.isatty() else "no terminal"
    remedy = "" if is_unicode else "set PYTHONUTF8=1 to see all characters"
    return Check(name="output", found=f"{encoding}, {place}", remedy=remedy)

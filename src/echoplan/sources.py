"""Where sweeps come from, specified in one line of text: a recording's folder, a bag or a world to be simulated."""

import re
import reprlib
from collections.abc import Callable, Mapping
from os import PathLike, fspath
from pathlib import Path

from echoplan.errors import InputError, InvalidValueError, UnknownNameError
from echoplan.hardware import Device, DeviceSource
from echoplan.io import (
    RecordingFolder,
    builtin_rig,
    builtin_route,
    builtin_world,
    read_conventions,
    read_recording,
    read_rig,
    read_route,
    read_world,
    world_names,
)
from echoplan.io.files import readable
from echoplan.io.ros import BagOptions, BagSummary, is_bag, read_bag, summarise_bag
from echoplan.io.ros.wire import is_address
from echoplan.model import Conventions, Recording, Rig, Route, Source, Truth, World
from echoplan.simulation import Simulation, SimulationSettings

__all__ = [
    "as_source",
    "conventions_of",
    "device_conventions",
    "find_rig",
    "find_route",
    "find_truth",
    "find_world",
    "has_rig_file",
    "names_file",
    "notes_of",
    "open_source",
    "rig_name",
    "summary_of_bag",
]

_DEVICE_OPTIONS = ("rig", "sweeps")
# Rigs of devices by their number of sensors.
_RIGS = {1: "hc-sr04-servo", 4: "rotary-array"}
_SIMULATION_OPTIONS = ("rig", "route", "seed")


def open_source(
    text: str | PathLike[str], *, simulation: SimulationSettings | None = None, bag: BagOptions | None = None
) -> Source:
    """Open a source of sweeps.

    ``recording/`` is a folder with ``pings.csv`` and ``rig.toml``.  ``run.bag``, ``run.mcap``, ``run.db3`` and the
    folder of a ROS 2 bag are bags.  ``sim:paper-room`` and ``sim:room.toml`` simulate a world; options follow after
    commas: ``sim:room.toml,rig=ring-16,route=way.csv,seed=3``.  ``serial:///dev/ttyUSB0`` and ``tcp://HOST:PORT`` are
    devices, which make sweeps where they stand: ``tcp://localhost:4000,rig=my-rig.toml,sweeps=2``.

    Parameters
    ----------
    text : str or Path
        What to open, as it is written on the command line.
    simulation : SimulationSettings, optional
        Settings of the simulator, if it is one.
    bag : BagOptions, optional
        What to read from a bag, if it is one.

    Returns
    -------
    Source
        The source.

    Raises
    ------
    InputError
        If there is no such source, or it cannot be used.
    UnknownNameError
        If an option or a built-in name is unknown.
    MissingExtraError
        If it is a bag, and rosbags is not installed, or a device, and pyserial is not.

    Examples
    --------
    >>> import echoplan as ep
    >>> len(ep.open("sim:square,seed=1"))
    5
    """
    text = fspath(text)
    if is_address(text):
        remedy = f"map it while it runs: echoplan live {text}; or record a bag: ros2 bag record"
        raise InputError(text, "a running ROS 2 is no recording", remedy=remedy)
    scheme = re.match(r"[a-z]{2,}:", text)
    opener = _OPENERS.get(scheme[0]) if scheme else None
    if opener is None and is_bag(Path(text)):
        return read_bag(text, bag)
    if bag is not None:
        remedy = "leave out --topic, --odom, --field and --mount"
        raise InputError(text, "it is no ROS bag", remedy=remedy)
    return (opener or _open_recording)(text, simulation)


def as_source(source: Source | str | PathLike[str]) -> Source:
    """Return a source, or open it by its name.

    Raises
    ------
    InvalidValueError
        If it is neither.
    """
    if isinstance(source, str | PathLike):
        return open_source(source)
    if not isinstance(getattr(source, "rig", None), Rig):
        raise InvalidValueError(
            f"a source must be a path or have a name, a rig and sweeps, and {type(source).__name__} has not; "
            "put sweeps into Recording(name=..., rig=..., sweeps=...)"
        )
    return source


def find_rig(name: str) -> Rig:
    """Find a rig: a built-in one by its name, another by its file.

    Parameters
    ----------
    name : str
        ``"ring-16"`` or ``"my-rig.toml"``.

    Returns
    -------
    Rig
        The rig.

    Raises
    ------
    InputError
        If the file cannot be used.
    UnknownNameError
        If nothing of that name is built in.

    Examples
    --------
    >>> len(find_rig("ring-16").sensors)
    16
    """
    return read_rig(Path(name)) if names_file(name) else builtin_rig(name)


def find_world(name: str) -> World:
    """Find a world: a built-in one by its name, another by its file.

    Parameters
    ----------
    name : str
        ``"paper-room"`` or ``"my-room.toml"``.

    Returns
    -------
    World
        The world.

    Raises
    ------
    InputError
        If the file cannot be used.
    UnknownNameError
        If nothing of that name is built in.

    Examples
    --------
    >>> find_world("hexagon").name
    'hexagon'
    """
    return read_world(Path(name)) if names_file(name) else builtin_world(name)


def find_route(name: str) -> Route:
    """Find a route: a built-in one by its name, another by its file or by that of the world it goes through.

    Parameters
    ----------
    name : str
        ``"paper-room"``, ``"my-way.csv"``, or ``"my-room.toml"`` for the ``my-room.csv`` beside it.

    Returns
    -------
    Route
        The route.

    Raises
    ------
    InputError
        If the file cannot be used.
    UnknownNameError
        If nothing of that name is built in.

    Examples
    --------
    >>> find_route("square").stamps_ns is None
    True
    """
    if not names_file(name):
        return builtin_route(name)
    path = Path(name)
    beside = path.with_suffix(".csv")
    with readable(beside):
        missing = path.suffix == ".toml" and not beside.exists()
    if missing:
        remedy = "write its stations there as x,y,yaw, or name another route"
        raise InputError(beside, f"there is no route through {path.name}", remedy=remedy)
    return read_route(beside if path.suffix == ".toml" else path)


def find_truth(source: Source) -> Truth | None:
    """Find the truth about a source.

    Parameters
    ----------
    source : Source
        What ``open_source`` returned.

    Returns
    -------
    Truth or None
        Of the simulator, or the ``truth.json`` beside the pings of a recording; None where it is unknown.

    Raises
    ------
    InputError
        If the file cannot be used.

    Examples
    --------
    >>> len(find_truth(open_source("sim:square")).walls_xy)
    4
    """
    return source.truth if isinstance(source, Simulation | RecordingFolder) else None


def conventions_of(source: Source) -> Conventions:
    """Return how the recording behind a source is written; SI and REP 103 where there is none."""
    return source.conventions if isinstance(source, RecordingFolder) else Conventions()


def has_rig_file(source: Source) -> bool:
    """Return whether a source has a ``rig.toml``: bags and simulations have none."""
    return isinstance(source, RecordingFolder)


def notes_of(source: Source) -> tuple[str, ...]:
    """Return what the user should know about how a source was read."""
    return source.notes if isinstance(source, Recording) else ()


def summary_of_bag(text: str, options: BagOptions | None) -> BagSummary | None:
    """Look into a source that is a bag, even where it does not suffice for a map; None for any other source."""
    is_other = re.match(r"[a-z][a-z0-9+]+:", text) or not is_bag(Path(text))
    return None if is_other else summarise_bag(text, options)


def names_file(name: str) -> bool:
    """Return whether the name of a rig, world or route is that of a file, and not of something built in."""
    return bool(Path(name).suffix) or len(Path(name).parts) > 1


def _open_recording(text: str, _: SimulationSettings | None) -> Source:
    path = Path(text)
    with readable(path):
        found = path.exists()
    if found:
        return read_recording(path)
    near = f"sim:{text}" if text in world_names() else "a recording's folder, a ROS bag or sim:WORLD"
    raise InputError(text, "there is no such file or folder", remedy=f"name {near}")


def _open_simulation(text: str, settings: SimulationSettings | None) -> Source:
    world, options = _split_options(text.removeprefix("sim:"), known=_SIMULATION_OPTIONS)
    seed = options.get("seed", "0")
    if not re.fullmatch(r"[0-9]{1,18}", seed):
        digits = " of up to 18 digits" if seed.isdecimal() else ""
        raise InputError(text, f"the seed {reprlib.repr(seed)} is no whole number{digits}", remedy="write, say, seed=3")
    return Simulation(
        world=find_world(world),
        rig=find_rig(options.get("rig", "rotary-array")),
        route=find_route(options.get("route", world)),
        settings=settings or SimulationSettings(),
        seed=int(seed),
    )


def _open_device(text: str, _: SimulationSettings | None) -> Source:
    address, options = _split_options(text, known=_DEVICE_OPTIONS)
    count = options.get("sweeps", "1")
    if not re.fullmatch(r"[1-9][0-9]{0,4}", count):
        problem = f"{reprlib.repr(count)} is not a number of sweeps"
        raise InputError(text, problem, remedy="write for example sweeps=3")
    name = options.get("rig", "")
    if not name:
        # An Arduino is reset whenever its port is opened.
        with Device(address) as device:
            name = rig_name(name, device)
    rig = find_rig(name)
    return DeviceSource(name=address, rig=rig, count=int(count), conventions=device_conventions(name))


def _split_options(text: str, *, known: tuple[str, ...]) -> tuple[str, dict[str, str]]:
    """Split the options after a world or an address from it; other commas are those of a file's name."""
    name, *written = re.split(r",(?=\w+(?:[=,]|$))", text)
    options: dict[str, str] = dict(option.partition("=")[::2] for option in written)
    for option in options:
        if option not in known:
            raise UnknownNameError("option", option, known=known)
    return name, options


def rig_name(name: str, device: Device) -> str:
    """Return the name of a rig; without one, that of the built-in rig with as many sensors as a device.

    Parameters
    ----------
    name : str
        What the user named; may be empty.
    device : Device
        The device.

    Returns
    -------
    str
        What ``find_rig`` finds.

    Raises
    ------
    InputError
        If no rig is named, and none fits.
    """
    if not name and device.hello.sensors not in _RIGS:
        problem = f"the mounting of its {device.hello.sensors} sensors is unknown"
        raise InputError(device.address, problem, remedy="name a rig.toml as the rig")
    return name or _RIGS[device.hello.sensors]


def device_conventions(name: str) -> Conventions:
    """Return how the servo of a rig counts; SI and REP 103 for a built-in one.

    Parameters
    ----------
    name : str
        The rig; may be empty.

    Returns
    -------
    Conventions
        Those of its file.

    Raises
    ------
    InputError
        If the file states units of ranges or places: a device has none.
    """
    conventions = read_conventions(Path(name)) if name and names_file(name) else Conventions()
    servo = {each: getattr(conventions, each) for each in ("servo_sign", "servo_offset", "servo_gain")}
    if conventions != Conventions(**servo):
        problem = "its [conventions] state units or headings, and devices are recorded in metres and radians"
        raise InputError(name, problem, remedy="leave only servo_sign, servo_offset and servo_gain in the table")
    return conventions


# By scheme; what has none is the folder of a recording or a bag.
_OPENERS: Mapping[str, Callable[[str, SimulationSettings | None], Source]] = {
    "sim:": _open_simulation,
    "serial:": _open_device,
    "tcp:": _open_device,
}

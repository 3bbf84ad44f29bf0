"""``echoplan device``: a simulated device that speaks the device protocol."""

import sys
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.configuration import settings_of
from echoplan.cli.terminal import put
from echoplan.signals import noted_signals

if TYPE_CHECKING:
    from echoplan.hardware.faulty import VirtualDevice

__all__ = ["run"]


def run(
    world: Annotated[
        str, typer.Argument(help="A built-in world (square, paper-room, two-room-flat, ...) or a world.toml.")
    ],
    rig: Annotated[str, typer.Option(help="A built-in rig or a rig.toml, with at most 8 sensors.")] = "rotary-array",
    route: Annotated[str | None, typer.Option(help="A built-in route or a route.csv; else that of the world.")] = None,
    pty: Annotated[bool, typer.Option("--pty", help="Be a serial port (a pseudo terminal); the default.")] = False,
    tcp: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Be a TCP server at this port; 0: any free one.")
    ] = None,
    speed: Annotated[float, typer.Option(min=0.1, max=100.0, help="Run so many times faster than real time.")] = 1.0,
    faults: Annotated[
        str,
        typer.Option(help="What goes wrong: resets, noise (=0.01, wrong bits), unplug, silent (=0), stuck (=3)."),
    ] = "",
    config: Annotated[Path | None, typer.Option(help="Settings of the simulator, in a [simulation] table.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all noise and faults.")] = 0,
) -> None:
    """Simulate a device: a rig on a robot that stands at the first station of the route, and drives on.

    The device answers as a real one does until you press Ctrl-C.  Record it in another terminal.

    Example: echoplan device square --tcp 4000
    """
    from echoplan.errors import InputError  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.hardware.serving import PtyEndpoint, TcpEndpoint, serve  # noqa: PLC0415

    if pty and tcp is not None:
        raise InputError("--pty --tcp", "a device has one port", remedy="leave out one of them")
    device = _device(world, rig=rig, route=route or world, faults=faults, config=config, seed=seed)
    with noted_signals() as signals, ExitStack() as stack:
        # A port that vanishes and comes back needs a name that stays.
        folder = stack.enter_context(TemporaryDirectory(prefix="echoplan-"))
        link = Path(folder, "port") if device.faults.unplug else None
        port = PtyEndpoint(link=link) if tcp is None else TcpEndpoint(tcp)
        stack.callback(port.close)
        put(f"Simulated device: echoplan record {port.address} --rig {rig}")
        sys.stdout.flush()
        serve(device, port, speed=speed, is_over=lambda: bool(signals))


def _device(world: str, *, rig: str, route: str, faults: str, config: Path | None, seed: int) -> "VirtualDevice":
    """Make the device and warm it up."""
    from echoplan.errors import InputError  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.hardware.faulty import VirtualDevice, parse_faults  # noqa: PLC0415
    from echoplan.hardware.virtual import VirtualBoard  # noqa: PLC0415
    from echoplan.simulation import SimulationSettings  # noqa: PLC0415
    from echoplan.sources import find_rig, find_route, find_world  # noqa: PLC0415

    using, driven = find_rig(rig), find_route(route)
    if driven.stamps_ns is not None:
        raise InputError(route, "its poses have times, and a device needs stations", remedy="leave out the column t")
    chosen = parse_faults(faults, sensors=len(using.sensors))
    board = VirtualBoard(
        world=find_world(world),
        rig=using,
        stations=driven.map_from_base,
        settings=settings_of(config, "simulation", SimulationSettings),
        seed=seed,
        silent=chosen.silent,
        stuck=chosen.stuck,
    )
    # The first ping compiles the simulator.
    board.fire([0], 0)
    return VirtualDevice(board, faults=chosen, seed=seed)

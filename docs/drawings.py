"""Draws the diagrams of docs/build.md from the firmware's configuration and the rig: python docs/drawings.py [FOLDER].

Without a folder, the drawings of the documents are made anew. With one, they are written there: a wiring diagram of
your own pins, after you have changed config.h or main.py.
"""

import sys
from collections.abc import Callable
from pathlib import Path

from mirror_check import draw_mirror_check  # type: ignore[import-not-found]  # beside this file
from mounting import head_as_dxf, head_as_svg  # type: ignore[import-not-found]  # beside this file
from wiring import draw_wiring, read_arduino, read_micropython  # type: ignore[import-not-found]  # beside this file

from echoplan.io import builtin_rig

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
FIRMWARE = ROOT / "firmware"


def wiring_arduino() -> str:
    """Draw the wiring of an Arduino, as its ``config.h`` states it."""
    drawing: str = draw_wiring(read_arduino(FIRMWARE / "arduino" / "echohead" / "config.h"))
    return drawing


def wiring_micropython() -> str:
    """Draw the wiring of a 3.3 V board, as ``main.py`` states it."""
    drawing: str = draw_wiring(read_micropython(FIRMWARE / "micropython" / "main.py"))
    return drawing


def head_on_paper() -> str:
    """Draw the head of the built-in rig of four, to scale."""
    drawing: str = head_as_svg(builtin_rig("rotary-array"))
    return drawing


def head_for_cad() -> str:
    """Draw the same as DXF."""
    drawing: str = head_as_dxf(builtin_rig("rotary-array"))
    return drawing


def mirror_check() -> str:
    """Draw the check with a box on the left."""
    drawing: str = draw_mirror_check(builtin_rig("rotary-array"))
    return drawing


DRAWINGS: dict[str, Callable[[], str]] = {
    "wiring-arduino.svg": wiring_arduino,
    "wiring-esp32.svg": wiring_micropython,
    "head.svg": head_on_paper,
    "head.dxf": head_for_cad,
    "mirror-check.svg": mirror_check,
}


def main(folder: Path = PICTURES) -> None:
    """Write all of them to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in DRAWINGS.items():
        (folder / name).write_text(draw(), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))

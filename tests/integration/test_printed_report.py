"""A report prints on two pages: the map, then its tables."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from echoplan.model import Table
from echoplan.viewer import Definitions, Plan, Report, report_html
from helpers import maps

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def flat() -> Plan:
    """Four rooms of 4 by 3 m, two by two: 16 walls, their corners, 20 stations."""
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    rooms = [np.add(corners, [4.1 * x, 3.1 * y]) for x in range(2) for y in range(2)]
    walls = [maps.wall(*ends) for room in rooms for ends in zip(room, np.roll(room, -1, axis=0), strict=True)]
    stations = [[0.5 + 0.37 * number, 1.5 + 3.1 * (number % 2), 0.0] for number in range(20)]
    found = maps.drawn(*walls, *(maps.corner(each) for each in np.concatenate(rooms)), poses=stations)
    return Plan(feature_map=replace(found, method="joint"))


def printed_pages(report: Report, folder: Path) -> int:
    """Number of pages on which a browser prints a report."""
    (folder / "report.html").write_text(report_html(report), encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={folder}/own"]
    command = [str(CHROMIUM), *options, f"--print-to-pdf={folder}/report.pdf", (folder / "report.html").as_uri()]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return len(re.findall(rb"/Type\s*/Page\b", (folder / "report.pdf").read_bytes()))


@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
def test_the_report_of_a_flat_prints_on_two_pages_without_what_is_folded(tmp_path: Path) -> None:
    table = Table(title="Accuracy of the walls", columns=("index", "mm"), rows=(("1", "0.5"),) * 30)
    settings = Definitions(title="Settings", items=(("method.setting", "0.5"),) * 300, folded=True)
    report = Report(title="Map of a flat", plan=flat(), sections=(table, settings))
    assert 1 <= printed_pages(report, tmp_path) <= 2
    # Unfolded, the settings would need pages of their own.
    unfolded = replace(report, sections=(table, replace(settings, folded=False)))
    assert printed_pages(unfolded, tmp_path) > 2

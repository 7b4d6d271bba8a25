"""MAVProxy as it comes from PyPI, headless: everything by the words that a person types.

Why: it is the strictest of the clients about target ids and counts, and asks for files before it asks for parameters.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from halfroll import _firmware
from system.processes import EXAMPLES, simulator

pytestmark = pytest.mark.long

MAVPROXY = Path(sys.executable).with_name("mavproxy.py")
DEADLINE_S = 120.0
MISSION = 67371008
PAGE = (Path(__file__).parents[3] / "docs" / "connect.md").read_text()
TYPED = re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)[0].splitlines()  # what the page tells people to type
FIELD = "box.waypoints"


class Terminal:
    """MAVProxy between two pipes; what it has said since the last word typed."""

    def __init__(self, port: int, folder: Path) -> None:
        words = [sys.executable, str(MAVPROXY), f"--master=udpin:127.0.0.1:{port}"]
        self._log = (folder / "said.txt").open("w+b")
        self.process = subprocess.Popen(
            [*words, "--default-modules", "param,wp,mode,arm,cmdlong,log"],
            stdin=subprocess.PIPE,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**os.environ, "PYTHONUNBUFFERED": "1", "HOME": str(folder)},
        )
        self._since = 0

    def type(self, line: str) -> None:
        self._since = len(self.everything())
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n".encode())
        self.process.stdin.flush()

    def said(self) -> str:
        return self.everything()[self._since :]

    def everything(self) -> str:
        return Path(self._log.name).read_text(errors="replace")

    def until(self, words: str) -> str:
        began = time.monotonic()
        while words not in self.said():
            assert time.monotonic() - began < DEADLINE_S, f"never said {words!r}: {self.said()}"
            assert self.process.poll() is None, self.said()
            time.sleep(0.05)
        return self.said()

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdin is not None
        self.process.stdin.close()
        self._log.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where MAVProxy works: a waypoint file as it writes them itself, home first."""
    folder = tmp_path_factory.mktemp("mavproxy")
    shutil.copy(EXAMPLES / FIELD, folder)
    return folder


@pytest.fixture(scope="module")
def terminal(folder: Path) -> Iterator[Terminal]:
    with simulator("--scenario", "ideal") as (_, instance):
        terminal = Terminal(14550 + instance, folder)
        yield terminal
        terminal.close()


def test_it_connects_and_fetches_all_parameters(terminal: Terminal) -> None:
    terminal.until(f"Received {len(_firmware.parameter_table())} parameters")


def test_a_parameter_is_shown_and_set(terminal: Terminal) -> None:
    terminal.type(TYPED[0])
    assert "2.5" in terminal.until("MIS_TAKEOFF_ALT ")
    terminal.type("param set MIS_TAKEOFF_ALT 4")
    time.sleep(1.0)  # it says nothing when all is well
    terminal.type(TYPED[0])
    assert "4.0" in terminal.until("MIS_TAKEOFF_ALT ")


def test_no_fence_breach_is_announced(terminal: Terminal) -> None:
    assert "breach" not in terminal.everything()


def test_a_waypoint_file_is_loaded_and_read_back(terminal: Terminal, folder: Path) -> None:
    terminal.type(TYPED[1])
    terminal.until("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
    terminal.type("wp save back.txt")
    terminal.until("waypoints to back.txt")
    assert items(folder / "back.txt") == pytest.approx(items(folder / FIELD), abs=1.1e-6, nan_ok=True)


def test_the_mode_is_set_by_its_number(terminal: Terminal) -> None:
    assert TYPED[2] == f"mode {MISSION}"
    terminal.type(TYPED[2])
    terminal.until(f"Mode Mode({MISSION})")


def test_armed_it_flies_the_mission_and_lands(terminal: Terminal) -> None:
    terminal.type(TYPED[3])
    terminal.until("ARMED")
    for words in ("waypoint 3", "waypoint 6", "waypoint 8", "DISARMED"):
        terminal.until(words)
    assert "Failsafe" not in terminal.everything()


def items(file: Path) -> NDArray[np.float64]:
    """Everything but which one is current; MAVProxy writes places to six decimals."""
    rows = [[float(word) for word in line.split("\t")] for line in file.read_text().splitlines()[1:]]
    return np.delete(np.array(rows), 1, axis=1)

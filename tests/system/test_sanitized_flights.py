"""The simulator with sanitizers flies under the real ground station, and valgrind sees it end: no report."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from halfroll import simulator
from halfroll.flight import fly
from system.processes import HALFROLL, MISSIONS, free_instance

pytestmark = pytest.mark.long
SECTION = "Sanitizers"
SITL = Path(__file__).parents[2] / "build" / "asan" / "sim" / "halfroll-sitl"  # `make sanitized` builds it


@pytest.mark.reliability(SECTION, "missions of the simulator without a report: address, undefined behaviour, casts")
def test_a_mission_is_flown_without_a_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A report ends the simulator, and with it the flight."""
    monkeypatch.setattr(simulator, "executable", lambda: SITL)
    monkeypatch.setenv("ASAN_OPTIONS", "exitcode=99:detect_leaks=1")
    assert fly(MISSIONS / "box.plan", scenario="full", log_path=tmp_path / "flight.ulg").plan is not None


@pytest.mark.reliability(SECTION, "ends of the simulator that valgrind finds clean")
def test_it_ends_without_a_leak_or_a_read_of_what_was_never_written(tmp_path: Path) -> None:
    valgrind = ("valgrind", "--quiet", "--leak-check=full", "--errors-for-leak-kinds=all", "--error-exitcode=9")
    words = ("--instance", str(free_instance()), "--scenario", "full", "--duration", "1", "--speed", "0")
    files = ("--log", tmp_path / "flight.ulg", "--storage", tmp_path / "stored")
    done = subprocess.run(
        [*valgrind, HALFROLL.with_name("halfroll-sitl"), *words, *files], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr

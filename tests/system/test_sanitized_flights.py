"""All C++ under sanitizers, in no place a report: the simulator under the real ground station, the C++ tests, the
modules under Python's tests. And valgrind sees the simulator end."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from halfroll import simulator
from halfroll.flight import fly
from system.processes import HALFROLL, MISSIONS, free_instance

pytestmark = pytest.mark.long
SECTION = "Sanitizers"
ROOT = Path(__file__).parents[2]
ASAN, TSAN = (ROOT / "build" / name for name in ("asan", "tsan"))  # `make sanitized` builds them
REPORT = 99  # exit code
CPP_SUITES = ("autopilot", "board", "core", "flight", "kernel", "link", "sim")
PYTHON_SUITES = ("tests/firmware", "tests/sim", "tests/ground/test_plan.py", "tests/ground/test_proof.py")
WITHOUT = "without a report: addresses, integers, undefined behaviour"


def sitl_flies(build: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A report ends the simulator, and with it the flight."""
    monkeypatch.setattr(simulator, "executable", lambda: build / "sim" / "halfroll-sitl")
    monkeypatch.setenv("ASAN_OPTIONS", f"exitcode={REPORT}:detect_leaks=1")
    monkeypatch.setenv("TSAN_OPTIONS", f"exitcode={REPORT}:halt_on_error=1")
    assert fly(MISSIONS / "box.plan", scenario="full", log_path=tmp_path / "flight.ulg").plan is not None


def module_passes(build: Path, runtime: str, *tests: str) -> None:
    library = subprocess.run(
        ["clang++", f"-print-file-name=libclang_rt.{runtime}-x86_64.so"], capture_output=True, text=True, check=True
    ).stdout.strip()
    environment = {
        **os.environ,
        "LD_PRELOAD": library,
        "SANITIZED_BUILD": str(build),
        "PYTHONPATH": str(ROOT / "tests"),
        "ASAN_OPTIONS": f"exitcode={REPORT}:detect_leaks=0",  # Python keeps what it has until the end
        "TSAN_OPTIONS": f"exitcode={REPORT}:halt_on_error=1",
    }
    words = [sys.executable, "-m", "pytest", "-q", "-p", "sanitized", "-m", "not long", *tests]
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]


@pytest.mark.reliability(SECTION, f"missions of the simulator {WITHOUT}")
def test_a_mission_is_flown_without_a_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sitl_flies(ASAN, tmp_path, monkeypatch)


@pytest.mark.reliability(SECTION, "missions of the simulator without a report: threads")
def test_a_mission_is_flown_without_a_data_race(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sitl_flies(TSAN, tmp_path, monkeypatch)


@pytest.mark.reliability(SECTION, f"suites of C++ tests {WITHOUT}")
@pytest.mark.parametrize("suite", CPP_SUITES)
def test_the_cpp_tests_pass_without_a_report(suite: str) -> None:
    words = [
        Path(sys.executable).with_name("ctest"),
        "--test-dir",
        ASAN,
        "--output-on-failure",
        "--no-tests=error",
        "-R",
        f"^{suite}_tests$",
    ]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:]


@pytest.mark.reliability(SECTION, f"suites of Python tests, their modules {WITHOUT}")
@pytest.mark.parametrize("tests", PYTHON_SUITES)
def test_the_modules_pass_python_tests_without_a_report(tests: str) -> None:
    module_passes(ASAN, "asan", tests)


@pytest.mark.reliability(SECTION, "suites of Python tests, their modules without a report: threads")
def test_many_threads_fly_batches_without_a_data_race() -> None:
    module_passes(TSAN, "tsan", "tests/sim/test_batch.py")


@pytest.mark.reliability(SECTION, "ends of the simulator that valgrind finds clean")
def test_it_ends_without_a_leak_or_a_read_of_what_was_never_written(tmp_path: Path) -> None:
    valgrind = ("valgrind", "--quiet", "--leak-check=full", "--errors-for-leak-kinds=all", "--error-exitcode=9")
    words = ("--instance", str(free_instance()), "--scenario", "full", "--duration", "1", "--speed", "0")
    files = ("--log", tmp_path / "flight.ulg", "--storage", tmp_path / "stored")
    done = subprocess.run(
        [*valgrind, HALFROLL.with_name("halfroll-sitl"), *words, *files], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr

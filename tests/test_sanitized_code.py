"""All C++ under sanitizers, in no place a report: the C++ tests, the modules under Python's tests, and flights in
threads under the thread sanitizer. `make sanitized` builds what runs here.

The simulator under the real ground station is in system/test_sanitized_flights.py.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.long
SECTION = "Sanitizers"
ROOT = Path(__file__).parents[1]
ASAN, TSAN = (ROOT / "build" / name for name in ("asan", "tsan"))
CPP_SUITES = ("autopilot", "board", "core", "flight", "kernel", "link", "sim", "threads")
PYTHON_SUITES = (
    "tests/firmware/test_autopilot.py",
    "tests/firmware/test_estimator.py",
    "tests/firmware/test_floods.py",
    "tests/firmware/test_position_targets.py",
    "tests/ground/test_segments.py",
    "tests/sim/test_batch.py",
    "tests/sim/test_faults.py",
)
WITHOUT = "without a report: addresses, integers, undefined behaviour"


def cpp_suite_passes(build: Path, suite: str) -> None:
    ctest = Path(sys.executable).with_name("ctest")
    words = [ctest, "--test-dir", build, "--output-on-failure", "--no-tests=error", "-R", f"^{suite}_tests$"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:]


@pytest.mark.reliability(SECTION, f"suites of C++ tests {WITHOUT}")
@pytest.mark.parametrize("suite", CPP_SUITES)
def test_the_cpp_tests_pass_without_a_report(suite: str) -> None:
    cpp_suite_passes(ASAN, suite)


@pytest.mark.reliability(SECTION, "suites of flights in threads without a report: data races")
def test_flights_in_threads_pass_without_a_data_race() -> None:
    cpp_suite_passes(TSAN, "threads")


@pytest.mark.reliability(SECTION, f"suites of Python tests, their modules {WITHOUT}")
@pytest.mark.parametrize("tests", PYTHON_SUITES)
def test_the_modules_pass_python_tests_without_a_report(tests: str) -> None:
    libraries = []
    for name in ("libclang_rt.asan-x86_64.so", "libstdc++.so.6"):  # the latter, or exceptions are not followed
        asked = ["clang++", f"-print-file-name={name}"]
        libraries.append(subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip())
    environment = {
        **os.environ,
        "LD_PRELOAD": ":".join(libraries),
        "SANITIZED_BUILD": str(ASAN),
        "PYTHONPATH": str(ROOT / "tests"),
        "ASAN_OPTIONS": "exitcode=99:detect_leaks=0",  # Python keeps what it has until the end
    }
    words = [sys.executable, "-m", "pytest", "-q", "-p", "sanitized", "-m", "not long", tests]
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]

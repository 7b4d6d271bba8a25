"""The typed stubs of the bound modules are what the modules really offer."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

STUBS = Path(__file__).parents[2] / "ground" / "halfroll"


@pytest.mark.parametrize("module", ["_firmware", "_planner"])
def test_the_stub_says_what_the_module_offers(module: str, tmp_path: Path) -> None:
    """If not: pybind11-stubgen halfroll._firmware -o build/stubs, and copy the result over the stub."""
    command = [sys.executable, "-m", "pybind11_stubgen", f"halfroll.{module}", "-o", str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    assert (tmp_path / "halfroll" / f"{module}.pyi").read_text() == (STUBS / f"{module}.pyi").read_text()

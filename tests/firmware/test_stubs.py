"""The typed stub of the bound firmware is what the module really offers."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

STUB = Path(__file__).parents[2] / "ground" / "halfroll" / "_firmware.pyi"


def test_the_stub_says_what_the_module_offers(tmp_path: Path) -> None:
    """If not: pybind11-stubgen halfroll._firmware -o build/stubs, and copy the result over the stub."""
    command = [sys.executable, "-m", "pybind11_stubgen", "halfroll._firmware", "-o", str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    assert (tmp_path / "halfroll" / "_firmware.pyi").read_text() == STUB.read_text()

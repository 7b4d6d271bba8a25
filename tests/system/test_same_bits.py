"""One seed, one flight: every rotor command equal in every bit, whatever else the machine does."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from system.processes import MISSIONS, halfroll


def commands_hash(folder: Path, seed: int) -> str:
    ended = halfroll("fly", MISSIONS / "box.plan", "--seed", str(seed), "--json", "--out", folder)
    assert ended.code == 0, ended.err
    return str(ended.json["commands_sha256"])


@contextmanager
def busy_machine() -> Iterator[None]:
    """As many spinning processes as there are processors."""
    loads = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for load in loads:
            load.kill()
            load.wait()


@pytest.fixture(scope="module")
def first_hash(tmp_path_factory: pytest.TempPathFactory) -> str:
    return commands_hash(tmp_path_factory.mktemp("first"), seed=1)


def test_the_same_seed_flies_the_same_commands(first_hash: str, tmp_path: Path) -> None:
    assert commands_hash(tmp_path, seed=1) == first_hash


def test_it_does_so_on_a_loaded_machine(first_hash: str, tmp_path: Path) -> None:
    with busy_machine():
        assert commands_hash(tmp_path, seed=1) == first_hash


def test_another_seed_flies_other_commands(first_hash: str, tmp_path: Path) -> None:
    assert commands_hash(tmp_path, seed=2) != first_hash

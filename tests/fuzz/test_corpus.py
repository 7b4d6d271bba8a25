"""Inputs that fuzzing found worth keeping, and those that once broke something, hold."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from fuzz.run import ROOT, TARGETS, unpack

REPLAY = ROOT / "build" / "editable" / "tests" / "fuzz"


@pytest.mark.parametrize("target", TARGETS)
def test_every_input_that_was_kept_leaves_all_invariants_whole(target: str, tmp_path: Path) -> None:
    unpack(target, tmp_path)
    count = len(list(tmp_path.iterdir()))
    assert count > 0
    replay = subprocess.run([REPLAY / f"fuzz_{target}", tmp_path], capture_output=True, text=True)
    assert replay.returncode == 0, replay.stderr + replay.stdout.splitlines()[-1]
    assert replay.stdout.endswith(f"{count} inputs held\n")

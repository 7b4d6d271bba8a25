"""What a person sees who watches `halfroll fly` in a terminal."""

from __future__ import annotations

import os
import pty
import subprocess
from pathlib import Path

from system.processes import HALFROLL, MISSIONS


def test_a_terminal_shows_mode_rotors_and_texts_while_it_flies(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    words = [HALFROLL, "fly", MISSIONS / "box.plan", "--out", tmp_path]
    with subprocess.Popen(words, stdin=theirs, stdout=subprocess.DEVNULL, stderr=theirs) as flight:
        os.close(theirs)
        seen = b""
        try:
            while chunk := os.read(ours, 65536):
                seen += chunk
        except OSError:  # how Linux says that the other end is closed
            os.close(ours)
    assert flight.returncode == 0
    drawn = seen.decode()
    for what in ("box.plan", "mode", "OFFBOARD", "speed", "rear", "plan ready"):
        assert what in drawn, what

"""A logged flight, flown again by the simulator from all that its firmware heard.

Why: the proof that a log is whole; and a flight that went wrong can be looked at again, bit for bit, under a debugger.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from halfroll import simulator
from halfroll.errors import InputError, LinkError
from halfroll.flight_recorder import copy_of_the_grounds

_FLEW = re.compile(r"flew ([0-9.]+) s of vehicle time, commands_sha256 ([0-9a-f]{64})")
_BAD_OPTION = 2  # exit code of halfroll-sitl


@dataclass(frozen=True)
class Replayed:
    """flown_s: of vehicle time; commands_sha256: of every rotor command."""

    flown_s: float
    commands_sha256: str
    log: Path


def replay(log: Path, new_log: Path) -> Replayed:
    """Flies `log` again, as far as it goes, and writes new_log, with what the ground knew.

    Raises InputError for what cannot be flown again, LinkError.
    """
    if not log.is_file():
        raise InputError(f"{log}: there is no such log; check the name")
    if new_log.exists() and new_log.samefile(log):
        raise InputError(f"{new_log}: this is the log that is replayed; write the new one elsewhere")
    words = [str(simulator.executable()), "--replay", str(log), "--log", str(new_log)]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    said = (ended.stderr.strip().splitlines() or [""])[-1].removeprefix("halfroll-sitl: ")
    if ended.returncode == _BAD_OPTION:
        raise InputError(said.removeprefix("--replay "))
    found = _FLEW.search(ended.stdout)
    if ended.returncode != 0 or found is None:
        raise LinkError(f"{log}: the simulator ended with exit code {ended.returncode}: {said}")
    copy_of_the_grounds(log, new_log)
    return Replayed(float(found[1]), found[2], new_log)

"""Flights on a board: what halfroll-sitl reports of them.

Why: the tests and `make hil` fly the same ones. Each is flown by the board and, on the same inputs, by the simulator's
own firmware, which counts every bit of rotor commands and state that differs.
"""

from __future__ import annotations

import json
import math
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from halfroll.boards import EMULATED, command
from system.gcs import ACCEPTED, Gcs
from system.processes import HALFROLL, Ended, Running, free_instance, halfroll

MISSION = Path(__file__).parents[2] / "examples" / "first_flight.plan"
SITL = HALFROLL.with_name("halfroll-sitl")
ARM, TAKEOFF, INVERTED, FLIP = 400, 22, 210, 31010
ROLL = 1
NOT_YET = 1  # temporarily rejected
TURN_OVER, TURN_BACK, ROLL_ROUND = (INVERTED, (1.0,)), (INVERTED, (0.0,)), (FLIP, (ROLL, 1.0, math.nan, math.nan))
TURNS = (TURN_OVER, TURN_BACK, ROLL_ROUND)
TURN_MS = 3000
_REPORT = re.compile(r"^halfroll-sitl: board (\{.*\})$", re.MULTILINE)


@dataclass(frozen=True)
class Report:
    """One flight on a board."""

    name: str
    commands_sha256: str
    figures: dict[str, Any]


def mission_flight(board: str | None, folder: Path, mission: Path = MISSION, seed: int = 1) -> Report:
    """`halfroll fly` in lockstep; without a board, in the simulator alone."""
    given = [] if board is None else ["--board", board, "--board-beside"]
    ended: Ended = halfroll("fly", mission, "--seed", str(seed), "--json", "--out", folder / (board or "sitl"), *given)
    assert ended.code == 0, ended.err
    return Report(board or "sitl", ended.json["commands_sha256"], ended.json.get("board") or {})


def flip_flight(board: str, duration_s: float, turns: Sequence[tuple[int, tuple[float, ...]]] = TURNS) -> Report:
    """Take off by MAVLink, turn over, hang upside down, turn back, flip; then hover.

    `duration_s` of vehicle time, as fast as the board goes."""
    instance = free_instance()
    words = ("--instance", str(instance), "--speed", "0", "--duration", f"{duration_s:g}", "--seed", "1")
    with Running(SITL, *words, "--board", command(board), "--board-beside") as running:
        running.until_it_says("ready")
        with Gcs(instance) as gcs:
            gcs.until(lambda m: m.get_type() == "LOCAL_POSITION_NED")
            assert gcs.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == ACCEPTED
            gcs.arm()
            gcs.until(lambda m: m.get_type() == "LOCAL_POSITION_NED" and m.z < -9.7)
            for number, params in turns:
                while (answer := gcs.command(number, *params)) != ACCEPTED:
                    assert answer == NOT_YET  # the turn before is not at rest
                    gcs.until(lambda m: m.get_type() == "HEARTBEAT")
                began = gcs.until(lambda m: m.get_type() == "LOCAL_POSITION_NED").time_boot_ms
                gcs.until(lambda m, t=began: m.get_type() == "LOCAL_POSITION_NED" and m.time_boot_ms > t + TURN_MS)
                assert upside_down(gcs) == ((number, params) == TURN_OVER)
        ended = running.wait()
    assert ended.code == 0, ended.err
    found = re.search(r"commands_sha256 ([0-9a-f]{64})", ended.out)
    figures = _REPORT.search(ended.out)
    assert found is not None
    assert figures is not None
    return Report(board, found[1], json.loads(figures[1]))


def upside_down(gcs: Gcs) -> bool:
    q = gcs.until(lambda m: m.get_type() == "ATTITUDE_QUATERNION")
    return bool(1.0 - 2.0 * (q.q2**2 + q.q3**2) < 0.0)


def sizes(board: str) -> dict[str, int]:
    """Flash and static RAM of the image [bytes], without stack and without the window that stands for flash pages."""
    said = subprocess.run(
        ["arm-none-eabi-size", "-A", EMULATED[board].image], capture_output=True, text=True, check=True
    ).stdout
    section = {line.split()[0]: int(line.split()[1]) for line in said.splitlines() if line.startswith(".")}
    ram = section.get(".data", 0) + section.get(".bss", 0) + section.get(".noinit", 0)
    return {
        "flash_bytes": section[".text"] + section.get(".ARM.exidx", 0) + section.get(".data", 0),
        "ram_bytes": ram,
        "stack_reserved_bytes": section[".stack"],
    }

"""The simulator is killed at any moment of a flight: the log reaches to within 0.2 s of it.

Why: the flight that matters is the one that nobody ended. Vehicle time at the kill is what telemetry said last.
"""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest
from pyulog import ULog

from halfroll.results.log import read_log
from system.gcs import Gcs
from system.processes import HALFROLL, Running, free_instance

pytestmark = pytest.mark.long

KILLS = 50
LOST_S = 0.2


def until_killed(instance: int, running: Running, after_s: float) -> float:
    """Arms, takes off, kills. Vehicle time as last heard [s]."""
    with Gcs(instance) as gcs:
        gcs.until(lambda message: message.get_type() == "HEARTBEAT", gcs.heartbeat())
        gcs.arm()
        gcs.command(22, 0, 0, 0, float("nan"), float("nan"), float("nan"), float("nan"))
        until = time.monotonic() + after_s
        while time.monotonic() < until:
            gcs.receive()
        running.process.kill()
        running.process.wait()
        while gcs.receive():
            pass
        return float(gcs.last["ATTITUDE"].time_boot_ms) * 1e-3


def test_fifty_logs_of_fifty_kills_reach_to_within_0_2_s(tmp_path: Path) -> None:
    chance, instance = random.Random(11), free_instance()
    lost = []
    for kill in range(KILLS):
        path = tmp_path / f"{kill}.ulg"
        words = ("--instance", str(instance), "--log", path, "--seed", str(kill))
        with Running(HALFROLL.with_name("halfroll-sitl"), *words) as running:
            running.until_it_says("ready")
            killed_s = until_killed(instance, running, chance.uniform(0.3, 2.5))
        log = read_log(path)
        lost.append(killed_s - log["vehicle_truth"].t[-1])
        assert lost[-1] <= LOST_S
        assert not log.damaged
        assert not ULog(str(path)).file_corruption
        assert log["vehicle_state"]["armed"].any()
        path.unlink()
    print(f"lost at most {max(lost):.3f} s before the kill, {sum(lost) / KILLS:.3f} s on the mean")

"""Whole flights: simulator, ground station and pilot as processes, over UDP, in lockstep."""

from __future__ import annotations

import math
import os
import signal
from pathlib import Path

import pytest

from halfroll.errors import MissionError, PortInUse, SimulatorDied
from halfroll.flight import OFFBOARD_PORT, fly
from halfroll.missions.mission import Mission, MissionItem
from halfroll.wire.transport import UdpTransport

NAN = math.nan
HERE, NORTH = (473977420, 85455940), (473977600, 85455940)
HOP = Mission(
    "hop",
    (
        MissionItem(22, 3, (0.0, 0.0, 0.0, NAN), *HERE, 2.0),
        MissionItem(16, 3, (0.0, 0.0, 0.0, NAN), *NORTH, 3.0),
        MissionItem(16, 3, (0.0, 0.0, 0.0, NAN), *HERE, 2.0),
        MissionItem(21, 3, (0.0, 0.0, 0.0, NAN), *HERE, 0.0),
    ),
)


def processes_about(path: Path) -> list[int]:
    """Simulators that write this log. (Linux)"""
    found = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if str(path).encode() in entry.read_bytes():
                found.append(int(entry.parent.name))
        except (FileNotFoundError, ProcessLookupError):
            continue
    return [pid for pid in found if pid != os.getpid()]


def test_a_mission_is_flown_from_upload_to_landing_with_a_hundred_references_a_second(tmp_path):
    events = []
    flown = fly(HOP, scenario="ideal", log_path=tmp_path / "hop.ulg", report=events.append)
    assert flown.plan is not None
    assert flown.reference_rate_Hz == pytest.approx(100.0, abs=1e-6)
    assert flown.plan_end_s - flown.plan_start_s == pytest.approx(flown.plan.T, abs=0.011)
    assert flown.log_path.stat().st_size > 0
    kinds = [event.kind for event in events]
    order = ["uploaded", "planned", "armed", "approach", "flying", "handed-back", "landed"]
    assert [kind for kind in kinds if kind in order] == order
    assert processes_about(flown.log_path) == []


def test_one_seed_is_one_flight_and_another_seed_another(tmp_path):
    hashes = [fly(HOP, seed=seed, log_path=tmp_path / "hop.ulg").commands_sha256 for seed in (1, 1, 2)]
    assert hashes[0] == hashes[1] != hashes[2]
    assert len(hashes[0]) == 64


def test_a_simulator_that_is_killed_ends_the_flight_and_what_was_lost_is_said(tmp_path):
    log = tmp_path / "hop.ulg"

    def kill(event):
        if event.kind == "approach":
            for pid in processes_about(log):
                os.kill(pid, signal.SIGKILL)

    with pytest.raises(SimulatorDied, match=r"SIGKILL at \d+\.\d\d s of vehicle time, .* item \d of 3") as caught:
        fly(HOP, log_path=log, lockstep=False, speed=1.0, report=kill)
    assert caught.value.exit_code == 3


def test_ctrl_c_leaves_no_process_behind(tmp_path):
    log = tmp_path / "hop.ulg"

    def interrupt(event):
        if event.kind == "armed":
            assert processes_about(log)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fly(HOP, log_path=log, report=interrupt)
    assert processes_about(log) == []


def test_a_taken_port_is_named_when_the_instance_is_given_and_avoided_when_not(tmp_path):
    taken = UdpTransport.bind(OFFBOARD_PORT + 7)
    try:
        with pytest.raises(PortInUse, match=str(taken.port)):
            fly(HOP, instance=7, log_path=tmp_path / "hop.ulg")
    finally:
        taken.close()


def test_a_mission_far_away_is_refused_at_start_with_the_item(tmp_path):
    far = Mission("far", (MissionItem(22, 3, (0.0, 0.0, 0.0, NAN), -353630000, 1491650000, 30.0), *HOP.items[1:]))
    with pytest.raises(MissionError, match=r"the autopilot says: .*item 0") as caught:
        fly(far, log_path=tmp_path / "far.ulg")
    assert caught.value.item == 0
    assert caught.value.exit_code == 2

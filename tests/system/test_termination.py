"""SIGTERM, as service managers send it, ends a command like Ctrl-C; and a mission without an end is not begun."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from system.processes import HALFROLL, MISSIONS, Ended, Running, free_instance, halfroll

TERMINATED = 143
HOVER_FOR_EVER = """QGC WPL 110
0\t1\t3\t22\t0\t0\t0\t0\t47.397742\t8.545594\t3\t1
1\t0\t3\t16\t0\t0\t0\t0\t47.397842\t8.545594\t3\t1
2\t0\t3\t17\t0\t0\t0\t0\t47.397942\t8.545594\t3\t1
"""


def assert_quiet(ended: Ended) -> None:
    assert ended.code == TERMINATED
    assert "Traceback" not in ended.err
    assert "Warning" not in ended.err


@pytest.mark.parametrize("moment", ["plan\n", "fly the plan\n"], ids=["planning", "flying"])
def test_a_flight_that_is_terminated_leaves_nobody_and_nothing(
    moment: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    words = ("--scenario", "ideal", "--speed", "5", "--out", tmp_path / "flight")
    with Running(HALFROLL, "fly", MISSIONS / "box.plan", *words) as flight:
        flight.until_it_says(moment)
        os.kill(flight.process.pid, signal.SIGTERM)
        assert_quiet(flight.wait())
        assert flight.left_behind() == {}
    assert [entry.name for entry in tmp_path.iterdir()] == ["flight"]


def test_a_ground_station_that_is_terminated_leaves_nobody() -> None:
    with Running(HALFROLL, "ground", "--instance", str(free_instance())) as ground:
        ground.until_it_says("waiting for an autopilot")
        os.kill(ground.process.pid, signal.SIGTERM)
        assert_quiet(ground.wait())
        assert ground.left_behind() == {}


@pytest.mark.parametrize("command", ["check", "fly"])
def test_a_mission_that_never_ends_is_named_with_its_item(command: str, tmp_path: Path) -> None:
    mission = tmp_path / "forever.waypoints"
    mission.write_text(HOVER_FOR_EVER)
    ended = halfroll(command, mission, cwd=tmp_path)
    assert ended.code == 2
    (sentence,) = ended.sentences
    assert "the mission never ends: item 2 (LOITER_UNLIM)" in sentence

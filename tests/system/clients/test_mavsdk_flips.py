"""A mission that turns over, uploaded by MAVSDK's raw mission calls and flown by `halfroll ground` as its own process.

Why: flips are items like any other: a client that knows nothing of them must store them, read them back equal, and
start them. Real time, for MAVSDK has only the wall's clock.
"""

from __future__ import annotations

import contextlib
import importlib
import re
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from halfroll import preflight
from halfroll.body_axes import body_up
from halfroll.missions.mission import Mission, MissionItem
from halfroll.missions.mission_files import load_mission
from halfroll.planner.course import with_takeoff_and_landing
from halfroll.results.evaluation import FlightFigures, evaluate
from halfroll.results.log import Log, read_log
from system.processes import HALFROLL, Running, free_instance, simulator

pytestmark = pytest.mark.long

DEADLINE_S = 120.0
MISSION = """
[[waypoint]]
position_m = [0, 0, 6]
[[manoeuvre]]
at = 0
kind = "half_roll"
[[manoeuvre]]
at = 0
kind = "half_roll"
turns = -0.5
[[waypoint]]
position_m = [3, 0, 6]
[[manoeuvre]]
at = 1
kind = "inverted_leg"
length_m = 3
[[manoeuvre]]
at = 1
kind = "flip"
"""
TURNED_OVER = 3  # times: half roll and back, the inverted leg, the flip


def plugin(name: str) -> Any:
    """Imported late: only make test-long installs MAVSDK."""
    return importlib.import_module(f"mavsdk.plugins.{name}")


@dataclass(frozen=True)
class Flown:
    uploaded: Sequence[MissionItem]
    downloaded: Sequence[MissionItem]
    figures: FlightFigures
    log: Log
    said: str  # by the ground station


def raw(items: Sequence[MissionItem]) -> list[Any]:
    of = plugin("mission_raw").MissionItem
    return [
        of(
            seq,
            item.frame,
            item.command,
            int(seq == 0),
            int(item.autocontinue),
            *item.params,
            item.x,
            item.y,
            item.z,
            0,
        )
        for seq, item in enumerate(items)
    ]


def cooked(items: Sequence[Any]) -> list[MissionItem]:
    return [
        MissionItem(i.command, i.frame, (i.param1, i.param2, i.param3, i.param4), i.x, i.y, i.z, bool(i.autocontinue))
        for i in items
    ]


def until(holds: Callable[[], bool]) -> None:
    began = time.monotonic()
    while not holds():
        assert time.monotonic() - began < DEADLINE_S
        time.sleep(0.02)


def complete(folder: Path) -> Mission:
    """The mission's items with a takeoff first and a landing last, as a ground station would draw them."""
    (folder / "flips.toml").write_text(MISSION, encoding="utf-8")
    mission, _ = with_takeoff_and_landing(load_mission(folder / "flips.toml"))
    return Mission("flips", mission.items)


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    folder = tmp_path_factory.mktemp("flips")
    mission = complete(folder)
    instance = free_instance()
    with contextlib.ExitStack() as stack:
        ground = stack.enter_context(Running(HALFROLL, "ground", "--instance", str(instance)))
        ground.until_it_says("waiting for an autopilot")
        stack.enter_context(simulator("--scenario", "nominal", "--log", folder / "flight.ulg", instance=instance))
        mavsdk: Any = importlib.import_module("mavsdk")
        configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
        client = mavsdk.Mavsdk(configuration)
        stack.callback(client.destroy)
        client.add_any_connection(f"udpin://127.0.0.1:{14550 + instance}")
        system = client.first_autopilot(DEADLINE_S)
        assert system is not None
        missions, telemetry = plugin("mission_raw").MissionRaw(system), plugin("telemetry").Telemetry(system)
        missions.upload_mission(raw(mission.items))
        downloaded = cooked(missions.download_mission())
        ground.until_it_says("plan ready")
        until(telemetry.health_all_ok)
        missions.start_mission()
        plugin("action").Action(system).arm()
        until(telemetry.armed)
        until(lambda: not telemetry.armed())
        ground.process.send_signal(signal.SIGINT)
        said = ground.wait().out
    began = re.search(r"([\d.]+) s  flying the plan", said)
    assert began is not None, said
    log, plan = read_log(folder / "flight.ulg"), preflight.plan(mission)
    return Flown(mission.items, downloaded, evaluate(plan, float(began[1]), log, plan.vehicle), log, said)


def test_what_is_downloaded_is_what_was_uploaded(flown: Flown) -> None:
    assert len(flown.uploaded) > 6
    assert list(flown.downloaded) == list(flown.uploaded)


def test_it_turns_over_as_often_as_the_mission_says_and_lands_upright(flown: Flown) -> None:
    truth, state = flown.log["vehicle_truth"], flown.log["vehicle_state"]
    up = body_up(truth["q"].astype(float))[:, 2]
    changes = np.flatnonzero(np.diff(np.sign(up)))
    assert len(changes) == 2 * TURNED_OVER
    assert up.min() < -0.999
    assert up[-1] > 0.999
    assert not state["armed"][-1]


def test_the_ground_station_flies_it_within_centimetres_of_its_plan(flown: Flown) -> None:
    print(f"tracking {1e3 * flown.figures.tracking_max_m:.0f} mm at worst, {flown.figures.T_flown_s:.2f} s")
    assert flown.figures.tracking_max_m < 0.05
    assert flown.figures.within_limits

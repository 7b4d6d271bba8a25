"""MAVSDK as it comes from PyPI flies the vehicle, through the calls of its own examples.

Why: beside `halfroll ground`, which holds the offboard port, it comes by the GCS port; without a ground station the
offboard port is its own. Both ways must do. Real time, for MAVSDK has only the wall's clock.
"""

from __future__ import annotations

import contextlib
import importlib
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from system.processes import HALFROLL, Running, free_instance, simulator

pytestmark = pytest.mark.long

DEADLINE_S = 120.0
NORTH_DEG = 1.0 / 111_195.0  # a metre
GCS, OFFBOARD = 14550, 14540


def plugin(name: str) -> Any:
    """Imported late: only make test-long installs MAVSDK."""
    return importlib.import_module(f"mavsdk.plugins.{name}")


class Vehicle:
    """The plugins of one system."""

    def __init__(self, system: Any) -> None:
        self.action, self.mission = plugin("action").Action(system), plugin("mission").Mission(system)
        self.offboard, self.param = plugin("offboard").Offboard(system), plugin("param").Param(system)
        self.telemetry = plugin("telemetry").Telemetry(system)

    def until(self, holds: Callable[[], bool]) -> None:
        began = time.monotonic()
        while not holds():
            assert time.monotonic() - began < DEADLINE_S, f"still in {self.telemetry.flight_mode()}"
            time.sleep(0.02)

    def take_off(self, height_m: float) -> None:
        self.until(self.telemetry.health_all_ok)
        self.action.set_takeoff_altitude(height_m)
        self.action.arm()
        self.action.takeoff()
        self.until(lambda: abs(self.height_m - height_m) < 0.2)

    @property
    def height_m(self) -> float:
        return float(self.telemetry.position().relative_altitude_m)

    def until_landed(self) -> None:
        self.until(lambda: not self.telemetry.armed())
        assert self.height_m < 0.3


@pytest.fixture(scope="module", params=["the GCS port beside a ground station", "the offboard port alone"])
def vehicle(request: pytest.FixtureRequest) -> Iterator[Vehicle]:
    beside = "beside" in request.param
    instance = free_instance()
    with contextlib.ExitStack() as stack:
        if beside:
            ground = stack.enter_context(Running(HALFROLL, "ground", "--instance", str(instance)))
            ground.until_it_says("waiting for an autopilot")
        stack.enter_context(simulator("--scenario", "ideal", "--set", "params.RTL_RETURN_ALT=8", instance=instance))
        mavsdk: Any = importlib.import_module("mavsdk")
        configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
        client = mavsdk.Mavsdk(configuration)
        stack.callback(client.destroy)
        client.add_any_connection(f"udpin://127.0.0.1:{(GCS if beside else OFFBOARD) + instance}")
        system = client.first_autopilot(DEADLINE_S)
        assert system is not None
        yield Vehicle(system)


def test_it_connects_and_finds_the_vehicle_healthy(vehicle: Vehicle) -> None:
    vehicle.until(vehicle.telemetry.health_all_ok)
    assert vehicle.telemetry.health().is_armable
    vehicle.until(lambda: vehicle.telemetry.landed_state() == plugin("telemetry").LandedState.ON_GROUND)


def test_telemetry_comes(vehicle: Vehicle) -> None:
    t = vehicle.telemetry
    vehicle.until(lambda: t.position().latitude_deg == pytest.approx(47.397742, abs=1e-5))
    assert t.home().absolute_altitude_m == pytest.approx(488.0, abs=0.2)
    assert t.attitude_quaternion().w == pytest.approx(1.0, abs=0.01)
    vehicle.until(lambda: t.battery().remaining_percent > 50.0)
    vehicle.until(lambda: t.gps_info().num_satellites > 5)
    assert t.velocity_ned().down_m_s == pytest.approx(0.0, abs=0.1)


def test_parameters_are_listed_read_and_written(vehicle: Vehicle) -> None:
    listed = {each.name: each.value for each in vehicle.param.get_all_params().float_params}
    assert listed["SIM_SPEED"] == 1.0
    vehicle.param.set_param_float("NAV_ACC_RAD", 1.5)
    assert vehicle.param.get_param_float("NAV_ACC_RAD") == 1.5


def test_a_parameter_out_of_range_is_an_error_and_keeps_its_value(vehicle: Vehicle) -> None:
    with pytest.raises(plugin("param").ParamError, match="VALUE_OUT_OF_RANGE"):
        vehicle.param.set_param_float("MIS_TAKEOFF_ALT", 1000.0)
    assert vehicle.param.get_param_float("MIS_TAKEOFF_ALT") == 2.5


def test_it_arms_takes_off_goes_somewhere_and_lands(vehicle: Vehicle) -> None:
    vehicle.take_off(4.0)
    home, t = vehicle.telemetry.home(), vehicle.telemetry
    assert t.in_air()
    vehicle.action.goto_location(home.latitude_deg + 10 * NORTH_DEG, home.longitude_deg, 488.0 + 6.0, 90.0)
    vehicle.until(lambda: abs(t.position_velocity_ned().position.north_m - 10.0) < 0.2)
    vehicle.until(lambda: abs(vehicle.height_m - 6.0) < 0.2)
    vehicle.action.land()
    vehicle.until_landed()


def test_offboard_takes_negative_thrust(vehicle: Vehicle) -> None:
    """Twice the gravity downward for a quarter of a second, then braked in Hold."""
    vehicle.take_off(12.0)
    hover, attitude = 0.571 * 9.80665 / 12.0, plugin("offboard").Attitude
    vehicle.offboard.set_attitude(attitude(0.0, 0.0, 0.0, hover))
    vehicle.offboard.start()
    vehicle.until(lambda: vehicle.telemetry.flight_mode() == plugin("telemetry").FlightMode.OFFBOARD)
    vehicle.offboard.set_attitude(attitude(0.0, 0.0, 0.0, -hover))
    vehicle.until(lambda: vehicle.telemetry.velocity_ned().down_m_s > 4.0)
    assert vehicle.height_m > 8.5  # free fall would have needed 0.4 s and 0.8 m; nothing but a push is faster
    vehicle.offboard.set_attitude(attitude(0.0, 0.0, 0.0, 2.0 * hover))
    vehicle.offboard.stop()
    vehicle.until(lambda: abs(vehicle.telemetry.velocity_ned().down_m_s) < 0.1)
    vehicle.action.land()
    vehicle.until_landed()


def test_a_mission_is_uploaded_flown_with_progress_and_returns(vehicle: Vehicle) -> None:
    home = vehicle.telemetry.home()
    mission = plugin("mission")
    items = [
        mission.MissionItem(
            latitude_deg=home.latitude_deg + north * NORTH_DEG,
            longitude_deg=home.longitude_deg,
            relative_altitude_m=8.0,
            speed_m_s=5.0,
            is_fly_through=True,
            vehicle_action=mission.MissionItem.VehicleAction(1 if north == 0.0 else 0),  # a takeoff first
        )
        for north in (0.0, 10.0, 20.0)
    ]
    progress: list[int] = []
    vehicle.mission.subscribe_mission_progress(lambda at, *_: progress.append(at.current))
    vehicle.mission.set_return_to_launch_after_mission(True)
    vehicle.mission.upload_mission(mission.MissionPlan(items))
    assert len(vehicle.mission.download_mission().mission_items) == 3
    vehicle.until(vehicle.telemetry.health_all_ok)
    vehicle.action.arm()
    vehicle.mission.start_mission()
    vehicle.until(vehicle.mission.is_mission_finished)
    vehicle.until_landed()
    assert progress == sorted(progress)
    assert progress[-1] == 3


def test_the_script_of_the_page_flies(tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "connect.md").read_text()
    (script,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    with simulator("--scenario", "ideal") as (running, instance):
        (tmp_path / "fly.py").write_text(script.replace("14550", str(14550 + instance)))
        done = subprocess.run([sys.executable, tmp_path / "fly.py"], capture_output=True, text=True, timeout=DEADLINE_S)
        assert done.returncode == 0, done.stderr
        assert running.process.poll() is None

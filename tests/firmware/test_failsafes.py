"""What makes the autopilot act by itself, flown: each condition, its action and its recovery.

The firmware flies a simulated vehicle inside this process; ground stations are bytes that pymavlink packs.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from session import Session, hovering

from halfroll import _dialect as dialect

LAND, RETURN, HOLD = "Land", "Return", "Hold"
CRITICAL, WARNING, EMERGENCY = 2, 4, 0
GEOFENCE, MOTORS = 0x100000, 0x8000


@pytest.fixture(scope="module")
def hover() -> Session:
    return hovering(height=10.0)


def no_numbers(_: Any) -> list[float]:
    return [math.nan] * 3


def with_params(flight: Session, **params: float) -> Session:
    flight = flight.copy()
    for name, value in params.items():
        flight.set(name, value)
    return flight


@pytest.mark.parametrize(("action", "mode"), [(0, HOLD), (1, HOLD), (2, RETURN), (3, LAND)])
def test_a_ground_station_that_falls_silent_is_missed_after_com_dl_loss_t(
    hover: Session, action: int, mode: str
) -> None:
    flight = with_params(hover, NAV_DLL_ACT=action, COM_DL_LOSS_T=5.0)
    flight.run(8000)
    assert flight.texts() == []  # none was ever heard
    flight.heartbeat()
    flight.run(4900)
    assert flight.texts() == []
    flight.run(200)
    ((_, severity, text),) = flight.texts()
    assert (severity, text) == (CRITICAL if action else WARNING, "Failsafe: GCS lost")
    assert flight.autopilot.mode == mode
    flight.heartbeat()
    flight.run(100)
    assert flight.texts()[-1][2] == "Failsafe: GCS regained"
    assert flight.autopilot.mode == mode  # only a new mode command changes it


def test_the_status_stays_critical_while_the_ground_station_is_lost(hover: Session) -> None:
    flight = with_params(hover, NAV_DLL_ACT=1, COM_DL_LOSS_T=5.0)
    flight.heartbeat()
    flight.run(15000)
    assert flight.last("HEARTBEAT").system_status == 5
    flight.heartbeat()
    flight.run(1200)
    assert flight.last("HEARTBEAT").system_status == 4


@pytest.mark.parametrize(
    ("action", "mode", "severity"),
    [(1, HOLD, WARNING), (2, HOLD, CRITICAL), (3, RETURN, CRITICAL), (5, LAND, CRITICAL)],
)
def test_the_fence_acts_when_it_is_crossed(hover: Session, action: int, mode: str, severity: int) -> None:
    flight = hover.copy()
    assert flight.reposition(north=20.0) == 0
    flight = with_params(flight, GF_MAX_HOR_DIST=5.0, GF_ACTION=action)
    assert flight.last("SYS_STATUS").onboard_control_sensors_health & GEOFENCE
    flight.run(6000)
    ((_, said, text),) = flight.texts()
    assert said == severity
    assert text == ("Failsafe: fence" if action == 1 else f"Failsafe: fence, {mode}")
    assert flight.autopilot.mode == mode
    if action == 2:
        status = flight.last("SYS_STATUS")
        assert status.onboard_control_sensors_enabled & GEOFENCE
        assert not status.onboard_control_sensors_health & GEOFENCE


def test_the_fence_has_a_ceiling_too_and_is_quiet_inside(hover: Session) -> None:
    flight = with_params(hover, GF_MAX_VER_DIST=12.0)
    flight.reposition(height=11.5)
    flight.run(5000)
    assert flight.texts() == []
    flight.set("GF_MAX_VER_DIST", 30.0)
    flight.reposition(height=20.0)
    flight.set("GF_MAX_VER_DIST", 12.0)
    flight.run(5000)
    assert [text for _, _, text in flight.texts()] == ["Failsafe: fence, Hold"]
    assert flight.world.p_WB[2] < 15.0


@pytest.mark.parametrize("action", [2, 3, 4, 5])
def test_nobody_is_sent_across_a_fence_that_would_act(hover: Session, action: int) -> None:
    flight = with_params(hover, GF_MAX_HOR_DIST=15.0, GF_MAX_VER_DIST=12.0, GF_ACTION=action)
    assert flight.reposition(north=20.0) == 1
    assert flight.texts()[-1][2] == "Command: outside the fence"
    assert flight.reposition(height=20.0) == 1
    assert flight.reposition(north=14.0, height=11.0) == 0


@pytest.mark.parametrize("action", [0, 1])
def test_a_fence_that_only_warns_leaves_the_choice_to_the_user(hover: Session, action: int) -> None:
    assert with_params(hover, GF_MAX_HOR_DIST=15.0, GF_ACTION=action).reposition(north=20.0) == 0


def test_after_a_failsafe_a_user_may_choose_the_mode_again(hover: Session) -> None:
    flight = with_params(hover, GF_MAX_VER_DIST=5.0, GF_ACTION=5)
    flight.run(100)
    assert flight.autopilot.mode == LAND
    assert flight.mode(4, 3) == 0
    flight.run(2000)
    assert flight.autopilot.mode == HOLD  # still above the fence, but told once


def test_a_critical_battery_lands_and_leaves_only_landing_and_returning(hover: Session) -> None:
    flight = hover.copy()
    flight.state_of_charge = 0.15
    flight.run(500)
    assert flight.texts()[-1][1:] == (WARNING, "Battery low")
    assert flight.autopilot.mode == HOLD
    flight.state_of_charge = 0.05
    flight.run(100)
    assert flight.texts()[-1][1:] == (CRITICAL, "Failsafe: battery critical, Land")
    assert flight.autopilot.mode == LAND
    assert flight.mode(4, 3) == 1
    assert flight.texts()[-1][2] == "Mode: no Hold: battery critical"
    assert flight.mode(4, 5) == 0
    flight.run(1000)
    assert flight.autopilot.mode == RETURN


def test_the_stronger_of_two_failsafes_wins_in_either_order(hover: Session) -> None:
    for first in ("fence", "battery"):
        flight = with_params(hover, GF_MAX_VER_DIST=5.0, GF_ACTION=3) if first == "fence" else hover.copy()
        flight.state_of_charge = 0.15
        flight.run(200)
        flight.state_of_charge = 0.05
        flight.run(200)
        if first == "battery":
            flight.set("GF_ACTION", 3.0)
            flight.set("GF_MAX_VER_DIST", 5.0)
            flight.run(200)
        assert flight.autopilot.mode == LAND


@pytest.mark.parametrize("vehicle", ["mit-vp", "mit-fp", "race-5in"])
@pytest.mark.parametrize("rotor", [1, 4])
def test_a_weak_rotor_is_found_named_and_landed_with(vehicle: str, rotor: int) -> None:
    flight = hovering(vehicle, "nominal", height=5.0)
    flight.effectiveness[rotor - 1] = 0.6
    flight.run(2000)
    assert (CRITICAL, f"Failsafe: rotor {rotor}, Land") in [said[1:] for said in flight.texts()]
    assert flight.autopilot.mode == LAND
    assert not flight.last("SYS_STATUS").onboard_control_sensors_health & MOTORS
    flight.run(15000)
    assert abs(flight.world.p_WB[2]) < 0.05
    assert not flight.autopilot.armed


def test_a_rotor_stuck_where_it_was_is_found(hover: Session) -> None:
    flight = hover.copy()
    flight.stuck[1] = 1.4
    flight.reposition(north=15.0)  # hovering, it does just what it should
    flight.run(3000)
    assert "Failsafe: rotor 2, Land" in [text for _, _, text in flight.texts()]


@pytest.mark.parametrize("vehicle", ["mit-vp", "mit-fp", "race-5in"])
def test_sound_rotors_are_never_accused(vehicle: str) -> None:
    flight = hovering(vehicle, "nominal", height=10.0)
    flight.set("MPC_ACC_HOR", 8.0)
    flight.set("MPC_JERK_AUTO", 40.0)
    for north, west in ((20.0, 0.0), (0.0, 20.0), (-20.0, 0.0), (0.0, 0.0)):
        flight.reposition(north=north, west=west)
        flight.run(4000)
    assert flight.texts() == []


def test_tumbling_for_two_seconds_ends_the_flight() -> None:
    flight = hovering(height=40.0)
    flight.effectiveness[0] = -1.0  # whatever it is told, the opposite
    flight.run(1500)
    assert flight.autopilot.armed
    flight.run(1500)
    assert (EMERGENCY, "Failsafe: attitude lost, terminate") in [said[1:] for said in flight.texts()]
    assert not flight.autopilot.armed
    flight.run(1200)
    assert flight.last("HEARTBEAT").system_status == 6
    assert flight.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 1


def test_a_sensor_that_gives_no_numbers_keeps_the_vehicle_from_arming() -> None:
    flight = Session()
    flight.run(1000)
    good = flight.gyro
    flight.gyro = no_numbers
    flight.run(200)
    assert flight.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1, 21196) == 1
    assert flight.texts()[-1][2] == "Arming denied: gyro or accelerometer"
    flight.gyro = good
    flight.run(1000)
    assert flight.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0

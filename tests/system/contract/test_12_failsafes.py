"""Contract, section 12: what the autopilot does by itself. (The rows that need a fault are flown in tests/firmware.)"""

from __future__ import annotations

import pytest

from system.contract.aircraft import ACCEPTED, NOT_NOW, OFFBOARD, RTL, A, Aircraft, dialect

CRITICAL = 2  # MAV_SEVERITY


def test_a_lost_position_lands_and_says_so(hovering: Aircraft) -> None:
    client = hovering.client()
    hovering.run(1.0, pose=False)
    assert hovering.autopilot.mode == "Land"
    (text,) = client.all("STATUSTEXT")
    assert (text.text, text.severity) == ("Failsafe: position lost, Land", CRITICAL)


def test_without_a_position_there_is_no_return(hovering: Aircraft) -> None:
    client = hovering.client()
    hovering.run(1.0, pose=False)
    assert client.set_mode(RTL) == NOT_NOW


def test_without_a_position_it_comes_down_level_and_disarms(hovering: Aircraft) -> None:
    hovering.run(25.0, pose=False)
    assert hovering.world.p_WB[2] < 0.05
    assert not hovering.autopilot.armed


@pytest.mark.parametrize(("action", "mode"), [(0, "Hold"), (1, "Land"), (2, "Return"), (3, "Hold")])
def test_a_lost_stream_does_what_its_parameter_says(hovering: Aircraft, action: int, mode: str) -> None:
    client = hovering.client(A)
    client.set_param("OFB_LOSS_ACT", action)
    assert client.set_mode(OFFBOARD) == ACCEPTED
    hovering.stream(client, 0.2)
    hovering.run(0.6)
    assert hovering.autopilot.mode == mode
    assert client.texts[-1] == f"Failsafe: offboard lost, {mode}"


def test_with_a_mission_a_lost_stream_may_go_on_with_it(on_mission: Aircraft) -> None:
    client = on_mission.client(A)
    client.set_param("OFB_LOSS_ACT", 3)
    assert client.set_mode(OFFBOARD) == ACCEPTED
    on_mission.stream(client, 0.2)
    on_mission.run(0.6)
    assert on_mission.autopilot.mode == "Mission"
    assert client.texts[-1] == "Failsafe: offboard lost, Mission"


@pytest.mark.parametrize(("action", "mode"), [(0, "Mission"), (1, "Hold"), (2, "Return"), (3, "Land")])
def test_a_mission_goes_on_without_its_ground_station_unless_a_parameter_says_otherwise(
    on_mission: Aircraft, action: int, mode: str
) -> None:
    client = on_mission.client()
    client.set_param("NAV_DLL_ACT", action)
    client.set_param("COM_DL_LOSS_T", 1.0)
    client.ask(client.encode.heartbeat_encode(dialect.MAV_TYPE_GCS, 8, 0, 0, 0))
    on_mission.run(1.2)
    assert on_mission.autopilot.mode == mode
    assert client.texts == ["Failsafe: GCS lost"]


def test_an_item_that_a_limit_forbids_meanwhile_is_held_before(on_mission: Aircraft) -> None:
    client = on_mission.client()
    client.set_param("MIS_ALT_MAX", 5.0)
    on_mission.run(0.2)
    assert on_mission.autopilot.mode == "Hold"
    (text,) = client.all("STATUSTEXT")
    assert (text.text, text.severity) == ("Mission: item 2 not flyable, Hold", CRITICAL)
    assert client.all("HEARTBEAT")[-1].system_status == 5

"""Contract, section 14: the peculiar ways of MAVSDK, QGroundControl and MAVProxy. The programs themselves fly in
tests/system/clients."""

from __future__ import annotations

import pytest

from system.contract.aircraft import (
    ACCEPTED,
    DENIED,
    INT32_MAX,
    MISSION,
    NAN,
    OFFBOARD,
    UNSUPPORTED,
    A,
    Aircraft,
    Client,
    Item,
)
from system.contract.missions import LINE, RTL_ITEM, away, item

OPEN = (NAN,) * 4


@pytest.mark.parametrize("name", ["MANUAL", "ACRO", "ALT_HOLD", "AUTO", "GUIDED", "LOITER", "LAND"])
def test_a_mode_name_of_mavproxy_arrives_as_another_firmwares_number_and_is_denied(pilot: Client, name: str) -> None:
    number = {"MANUAL": 0, "ACRO": 1, "ALT_HOLD": 2, "AUTO": 3, "GUIDED": 4, "LOITER": 5, "LAND": 9}[name]
    assert pilot.command(176, 1, number) == DENIED
    assert pilot.aircraft.autopilot.mode == "Hold"


def test_mode_rtl_of_mavproxy_is_offboard_and_falls_back_to_hold(pilot: Client) -> None:
    assert pilot.command(176, 1, 6) == ACCEPTED
    assert pilot.aircraft.autopilot.mode == "Offboard"
    pilot.aircraft.run(1.1)
    assert pilot.aircraft.autopilot.mode == "Hold"
    assert pilot.texts == ["Offboard: no setpoints"]


@pytest.mark.parametrize(("number", "mode"), [(84148224, "Return"), (67371008, "Mission"), (100925440, "Land")])
def test_mode_and_a_number_of_mavproxy_is_entered(pilot: Client, number: int, mode: str) -> None:
    assert pilot.upload(LINE) == 0
    assert pilot.command(176, 1, number) == ACCEPTED
    assert pilot.aircraft.autopilot.mode == mode


def test_mavproxys_long_return_to_launch(pilot: Client) -> None:
    assert pilot.command(20, 0, 0, 0, 0, 0, 0, 0) == ACCEPTED
    assert pilot.aircraft.autopilot.mode == "Return"


def test_mavproxy_asks_component_0_for_home(gcs: Client) -> None:
    assert gcs.command(410, target=(1, 0)) == ACCEPTED


def test_mavproxy_moves_one_waypoint_by_a_partial_write(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    gcs.ask(gcs.encode.mission_write_partial_list_encode(1, 1, 1, 1))
    frame, command, autocontinue, params, x, y, _ = LINE[1]
    gcs.item(1, (frame, command, autocontinue, params, x, y, 33.0))
    assert gcs.download()[1][6] == 33.0


def test_mavproxys_file_request_falls_back_to_the_list(gcs: Client) -> None:
    payload = [0, 0, 0, 4, 16, 0, 0, 0, 0, 0, 0, 0, *b"@PARAM/param.pck", *[0] * 223]
    answer = gcs.only("FILE_TRANSFER_PROTOCOL", gcs.encode.file_transfer_protocol_encode(0, 1, 1, payload))
    assert answer.payload[3] == 129


def test_mavsdk_arms_with_everything_else_open(gcs: Client) -> None:
    assert gcs.command(400, 1, *[NAN] * 6) == ACCEPTED


def test_mavsdks_arm_force_is_a_disarm_and_obeyed(pilot: Client) -> None:
    assert pilot.command(400, 0, 21196, NAN, NAN, NAN, NAN, NAN) == ACCEPTED
    assert not pilot.aircraft.autopilot.armed


def test_mavsdk_sets_a_mode_with_the_rest_open(pilot: Client) -> None:
    assert pilot.command(176, 1, 6, NAN, NAN, NAN, NAN, NAN) == ACCEPTED
    assert pilot.aircraft.autopilot.mode == "Offboard"


def test_mavsdk_sees_the_error_before_the_value(gcs: Client) -> None:
    kinds = [m.get_type() for m in gcs.set_param("MIS_TAKEOFF_ALT", 1e6)]
    assert kinds.index("PARAM_ERROR") < kinds.index("PARAM_VALUE")


def test_mavsdks_current_item_is_confirmed_at_once(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    assert [m.seq for m in gcs.ask(gcs.encode.mission_set_current_encode(1, 1, 2)) if m.get_type() == "MISSION_CURRENT"]


def test_mavsdks_mission_with_open_parameters_is_taken(gcs: Client) -> None:
    mission: list[Item] = [
        (6, 22, 1, OPEN, 473977420, 85455940, 10.0),
        item(16, 0, 1, NAN, NAN, frame=6, north=10.0),
        item(178, 1, 5, -1, NAN, frame=2, x=0, y=0, z=NAN),
        item(1000, -2, -2, NAN, NAN, frame=2, x=0, y=0, z=NAN),
        item(93, -1, 0, 0, 0, frame=2, x=0, y=0, z=NAN),
        item(2000, 0, 0, 1, NAN, frame=2, x=0, y=0, z=NAN),
        (2, 20, 1, OPEN, 0, 0, NAN),
    ]
    assert gcs.upload(mission) == 0


def test_mavsdks_health_needs_sensors_position_and_home(grounded: Aircraft) -> None:
    client = grounded.client()
    grounded.run(2.1)
    wanted = 0x1 | 0x2 | 0x4 | 0x20
    m = client.all("SYS_STATUS")[-1]
    assert m.onboard_control_sensors_present & m.onboard_control_sensors_health & wanted == wanted
    assert client.all("HOME_POSITION")


def test_mavsdk_streams_negative_thrust_at_20_Hz(hovering: Aircraft) -> None:
    client = hovering.client(A, system=245)
    assert client.set_mode(OFFBOARD) == ACCEPTED
    hovering.stream(client, 0.5, period_ms=50, type_mask=7, thrust=-0.2, time_boot_ms=0)
    assert sum(hovering.world.rotor_thrust) < 0.0
    assert client.texts == []


def test_qgroundcontrol_sets_modes_by_message_and_watches_the_heartbeat(pilot: Client) -> None:
    assert pilot.upload(LINE) == 0
    answers = pilot.ask(pilot.encode.set_mode_encode(1, 157, MISSION))
    assert [m.custom_mode for m in answers if m.get_type() == "HEARTBEAT"] == [MISSION]


@pytest.mark.parametrize(("message_id", "result"), [(148, 0), (435, 0), (397, 2), (395, 2), (300, 2)])
def test_qgroundcontrols_first_requests_are_all_answered(gcs: Client, message_id: int, result: int) -> None:
    assert gcs.command(512, message_id) == result


def test_qgroundcontrol_starts_a_mission_by_mode_and_then_arming(gcs: Client) -> None:
    assert gcs.upload([*LINE[:2], RTL_ITEM]) == 0
    gcs.ask(gcs.encode.set_mode_encode(1, 29, MISSION))
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.fly(6.0)
    assert gcs.aircraft.world.p_WB[2] > 3.0


def test_qgroundcontrol_saves_after_edits(gcs: Client) -> None:
    gcs.set_param("MIS_TAKEOFF_ALT", 4.0)
    assert gcs.command(245, 1) == ACCEPTED


def test_qgroundcontrol_pauses_by_repositioning_to_nowhere(on_mission: Aircraft) -> None:
    client = on_mission.client()
    assert client.command(192, -1, 1, 0, NAN, NAN, NAN, NAN) == ACCEPTED
    assert on_mission.autopilot.mode == "Hold"


def test_a_home_line_in_front_is_not_flown(gcs: Client) -> None:
    """MAVProxy and every WPL file put home first."""
    home: Item = (0, 16, 1, (0.0, 0.0, 0.0, 0.0), 473977420, 85455940, 488.0)
    assert gcs.upload([home, *LINE]) == 0
    assert gcs.request(42).seq == 1


def test_a_command_none_of_them_knows_is_unsupported(gcs: Client) -> None:
    assert gcs.command(31999, INT32_MAX) == UNSUPPORTED


def test_an_item_none_of_them_may_store_is_refused(gcs: Client) -> None:
    assert gcs.upload([LINE[0], away(5001)]) == 3

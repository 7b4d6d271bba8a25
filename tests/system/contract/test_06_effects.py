"""Contract, section 6: what commands do."""

from __future__ import annotations

import math

import pytest

from system.contract.aircraft import (
    ACCEPTED,
    DENIED,
    FAILED,
    HOLD,
    INT32_MAX,
    MISSION,
    NAN,
    NOT_NOW,
    OFFBOARD,
    ORIGIN_LAT,
    ORIGIN_LON,
    A,
    Aircraft,
    Client,
)
from system.contract.missions import LINE, RTL_ITEM

Params = tuple[float, ...]


def test_takeoff_waits_for_arming_and_climbs_to_its_height(gcs: Client) -> None:
    assert gcs.command(22, 0, 0, 0, NAN, 12.0, 34.0, 6.0) == ACCEPTED
    assert gcs.aircraft.autopilot.mode == "Takeoff"
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.fly(10.0)
    assert gcs.aircraft.world.p_WB == pytest.approx([0, 0, 6.0], abs=0.1)


def test_takeoff_without_height_climbs_to_the_parameters(gcs: Client) -> None:
    gcs.set_param("MIS_TAKEOFF_ALT", 4.0)
    assert gcs.command(22, 0, 0, 0, NAN, NAN, NAN, NAN) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.fly(10.0)
    assert gcs.aircraft.world.p_WB[2] == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(("frame", "z"), [(0, 494.0), (5, 494.0), (3, 6.0), (6, 6.0)])
def test_a_takeoff_height_by_command_int_is_in_its_frame(gcs: Client, frame: int, z: float) -> None:
    assert gcs.command_int(22, frame, (0, 0, 0, 0), 0, 0, z) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.fly(10.0)
    assert gcs.aircraft.world.p_WB[2] == pytest.approx(6.0, abs=0.1)


def test_mission_start_from_an_item(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    assert gcs.command(300, 2) == ACCEPTED
    assert gcs.request(42).seq == 2


def test_pause_holds_and_continue_goes_on_where_it_stopped(on_mission: Aircraft) -> None:
    client = on_mission.client()
    seq = client.request(42).seq
    assert client.command(193, 0) == ACCEPTED
    on_mission.fly(5.0)
    stopped = on_mission.world.p_WB[0]
    m = client.request(42)
    assert (m.seq, m.mission_state) == (seq, 4)
    assert client.command(193, 1) == ACCEPTED
    on_mission.fly(2.0)
    assert on_mission.world.p_WB[0] > stopped


def test_set_mission_current_is_told_at_once(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    answers = gcs.ask(gcs.encode.command_long_encode(1, 1, 224, 0, 3, 0, 0, 0, 0, 0, 0))
    assert [m.seq for m in answers if m.get_type() == "MISSION_CURRENT"][-1] == 3


def test_reposition_goes_there(pilot: Client) -> None:
    x, y = ORIGIN_LAT + (10 * 90), ORIGIN_LON
    assert pilot.command_int(192, 6, (-1, 1, 0, NAN), x, y, 15.0) == ACCEPTED
    pilot.aircraft.fly(10.0)
    assert pilot.aircraft.world.p_WB == pytest.approx([10.0, 0, 15.0], abs=0.3)


def test_reposition_of_nothing_stops_here(on_mission: Aircraft) -> None:
    client = on_mission.client()
    assert client.command_int(192, 6, (-1, 1, 0, NAN), INT32_MAX, INT32_MAX, NAN) == ACCEPTED
    on_mission.fly(6.0)
    assert on_mission.autopilot.mode == "Hold"
    assert abs(on_mission.world.v_WB[0]) < 0.05


@pytest.mark.parametrize(("params", "heading"), [((90, 0, 1, 0), 90.0), ((30, 0, -1, 1), -30.0)])
def test_condition_yaw_turns_by_the_compass(pilot: Client, params: Params, heading: float) -> None:
    assert pilot.command(115, *params) == ACCEPTED
    pilot.aircraft.run(5.0)
    assert math.degrees(pilot.all("ATTITUDE")[-1].yaw) == pytest.approx(heading, abs=1.0)


def test_change_speed_caps_the_follower(on_mission: Aircraft) -> None:
    client = on_mission.client()
    assert client.command(178, 1, 1.5) == ACCEPTED
    on_mission.fly(4.0)
    assert on_mission.world.v_WB[0] == pytest.approx(1.5, abs=0.2)


def test_a_given_home_is_shown(gcs: Client) -> None:
    assert gcs.command_int(179, 0, (0, 0, 0, 0), 473990000, 85460000, 490.5) == ACCEPTED
    m = gcs.request(242)
    assert (m.latitude, m.longitude, m.altitude) == (473990000, 85460000, 490500)


@pytest.mark.parametrize("by_message", [False, True])
def test_a_given_origin_is_shown_with_the_same_integers(gcs: Client, by_message: bool) -> None:
    if by_message:
        gcs.ask(gcs.encode.set_gps_global_origin_encode(1, 470000001, 80000003, 400123))
    else:
        assert gcs.command_int(611, 0, (0, 0, 0, 0), 470000001, 80000003, 400.123) == ACCEPTED
    m = gcs.all("GPS_GLOBAL_ORIGIN")[-1]
    assert (m.latitude, m.longitude, m.altitude) == (470000001, 80000003, 400123)


def test_an_origin_is_kept_while_armed(gcs: Client) -> None:
    assert gcs.command(400, 1) == ACCEPTED
    gcs.ask(gcs.encode.set_gps_global_origin_encode(1, 470000001, 80000003, 400123))
    assert gcs.request(49).latitude == ORIGIN_LAT


def test_get_message_interval_answers(gcs: Client) -> None:
    m = gcs.only("MESSAGE_INTERVAL", gcs.encode.command_long_encode(1, 1, 510, 0, 30, 0, 0, 0, 0, 0, 0))
    assert (m.message_id, m.interval_us) == (30, 100000)


@pytest.mark.parametrize(("number", "kind"), [(520, "AUTOPILOT_VERSION"), (410, "HOME_POSITION")])
def test_an_old_request_is_acknowledged_and_then_answered(gcs: Client, number: int, kind: str) -> None:
    answers = gcs.ask(gcs.encode.command_long_encode(1, 0, number, 0, 1, 0, 0, 0, 0, 0, 0))
    assert [m.get_type() for m in answers] == ["COMMAND_ACK", kind]


def test_home_asked_for_before_there_is_one_is_not_now() -> None:
    assert Aircraft.new().client().command(410) == NOT_NOW


def test_parameters_are_reset(gcs: Client) -> None:
    gcs.set_param("MIS_TAKEOFF_ALT", 4.0)
    assert gcs.command(245, 2) == ACCEPTED
    assert gcs.read_param("MIS_TAKEOFF_ALT") == 2.5


def test_saving_parameters_fails_when_the_storage_does(gcs: Client) -> None:
    gcs.set_param("MIS_TAKEOFF_ALT", 4.0)
    gcs.aircraft.autopilot.storage_works = False
    assert gcs.command(245, 1) == FAILED
    gcs.aircraft.autopilot.storage_works = True
    assert gcs.command(245, 1) == ACCEPTED


def test_termination_stops_the_motors_until_the_next_boot(pilot: Client) -> None:
    assert pilot.command(185, 1) == ACCEPTED
    pilot.aircraft.run(1.1)
    assert not pilot.aircraft.autopilot.armed
    assert pilot.all("HEARTBEAT")[-1].system_status == 6
    assert pilot.command(400, 1, 21196) == NOT_NOW


def test_prearm_checks_are_run_aloud(gcs: Client) -> None:
    gcs.count(2)  # an upload is in progress
    assert gcs.command(401) == ACCEPTED
    assert gcs.texts == ["Arming denied: mission upload in progress"]


def test_command_int_and_long_mean_the_same(gcs: Client) -> None:
    assert gcs.command_int(400, 2, (1, 0, 0, 0), 0, 0, 0.0) == ACCEPTED
    assert gcs.aircraft.autopilot.armed


def test_mission_items_sent_as_commands_change_nothing(pilot: Client) -> None:
    assert pilot.upload([*LINE[:4], RTL_ITEM]) == 0
    for number in (16, 17, 19, 177):
        assert pilot.command(number, 1, 1, 1, 1, 47.4, 8.5, 10) == DENIED
    assert pilot.aircraft.autopilot.mode == "Hold"
    assert pilot.set_mode(OFFBOARD) == pilot.set_mode(MISSION) == pilot.set_mode(HOLD) == ACCEPTED


def test_the_offboard_link_takes_commands_too(grounded: Aircraft) -> None:
    assert grounded.client(A).command(400, 1) == ACCEPTED

"""Contract, section 10: how far the mission is, and who may say so."""

from __future__ import annotations

import pytest

from system.contract.aircraft import ACCEPTED, HOLD, MISSION, NOT_NOW, OFFBOARD, RTL, A, Aircraft, Client, Item
from system.contract.missions import LAND_ITEM, LINE, RTL_ITEM, TAKEOFF_ITEM, away, waypoint

NONE, NOT_STARTED, ACTIVE, PAUSED, COMPLETE = range(1, 6)


def state(client: Client) -> int:
    return int(client.request(42).mission_state)


def start(client: Client, mission: list[object]) -> None:
    assert client.upload(mission) == 0  # type: ignore[arg-type]
    assert client.command(300) == ACCEPTED
    assert client.command(400, 1) == ACCEPTED


def until_disarmed(aircraft: Aircraft) -> None:
    for _ in range(120):
        aircraft.run(1.0)
        if not aircraft.autopilot.armed:
            return
    raise AssertionError("still armed after two minutes")


def test_without_a_mission(gcs: Client) -> None:
    m = gcs.request(42)
    assert (m.total, m.mission_state, m.mission_mode, m.mission_id) == (65535, NONE, 2, 0)


def test_stored_but_not_started(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    m = gcs.request(42)
    assert (m.seq, m.total, m.mission_state, m.mission_mode) == (0, len(LINE), NOT_STARTED, 2)
    assert (m.fence_id, m.rally_points_id) == (0, 0)


def test_being_flown(on_mission: Aircraft) -> None:
    m = on_mission.client().request(42)
    assert (m.seq, m.total, m.mission_state, m.mission_mode) == (2, len(LINE), ACTIVE, 1)


def test_paused(on_mission: Aircraft) -> None:
    client = on_mission.client()
    assert client.set_mode(HOLD) == ACCEPTED
    assert (state(client), client.request(42).mission_mode) == (PAUSED, 2)


def test_complete_stays_complete(gcs: Client) -> None:
    start(gcs, [TAKEOFF_ITEM, LAND_ITEM])
    until_disarmed(gcs.aircraft)
    gcs.aircraft.run(5.0)
    m = gcs.request(42)
    assert (m.mission_state, m.seq) == (COMPLETE, 1)


def test_a_complete_mission_entered_again_begins_at_its_first_item(gcs: Client) -> None:
    start(gcs, [TAKEOFF_ITEM, LAND_ITEM])
    until_disarmed(gcs.aircraft)
    assert gcs.set_mode(MISSION) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    until_disarmed(gcs.aircraft)
    assert [m.seq for m in gcs.all("MISSION_ITEM_REACHED")] == [0, 1, 0, 1]


def test_each_item_is_reached_once_and_in_order(gcs: Client) -> None:
    start(gcs, [TAKEOFF_ITEM, away(178, 1, 4), waypoint(8.0), away(93, 0.2), waypoint(0.0), LAND_ITEM])
    until_disarmed(gcs.aircraft)
    assert [m.seq for m in gcs.all("MISSION_ITEM_REACHED")] == [0, 1, 2, 3, 4, 5]


def test_a_return_is_reached_and_the_mission_complete_when_it_starts(gcs: Client) -> None:
    gcs.set_param("RTL_RETURN_ALT", 10.0)
    start(gcs, [TAKEOFF_ITEM, waypoint(8.0), RTL_ITEM])
    while gcs.aircraft.autopilot.mode != "Return":
        gcs.aircraft.run(0.1)
    gcs.aircraft.run(0.1)
    assert [m.seq for m in gcs.all("MISSION_ITEM_REACHED")] == [0, 1, 2]
    assert state(gcs) == COMPLETE


def test_a_landing_is_reached_when_landed(gcs: Client) -> None:
    start(gcs, [TAKEOFF_ITEM, LAND_ITEM])
    until_disarmed(gcs.aircraft)
    reached, states = gcs.times("MISSION_ITEM_REACHED")[-1], gcs.all("EXTENDED_SYS_STATE")
    landed = [t for t, m in gcs.heard if m.get_type() == "EXTENDED_SYS_STATE" and m.landed_state == 1][-1]
    assert states
    assert abs(landed - reached) < 2500


def test_otherwise_it_ends_at_the_last_item_in_hold(gcs: Client) -> None:
    start(gcs, [TAKEOFF_ITEM, waypoint(8.0)])
    gcs.aircraft.run(25.0)
    assert gcs.aircraft.autopilot.mode == "Hold"
    assert (gcs.request(42).seq, state(gcs)) == (1, COMPLETE)


def test_the_current_item_is_set_by_message_and_told_to_all(gcs: Client) -> None:
    listener = gcs.aircraft.client(A)
    assert gcs.upload(LINE) == 0
    gcs.ask(gcs.encode.mission_set_current_encode(1, 1, 3))
    assert listener.all("MISSION_CURRENT")[-1].seq == 3


def test_a_current_item_out_of_range_is_refused_in_words(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    gcs.ask(gcs.encode.mission_set_current_encode(1, 1, 17))
    assert gcs.texts == ["Mission: no item 17"]
    assert gcs.request(42).seq == 0


def test_a_user_who_sets_the_current_item_in_flight_goes_there(on_mission: Aircraft) -> None:
    client = on_mission.client()
    client.ask(client.encode.mission_set_current_encode(1, 1, 1))
    on_mission.fly(8.0)
    assert on_mission.world.v_WB[0] < 0.0 or client.request(42).seq == 2
    assert on_mission.autopilot.mode == "Mission"


# The ground station flies it


@pytest.fixture
def ground(on_mission: Aircraft) -> Client:
    """Component 191, streaming in OFFBOARD."""
    client = on_mission.client(A, system=1, component=191)
    assert client.set_mode(OFFBOARD) == ACCEPTED
    on_mission.stream(client, 0.05)
    return client


def test_the_mission_stays_active_while_the_ground_station_flies_it(ground: Client) -> None:
    m = ground.request(42)
    assert (m.mission_state, m.mission_mode) == (ACTIVE, 2)


def test_the_ground_station_reports_items_up_to_its_next_one(ground: Client) -> None:
    assert ground.command(224, 4) == ACCEPTED
    ground.aircraft.stream(ground, 0.05)
    assert [m.seq for m in ground.all("MISSION_ITEM_REACHED")] == [2, 3]
    assert ground.request(42).seq == 4


def test_another_owner_pauses_the_mission(on_mission: Aircraft) -> None:
    user = on_mission.client(A)
    assert user.set_mode(OFFBOARD) == ACCEPTED
    on_mission.stream(user, 0.1)
    assert state(user) == PAUSED


def test_the_ground_station_reports_only_what_it_flies(on_mission: Aircraft) -> None:
    ground = on_mission.client(A, system=1, component=191)
    assert ground.command(224, 3) == NOT_NOW
    assert ground.request(42).seq == 2


def test_back_in_mission_the_follower_goes_on_from_the_reported_item(ground: Client) -> None:
    assert ground.command(224, 3) == ACCEPTED
    assert ground.set_mode(MISSION) == ACCEPTED
    m = ground.request(42)
    assert (m.seq, m.mission_state, m.mission_mode) == (3, ACTIVE, 1)


# Found when it starts


@pytest.mark.parametrize(
    ("mission", "why"),
    [
        ([TAKEOFF_ITEM, (0, 16, 1, (0, 0, 0, 0), 473977420, 85455940, 480.0)], "item 1 is 8 m below home"),
        ([waypoint(6500.0)], "item 0 is 6 km away"),
    ],
)
def test_what_cannot_be_flown_from_here_is_refused_at_the_start(pilot: Client, mission: list[object], why: str) -> None:
    assert pilot.upload(mission) == 0  # type: ignore[arg-type]
    assert pilot.set_mode(MISSION) == NOT_NOW
    assert pilot.texts == [f"Mode: no Mission: {why}"]


@pytest.mark.parametrize(
    ("limit", "items"), [("GF_MAX_HOR_DIST", [TAKEOFF_ITEM, waypoint(20.0)]), ("GF_MAX_VER_DIST", [TAKEOFF_ITEM])]
)
def test_a_mission_that_leaves_the_fence_is_refused_at_the_start(pilot: Client, limit: str, items: list[Item]) -> None:
    """As in PX4; with an action that only warns it is the user's choice."""
    assert pilot.upload(items) == 0
    pilot.set_param(limit, 9.0)
    assert pilot.set_mode(MISSION) == NOT_NOW
    assert pilot.texts == [f"Mode: no Mission: item {len(items) - 1} is outside the fence"]
    pilot.set_param("GF_ACTION", 1.0)
    assert pilot.set_mode(MISSION) == ACCEPTED


def test_an_rtl_asked_for_ends_nothing_for_good(on_mission: Aircraft) -> None:
    client = on_mission.client()
    assert client.set_mode(RTL) == ACCEPTED
    assert state(client) == PAUSED

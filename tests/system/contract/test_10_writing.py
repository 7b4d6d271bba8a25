"""Contract, section 10: writing, each row of its table."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import pytest

from system.contract.aircraft import ACCEPTED, HOLD, A, Aircraft, Client
from system.contract.missions import (
    ALL,
    CANCELLED,
    DENIED,
    ERROR,
    FENCE,
    INVALID_SEQUENCE,
    LAND_ITEM,
    LINE,
    OK,
    P1,
    RALLY,
    RTL_ITEM,
    TAKEOFF_ITEM,
    UNSUPPORTED,
    acks,
    away,
    kinds,
    other,
    waypoint,
)


def test_a_count_begins_an_upload(gcs: Client) -> None:
    (request,) = gcs.count(3)
    assert (request.get_type(), request.seq, request.mission_type) == ("MISSION_REQUEST_INT", 0, 0)
    assert (request.target_system, request.target_component) == (255, 190)


def test_a_count_of_none_clears(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    assert acks(gcs.count(0)) == [OK]
    assert gcs.download() == []


def test_partial_writing_replaces_some_items(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    (request,) = gcs.ask(gcs.encode.mission_write_partial_list_encode(1, 1, 2, 3))
    assert request.seq == 2
    gcs.item(2, waypoint(21.0))
    assert acks(gcs.item(3, waypoint(22.0))) == [OK]
    assert gcs.download() == [*LINE[:2], waypoint(21.0), waypoint(22.0), LINE[4]]


@pytest.mark.parametrize(("first", "last"), [(-1, 1), (3, 2), (0, 5), (5, 5), (-5, -1), (0, 32767)])
def test_partial_writing_outside_the_mission_is_refused(gcs: Client, first: int, last: int) -> None:
    assert gcs.upload(LINE) == OK
    assert acks(gcs.ask(gcs.encode.mission_write_partial_list_encode(1, 1, first, last))) == [INVALID_SEQUENCE]


WRITES: dict[str, Callable[[Client], Any]] = {
    "count": lambda c: c.encode.mission_count_encode(1, 1, 2),
    "partial": lambda c: c.encode.mission_write_partial_list_encode(1, 1, 0, 1),
    "clear": lambda c: c.encode.mission_clear_all_encode(1, 1),
}


@pytest.mark.parametrize("what", WRITES)
def test_while_the_mission_is_flown_it_is_not_changed(on_mission: Aircraft, what: str) -> None:
    client = on_mission.client()
    assert acks(client.ask(WRITES[what](client))) == [DENIED]
    assert client.texts == ["Mission: busy flying, change mode first"]
    assert client.download() == LINE


@pytest.mark.parametrize("what", WRITES)
def test_a_paused_mission_may_be_changed(on_mission: Aircraft, what: str) -> None:
    client = on_mission.client()
    assert client.set_mode(HOLD) == ACCEPTED
    assert DENIED not in acks(client.ask(WRITES[what](client)))


def test_a_count_again_restarts_the_upload(gcs: Client) -> None:
    for n in (5, 5, 3, 4, 2):
        (request,) = gcs.count(n)
        assert request.seq == 0
        assert gcs.item(0, TAKEOFF_ITEM)[-1].seq == 1
    assert acks(gcs.item(1, RTL_ITEM)) == [OK]
    assert gcs.download() == [TAKEOFF_ITEM, RTL_ITEM]


@pytest.mark.parametrize("what", WRITES)
def test_another_client_is_denied_during_an_upload_and_disturbs_nothing(gcs: Client, what: str) -> None:
    assert gcs.upload(LINE) == OK
    gcs.count(2)
    intruder = other(gcs)
    assert acks(intruder.ask(WRITES[what](intruder))) == [DENIED]
    gcs.item(0, TAKEOFF_ITEM)
    assert acks(gcs.item(1, RTL_ITEM)) == [OK]


def test_the_same_station_on_another_link_is_another_client(gcs: Client) -> None:
    gcs.count(2)
    assert acks(gcs.aircraft.client(A).count(2)) == [DENIED]


def test_a_bad_item_ends_the_upload_and_keeps_the_old_mission(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    gcs.count(3)
    gcs.item(0, TAKEOFF_ITEM)
    assert acks(gcs.item(1, waypoint(5.0, hold_s=-1.0))) == [P1]
    assert gcs.item(1, waypoint(5.0)) == []  # nothing is awaited any more
    assert gcs.download() == LINE


@pytest.mark.parametrize("seq", [0, 2, 3, 500, 65535])
def test_an_item_out_of_order_is_ignored(gcs: Client, seq: int) -> None:
    gcs.count(3)
    gcs.item(0, TAKEOFF_ITEM)
    assert gcs.item(seq, waypoint(5.0)) == []
    assert gcs.item(1, waypoint(5.0))[-1].seq == 2


def test_an_item_of_another_client_is_ignored(gcs: Client) -> None:
    gcs.count(2)
    assert other(gcs).item(0, TAKEOFF_ITEM) == []
    assert gcs.item(0, TAKEOFF_ITEM)[-1].seq == 1


@pytest.mark.parametrize("kind", [FENCE, RALLY])
def test_an_item_of_another_kind_is_ignored(gcs: Client, kind: int) -> None:
    gcs.count(2)
    assert gcs.item(0, TAKEOFF_ITEM, kind=kind) == []


def test_an_item_that_does_not_come_is_asked_for_again_every_250_ms(gcs: Client) -> None:
    gcs.count(2)
    gcs.aircraft.run(1.1)
    times = gcs.times("MISSION_REQUEST_INT")
    assert [after - before for before, after in itertools.pairwise(times)] == [250] * 4


def test_strays_cause_no_request(gcs: Client) -> None:
    gcs.count(3)
    gcs.item(0, TAKEOFF_ITEM)
    for _ in range(50):
        gcs.item(0, TAKEOFF_ITEM)
    assert [m.seq for m in gcs.all("MISSION_REQUEST_INT")] == [0, 1]


def test_after_5_s_without_an_item_the_upload_is_cancelled(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    gcs.count(2)
    began = gcs.aircraft.t_ms
    gcs.aircraft.run(6.0)
    (ended,) = [t for t, m in gcs.heard if m.get_type() == "MISSION_ACK" and m.type == CANCELLED]
    assert ended - began == pytest.approx(5000, abs=2)
    assert gcs.texts == ["Mission: upload timed out"]
    assert max(gcs.times("MISSION_REQUEST_INT")) < ended
    assert gcs.download() == LINE


def test_each_item_grants_another_5_s(gcs: Client) -> None:
    gcs.count(3)
    for seq, item in enumerate([TAKEOFF_ITEM, waypoint(5.0), RTL_ITEM]):
        gcs.aircraft.run(4.9)
        last = gcs.item(seq, item)
    assert acks(last) == [OK]


def test_strays_grant_nothing(gcs: Client) -> None:
    gcs.count(3)
    for _ in range(51):
        gcs.aircraft.run(0.1)
        gcs.item(2, RTL_ITEM)
    assert acks([m for _, m in gcs.heard]) == [CANCELLED]


def test_the_client_may_cancel(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    gcs.count(2)
    assert gcs.ask(gcs.encode.mission_ack_encode(1, 1, CANCELLED)) == []
    since = gcs.aircraft.t_ms
    gcs.aircraft.run(6.0)
    assert gcs.times("MISSION_REQUEST_INT", since) == gcs.times("MISSION_ACK", since) == []
    assert gcs.download() == LINE


def test_an_accepting_ack_of_the_client_is_no_cancel(gcs: Client) -> None:
    gcs.count(1)
    gcs.ask(gcs.encode.mission_ack_encode(1, 1, OK))
    assert acks(gcs.item(0, TAKEOFF_ITEM)) == [OK]


def test_clearing_drops_ones_own_upload(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    gcs.count(2)
    assert acks(gcs.ask(gcs.encode.mission_clear_all_encode(1, 1))) == [OK]
    assert gcs.download() == []


def test_an_item_nobody_asked_for_is_ignored(gcs: Client) -> None:
    assert gcs.item(0, TAKEOFF_ITEM) == []


@pytest.mark.parametrize("current", [2, 3])
def test_the_old_way_to_fly_to_a_point_is_unsupported(pilot: Client, current: int) -> None:
    assert acks(pilot.item(0, waypoint(50.0), current=current)) == [UNSUPPORTED]
    pilot.aircraft.fly(2.0)
    assert pilot.aircraft.world.p_WB[0] == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize(
    "mission",
    [[TAKEOFF_ITEM, away(177, 5, 1)], [TAKEOFF_ITEM, away(178, 1, 5), away(177, 1, -1)]],
    ids=["range", "loop"],
)
def test_a_mission_wrong_as_a_whole_is_refused_at_its_end(gcs: Client, mission: list[Any]) -> None:
    assert gcs.upload(LINE) == OK
    assert gcs.upload(mission) == P1
    assert gcs.download() == LINE


def test_the_accepting_ack_comes_once_and_the_progress_follows(gcs: Client) -> None:
    gcs.count(2)
    gcs.item(0, TAKEOFF_ITEM)
    answers = gcs.item(1, LAND_ITEM)
    assert kinds(answers) == ["MISSION_ACK", "MISSION_CURRENT"]
    gcs.aircraft.run(6.0)
    assert len(gcs.all("MISSION_ACK")) == 1


def test_items_are_asked_for_as_integers_even_when_they_come_as_floats(gcs: Client) -> None:
    gcs.count(2)
    message = gcs.encode.mission_item_encode(1, 1, 0, 3, 22, 0, 1, 0, 0, 0, 0, 47.5, 8.5, 10.0)
    assert kinds(gcs.ask(message)) == ["MISSION_REQUEST_INT"]


def test_a_failing_storage_keeps_the_old_mission(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    gcs.aircraft.autopilot.storage_works = False
    assert gcs.upload([TAKEOFF_ITEM, LAND_ITEM]) == ERROR
    assert acks(gcs.ask(gcs.encode.mission_clear_all_encode(1, 1))) == [ERROR]
    assert gcs.download() == LINE


@pytest.mark.parametrize("kind", [0, ALL])
def test_clearing_is_done_even_when_there_is_nothing(gcs: Client, kind: int) -> None:
    for mission in (LINE, []):
        assert gcs.upload(mission) == OK
        assert acks(gcs.ask(gcs.encode.mission_clear_all_encode(1, 1, kind))) == [OK]
        assert gcs.download() == []


def test_the_same_items_have_the_same_id_and_others_another(gcs: Client) -> None:
    ids = []
    for mission in (LINE, LINE[:3], LINE, [TAKEOFF_ITEM, waypoint(20.0, hold_s=1.0)]):
        assert gcs.upload(mission) == OK
        ids.append(gcs.request(42).mission_id)
    assert ids[0] == ids[2]
    assert len(set(ids)) == 3

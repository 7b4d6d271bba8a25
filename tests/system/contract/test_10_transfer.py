"""Contract, section 10: how missions are read, written, kept and cleared."""

from __future__ import annotations

import pytest

from system.contract.aircraft import Aircraft, Client
from system.contract.missions import (
    FENCE,
    INVALID_SEQUENCE,
    LINE,
    NO_SPACE,
    OK,
    RALLY,
    TAKEOFF_ITEM,
    UNSUPPORTED,
    acks,
    other,
    waypoint,
)

# Other kinds of mission


@pytest.mark.parametrize("kind", [FENCE, RALLY])
def test_fence_and_rally_are_empty_sets(gcs: Client, kind: int) -> None:
    m = gcs.only("MISSION_COUNT", gcs.encode.mission_request_list_encode(1, 1, kind))
    assert (m.count, m.mission_type) == (0, kind)


@pytest.mark.parametrize("kind", [FENCE, RALLY])
def test_nothing_is_taken_into_them(gcs: Client, kind: int) -> None:
    (ack,) = gcs.count(1, kind)
    assert (ack.type, ack.mission_type) == (UNSUPPORTED, kind)
    (ack,) = gcs.count(0, kind)
    assert (ack.type, ack.mission_type) == (OK, kind)


@pytest.mark.parametrize("kind", [FENCE, RALLY])
def test_clearing_them_is_done_and_leaves_the_mission(gcs: Client, kind: int) -> None:
    assert gcs.upload(LINE) == OK
    (ack,) = gcs.ask(gcs.encode.mission_clear_all_encode(1, 1, kind))
    assert (ack.type, ack.mission_type) == (OK, kind)
    assert len(gcs.download()) == len(LINE)


@pytest.mark.parametrize("kind", [3, 77, 254])
def test_any_other_kind_is_unsupported(gcs: Client, kind: int) -> None:
    for message in (
        gcs.encode.mission_count_encode(1, 1, 1, kind),
        gcs.encode.mission_request_list_encode(1, 1, kind),
        gcs.encode.mission_clear_all_encode(1, 1, kind),
        gcs.encode.mission_request_int_encode(1, 1, 0, kind),
    ):
        (ack,) = gcs.ask(message)
        assert (ack.type, ack.mission_type) == (UNSUPPORTED, kind)


# Capacity


def test_two_thousand_items_are_stored(gcs: Client) -> None:
    mission = [TAKEOFF_ITEM, *[waypoint(float(i % 50)) for i in range(1999)]]
    assert gcs.upload(mission) == OK
    assert gcs.download()[1999] == mission[1999]


def test_more_are_refused_at_the_count(gcs: Client) -> None:
    assert acks(gcs.count(2001)) == [NO_SPACE]


# Reading


def test_a_mission_is_read_in_both_kinds_of_item(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    integer = gcs.only("MISSION_ITEM_INT", gcs.encode.mission_request_int_encode(1, 1, 1))
    floating = gcs.only("MISSION_ITEM", gcs.encode.mission_request_encode(1, 1, 1))
    assert floating.x == pytest.approx(integer.x * 1e-7, abs=1e-5)
    assert (floating.command, floating.z, floating.seq) == (integer.command, integer.z, 1)


def test_reading_is_possible_while_another_uploads(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    other(gcs).count(7)
    assert len(gcs.download()) == len(LINE)


def test_reading_is_possible_in_flight(on_mission: Aircraft) -> None:
    assert len(on_mission.client().download()) == len(LINE)


def test_beyond_the_end_is_an_invalid_sequence(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    for ask in (gcs.encode.mission_request_int_encode, gcs.encode.mission_request_encode):
        assert acks(gcs.ask(ask(1, 1, len(LINE)))) == [INVALID_SEQUENCE]


def test_the_last_ack_of_a_download_needs_no_answer(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    assert gcs.ask(gcs.encode.mission_ack_encode(1, 1, 0)) == []


def test_partial_reading_is_unsupported(gcs: Client) -> None:
    assert acks(gcs.ask(gcs.encode.mission_request_partial_list_encode(1, 1, 0, 1))) == [UNSUPPORTED]


def test_the_count_and_the_accepting_ack_carry_the_missions_id(gcs: Client) -> None:
    gcs.upload(LINE)
    ack = gcs.all("MISSION_ACK")[-1]
    count = gcs.only("MISSION_COUNT", gcs.encode.mission_request_list_encode(1, 1))
    assert ack.opaque_id == count.opaque_id == gcs.request(42).mission_id != 0

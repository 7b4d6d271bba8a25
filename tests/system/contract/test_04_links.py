"""Contract, section 4: several links at once; who hears what, and what is ignored."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import pytest

from system.contract.aircraft import ACCEPTED, NAN, A, Aircraft, B, C, Client, dialect
from system.contract.missions import LINE

# Who asked gets the answer, nobody else.

ASKS: dict[str, tuple[Callable[[Client], Any], str]] = {
    "COMMAND_ACK": (lambda c: c.encode.command_long_encode(1, 1, 400, 0, 0, 0, 0, 0, 0, 0, 0), "COMMAND_ACK"),
    "a requested message": (
        lambda c: c.encode.command_long_encode(1, 1, 512, 0, 148, 0, 0, 0, 0, 0, 0),
        "AUTOPILOT_VERSION",
    ),
    "MESSAGE_INTERVAL": (
        lambda c: c.encode.command_long_encode(1, 1, 510, 0, 30, 0, 0, 0, 0, 0, 0),
        "MESSAGE_INTERVAL",
    ),
    "PARAM_VALUE of a read": (
        lambda c: c.encode.param_request_read_encode(1, 1, b"MIS_TAKEOFF_ALT", -1),
        "PARAM_VALUE",
    ),
    "PARAM_VALUE of a list": (lambda c: c.encode.param_request_list_encode(1, 1), "PARAM_VALUE"),
    "PARAM_ERROR": (lambda c: c.encode.param_request_read_encode(1, 1, b"NO_SUCH", -1), "PARAM_ERROR"),
    "MISSION_COUNT": (lambda c: c.encode.mission_request_list_encode(1, 1), "MISSION_COUNT"),
    "MISSION_ITEM_INT": (lambda c: c.encode.mission_request_int_encode(1, 1, 0), "MISSION_ITEM_INT"),
    "MISSION_ITEM": (lambda c: c.encode.mission_request_encode(1, 1, 0), "MISSION_ITEM"),
    "MISSION_REQUEST_INT": (lambda c: c.encode.mission_count_encode(1, 1, 2), "MISSION_REQUEST_INT"),
    "MISSION_ACK": (lambda c: c.encode.mission_clear_all_encode(1, 1), "MISSION_ACK"),
    "TIMESYNC": (lambda c: c.encode.timesync_encode(0, 5), "TIMESYNC"),
    "PING": (lambda c: c.encode.ping_encode(7, 3, 0, 0), "PING"),
    "FILE_TRANSFER_PROTOCOL": (
        lambda c: c.encode.file_transfer_protocol_encode(0, 1, 1, [0] * 251),
        "FILE_TRANSFER_PROTOCOL",
    ),
}


@pytest.mark.parametrize("what", ASKS)
def test_an_answer_goes_to_who_asked_alone(grounded: Aircraft, what: str) -> None:
    asker = grounded.client(B, slot=1, system=254, component=77)
    others = [grounded.client(B, slot=0), grounded.client(B, slot=2), grounded.client(A), grounded.client(C)]
    assert others[0].upload(LINE) == 0
    since = [len(other.heard) for other in others]
    make, kind = ASKS[what]
    (answer, *_) = [m for m in asker.ask(make(asker)) if m.get_type() == kind]
    if hasattr(answer, "target_system"):
        assert (answer.target_system, answer.target_component) == (254, 77)
    for other, before in zip(others, since, strict=True):
        assert kind not in [m.get_type() for _, m in other.heard[before:]]


def test_streams_go_to_all(grounded: Aircraft) -> None:
    clients = [grounded.client(link, slot) for link in (A, B) for slot in (0, 3)]
    grounded.run(1.0)
    assert all(client.all("HEARTBEAT") for client in clients)


def after_a_text(c: Client) -> None:
    c.set_mode(4 << 16 | 4 << 24)


def after_a_parameter(c: Client) -> None:
    c.set_param("MIS_TAKEOFF_ALT", 4.0)


def after_a_home(c: Client) -> None:
    assert c.command(179, 0, 0, 0, 0, 47.398, 8.546, 490.0) == ACCEPTED


def after_an_origin(c: Client) -> None:
    assert c.command(611, 0, 0, 0, 0, 47.0, 8.0, 400.0) == ACCEPTED


def after_a_mission(c: Client) -> None:
    assert c.upload(LINE) == 0


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (after_a_text, "STATUSTEXT"),
        (after_a_parameter, "PARAM_VALUE"),
        (after_a_home, "HOME_POSITION"),
        (after_an_origin, "GPS_GLOBAL_ORIGIN"),
        (after_a_mission, "MISSION_CURRENT"),
    ],
)
def test_a_change_is_told_to_all(grounded: Aircraft, change: Callable[[Client], None], kind: str) -> None:
    changer = grounded.client(B)
    others = [grounded.client(A), grounded.client(B, slot=4)]
    change(changer)
    assert all(client.all(kind) for client in (changer, *others))


def test_mission_items_reached_are_told_to_all(on_mission: Aircraft) -> None:
    clients = [on_mission.client(A), on_mission.client(B)]
    on_mission.run(6.0)
    assert all(client.all("MISSION_ITEM_REACHED") for client in clients)


def test_each_link_counts_its_own_frames(grounded: Aircraft) -> None:
    clients = [grounded.client(A), grounded.client(B)]
    grounded.run(2.0)
    for client in clients:
        numbers = [m.get_seq() for _, m in client.heard]
        assert len(numbers) > 50
        assert all((after - before) % 256 == 1 for before, after in itertools.pairwise(numbers))


def test_each_client_is_parsed_by_itself(grounded: Aircraft) -> None:
    """Halves of frames of two clients arrive alternately."""
    one, two = grounded.client(B, 0), grounded.client(B, 1)
    frames = [c.pack(c.encode.command_long_encode(1, 1, 410, 0, 0, 0, 0, 0, 0, 0, 0)) for c in (one, two)]
    for half in (slice(0, 9), slice(9, None)):
        for client, frame in zip((one, two), frames, strict=True):
            client.ask(frame[half])
    assert [len(c.all("COMMAND_ACK")) for c in (one, two)] == [1, 1]


# What is not for us


@pytest.mark.parametrize("target", [(1, 1), (1, 0), (0, 0), (0, 1)])
def test_these_targets_are_ours(gcs: Client, target: tuple[int, int]) -> None:
    assert gcs.command(410, target=target) == ACCEPTED


@pytest.mark.parametrize("target", [(2, 1), (1, 2), (1, 191), (255, 190), (0, 100)])
def test_other_targets_are_ignored(gcs: Client, target: tuple[int, int]) -> None:
    assert gcs.ask(gcs.encode.command_long_encode(*target, 400, 0, 1, 0, 0, 0, 0, 0, 0)) == []
    assert not gcs.aircraft.autopilot.armed


def test_frames_of_our_own_address_are_ignored(grounded: Aircraft) -> None:
    echo = grounded.client(B, system=1, component=1)
    assert echo.ask(echo.encode.command_long_encode(1, 1, 410, 0, 0, 0, 0, 0, 0, 0, 0)) == []


def test_nothing_is_passed_on_between_links(grounded: Aircraft) -> None:
    talker, listener = grounded.client(A, system=7), grounded.client(B)
    talker.ask(talker.encode.statustext_encode(6, b"hello"))
    talker.ask(talker.encode.command_long_encode(9, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    assert listener.heard == []


def test_texts_of_our_ground_station_go_to_all(grounded: Aircraft) -> None:
    ground, listener = grounded.client(A, system=1, component=191), grounded.client(B)
    ground.ask(ground.encode.statustext_encode(6, b"Mission: plan ready"))
    assert listener.texts == ["Mission: plan ready"]


# Broken frames


def broken_checksum(frame: bytes) -> bytes:
    return frame[:-1] + bytes([frame[-1] ^ 1])


def unknown_id(frame: bytes) -> bytes:
    return frame[:7] + (0xFFFFF0).to_bytes(3, "little") + frame[10:]


def truncated(frame: bytes) -> bytes:
    return frame[:-3]


def empty(frame: bytes) -> bytes:
    header = bytearray(frame[:10])
    header[1] = 0
    crc = dialect.x25crc(bytes(header[1:]))
    crc.accumulate(bytes([dialect.MAVLink_command_long_message.crc_extra]))
    return bytes(header) + crc.crc.to_bytes(2, "little")


@pytest.mark.parametrize("breaks", [broken_checksum, unknown_id, truncated, empty])
def test_a_broken_frame_is_dropped_and_the_next_is_read(gcs: Client, breaks: Callable[[bytes], bytes]) -> None:
    frame = gcs.pack(gcs.encode.command_long_encode(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    assert gcs.ask(breaks(frame)) == []
    assert not gcs.aircraft.autopilot.armed
    for _ in range(2):  # a lost end is noticed when the next frame begins
        gcs.ask(gcs.encode.command_long_encode(1, 1, 410, 0, 0, 0, 0, 0, 0, 0, 0))
    assert gcs.all("COMMAND_ACK")


def test_trailing_zeros_left_out_are_restored(gcs: Client) -> None:
    frame = gcs.pack(gcs.encode.mission_request_list_encode(1, 0))
    assert frame[1] == 1  # target_component and mission_type are not sent
    assert gcs.ask(frame)[0].get_type() == "MISSION_COUNT"


def test_noise_between_frames_does_no_harm(gcs: Client) -> None:
    noise = bytes(range(256)) * 4
    gcs.ask(noise)
    for _ in range(8):
        gcs.ask(gcs.encode.command_long_encode(1, 1, 410, 0, 0, 0, 0, 0, 0, 0, 0))
    assert gcs.all("COMMAND_ACK")


@pytest.mark.parametrize("number", [224, 300, 511, 510, 512, 400, 176, 31010, 262])
@pytest.mark.parametrize("index", [NAN, float("inf"), -float("inf"), 1e20, -1e20, 2.0**31, 0.5], ids=str)
def test_a_float_is_judged_before_it_becomes_an_index(gcs: Client, number: int, index: float) -> None:
    assert gcs.upload(LINE) == 0
    open_means_current = number == 300 and math.isnan(index)
    assert (gcs.command(number, index, index) == ACCEPTED) == open_means_current


@pytest.mark.parametrize("seq", [5, 1000, 2000, 65535])
def test_an_index_of_the_wire_is_judged_before_it_is_used(gcs: Client, seq: int) -> None:
    assert gcs.upload(LINE) == 0
    assert gcs.ask(gcs.encode.mission_request_int_encode(1, 1, seq))[0].type == 13
    gcs.ask(gcs.encode.mission_set_current_encode(1, 1, seq))
    assert gcs.request(42).seq == 0


@pytest.mark.parametrize("index", [-2, -32768, 1000, 32767])
def test_an_index_of_a_parameter_is_judged_before_it_is_used(gcs: Client, index: int) -> None:
    (error,) = gcs.ask(gcs.encode.param_request_read_encode(1, 1, b"", index))
    assert (error.get_type(), error.error, error.param_index) == ("PARAM_ERROR", 1, index)

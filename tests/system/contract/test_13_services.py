"""Contract, section 13: time, versions, files, texts, and what is ignored."""

from __future__ import annotations

from typing import Any

import pytest

from system.contract.aircraft import ACCEPTED, DENIED, A, Aircraft, B, Client, dialect


def test_timesync_is_answered_with_what_was_asked(gcs: Client) -> None:
    answer = gcs.only("TIMESYNC", gcs.encode.timesync_encode(0, -123456789012345))
    assert answer.ts1 == -123456789012345


def test_timesync_never_says_0() -> None:
    client = Aircraft.new().client()
    assert client.only("TIMESYNC", client.encode.timesync_encode(0, 1)).tc1 == 1


def test_answers_to_timesync_are_not_answered(gcs: Client) -> None:
    assert gcs.ask(gcs.encode.timesync_encode(99, 1)) == []


def test_timesync_is_never_sent_unasked(grounded: Aircraft) -> None:
    clients = [grounded.client(A), grounded.client(B)]
    grounded.run(12.0)
    assert not any(client.all("TIMESYNC") for client in clients)


def test_a_ping_is_answered(grounded: Aircraft) -> None:
    client = grounded.client(B, 1, system=200, component=50)
    m = client.only("PING", client.encode.ping_encode(5, 17, 0, 0))
    assert (m.time_usec, m.seq, m.target_system, m.target_component) == (5, 17, 200, 50)


def test_an_answer_to_a_ping_is_not_answered(gcs: Client) -> None:
    assert gcs.ask(gcs.encode.ping_encode(5, 17, 1, 1)) == []


CAPABLE = {
    "MISSION_FLOAT": 1,
    "PARAM_FLOAT": 2,
    "MISSION_INT": 4,
    "COMMAND_INT": 8,
    "SET_ATTITUDE_TARGET": 64,
    "FLIGHT_TERMINATION": 2048,
    "MAVLINK2": 8192,
}
NOT_CAPABLE = {"FTP": 32, "MISSION_FENCE": 16384, "MISSION_RALLY": 32768}


@pytest.mark.parametrize("name", CAPABLE)
def test_the_version_says_that_it_can(gcs: Client, name: str) -> None:
    assert gcs.request(148).capabilities & CAPABLE[name]


@pytest.mark.parametrize("name", NOT_CAPABLE)
def test_the_version_says_that_it_cannot(gcs: Client, name: str) -> None:
    assert not gcs.request(148).capabilities & NOT_CAPABLE[name]


def test_the_version_is_2_or_later_and_no_official_build(gcs: Client) -> None:
    version = gcs.request(148).flight_sw_version
    assert version >> 24 >= 2
    assert version & 0xFF == 0


def test_the_unique_id_is_not_0(gcs: Client) -> None:
    assert gcs.request(148).uid != 0


def test_the_protocol_version_is_told_by_old_command_and_by_request_nowhere(gcs: Client) -> None:
    assert gcs.command(519, 1) == 3
    assert gcs.command(512, 300) == DENIED


@pytest.mark.parametrize("message_id", [397, 395])
def test_component_metadata_is_denied(gcs: Client, message_id: int) -> None:
    assert gcs.command(512, message_id) == DENIED


def ftp(client: Client, opcode: int, seq: int = 7, session: int = 3) -> list[int]:
    payload = [seq & 0xFF, seq >> 8, session, opcode, *[0] * 247]
    answer = client.only("FILE_TRANSFER_PROTOCOL", client.encode.file_transfer_protocol_encode(0, 1, 1, payload))
    return list(answer.payload)


@pytest.mark.parametrize(("opcode", "error"), [(4, 10), (3, 10), (5, 7), (6, 7), (0, 7), (15, 7), (99, 7)])
def test_a_file_request_is_refused(gcs: Client, opcode: int, error: int) -> None:
    payload = ftp(gcs, opcode)
    assert payload[0] | payload[1] << 8 == 8
    assert payload[2:6] == [3, 129, 1, opcode]
    assert payload[12] == error


@pytest.mark.parametrize("opcode", [1, 2])
def test_closing_sessions_is_accepted(gcs: Client, opcode: int) -> None:
    assert ftp(gcs, opcode)[3] == 128


def test_the_file_request_number_wraps(gcs: Client) -> None:
    assert ftp(gcs, 4, seq=65535)[:2] == [0, 0]


# Texts

PREFIXES = ("Arming denied: ", "Mission: ", "Offboard: ", "Failsafe: ", "Params: ", "Command: ", "Mode: ", "Battery ")


def test_texts_are_one_frame_of_at_most_50_characters_and_say_whose_they_are(gcs: Client, pilot: Client) -> None:
    for mode in range(256):
        gcs.command(176, 1, 4, mode)
        gcs.command(262, mode)
    for client in (gcs, pilot):
        for number in (20, 21, 22, 115, 185, 192, 193, 210, 224, 246, 300, 401, 31010, 611, 241):
            client.command(number, 1, 1)
            client.aircraft.run(0.2)
    texts = gcs.all("STATUSTEXT") + pilot.all("STATUSTEXT")
    assert len(texts) >= 8
    for m in texts:
        assert len(m.text) <= 50
        assert m.text.startswith(PREFIXES), m.text
        assert (m.id, m.chunk_seq) == (0, 0)


def test_the_same_text_comes_at_most_once_a_second(gcs: Client) -> None:
    for _ in range(25):
        gcs.command(20)
        gcs.aircraft.run(0.1)
    assert len(gcs.texts) == 3


def test_at_most_ten_texts_come_in_a_second(gcs: Client) -> None:
    for seq in range(40):
        gcs.ask(gcs.encode.mission_set_current_encode(1, 1, 100 + seq))
        gcs.aircraft.run(0.01)
    assert len(gcs.texts) == 10


def test_no_events_are_sent(gcs: Client) -> None:
    gcs.aircraft.run(3.0)
    assert not [m for _, m in gcs.heard if "EVENT" in m.get_type()]


def ignored(c: Client) -> dict[str, Any]:
    e = c.encode
    return {
        "RC_CHANNELS_OVERRIDE": e.rc_channels_override_encode(1, 1, *[2000] * 8),
        "MANUAL_CONTROL": e.manual_control_encode(1, 1000, 1000, 1000, 1000, 0),
        "REQUEST_DATA_STREAM": e.request_data_stream_encode(1, 1, 0, 50, 1),
        "PARAM_MAP_RC": e.param_map_rc_encode(1, 1, b"MIS_TAKEOFF_ALT", -1, 0, 1.0, 1.0, 0.0, 2.0),
        "LOG_REQUEST_LIST": e.log_request_list_encode(1, 1, 0, 65535),
        "GPS_INJECT_DATA": e.gps_inject_data_encode(1, 1, 10, [0] * 110),
        "HIL_SENSOR": e.hil_sensor_encode(0, *[1.0] * 13, 0),
    }


@pytest.mark.parametrize("name", list(ignored(Client(None, 0, 0, 255, 190))))  # type: ignore[arg-type]
def test_this_is_ignored_without_reply(pilot: Client, name: str) -> None:
    assert pilot.ask(ignored(pilot)[name]) == []
    pilot.aircraft.fly(0.5)
    assert pilot.aircraft.world.p_WB == pytest.approx([0, 0, 12.0], abs=0.1)


def test_a_signed_frame_is_read_where_signing_is_off(gcs: Client) -> None:
    signer = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
    signer.signing.secret_key = bytes(range(32))
    signer.signing.sign_outgoing = True
    signer.signing.timestamp = 1
    signed = gcs.encode.command_long_encode(1, 1, 410, 0, 0, 0, 0, 0, 0, 0, 0).pack(signer)
    assert signed[2] & 1
    assert gcs.ask(bytes(signed))[0].result == ACCEPTED


def test_setting_up_signing_is_ignored_where_signing_is_off(gcs: Client) -> None:
    assert gcs.ask(gcs.encode.setup_signing_encode(1, 1, list(range(32)), 5)) == []
    assert gcs.command(410) == ACCEPTED
    gcs.aircraft.run(0.5)
    assert not any(frame[2] & 1 for frame in gcs.frames)

"""MAVLink 2 signing, against pymavlink's own implementation of it."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mav

from system.gcs import Gcs
from system.processes import HALFROLL, Running, simulator

KEY = hashlib.sha256(b"correct horse battery staple").digest()
OTHER_KEY = hashlib.sha256(b"wrong").digest()
RUN_PREARM_CHECKS = 401
SINCE_2015_S = 1420070400


def sign_with(gcs: Gcs, key: bytes | None) -> None:
    signing = gcs._codec.signing
    signing.secret_key, signing.sign_outgoing, signing.link_id = key, key is not None, 3
    signing.timestamp = int((time.time() - SINCE_2015_S) * 1e5)
    signing.allow_unsigned_callback = lambda *_: True  # what we think of the autopilot's frames is checked by hand


def key_file(folder: Path, key: bytes = KEY) -> Path:
    file = folder / "key.txt"
    file.touch(0o600)
    file.write_text(key.hex() + "\n")
    return file


@contextmanager
def station(*options: object) -> Iterator[Gcs]:
    with simulator(*options) as (_, instance), Gcs(instance) as gcs:
        gcs.until(lambda m: m.get_type() == "HEARTBEAT")
        yield gcs


def answered(gcs: Gcs, seconds: float = 1.0) -> bool:
    """Whether a command that changes nothing is acknowledged."""
    frame = gcs._codec.command_long_encode(*gcs._target, RUN_PREARM_CHECKS, 0, *[0.0] * 7)
    gcs.send(frame)
    return acknowledged(gcs, seconds)


def acknowledged(gcs: Gcs, seconds: float = 1.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if any(m.get_type() == "COMMAND_ACK" for m in gcs.receive()):
            return True
    return False


def heartbeat(gcs: Gcs) -> Any:
    return gcs.until(lambda m: m.get_type() == "HEARTBEAT")


def is_signed_by(message: Any, key: bytes) -> bool:
    frame = bytes(message.get_msgbuf())
    signed = bool(frame[2] & mav.MAVLINK_IFLAG_SIGNED)
    return signed and hashlib.sha256(key + frame[:-6]).digest()[:6] == frame[-6:]


def refused(gcs: Gcs) -> int:
    """Frames that the autopilot did not trust, all links."""
    gcs.last.pop("SYS_STATUS", None)
    gcs.until(lambda m: m.get_type() == "SYS_STATUS")
    return int(gcs.until(lambda m: m.get_type() == "SYS_STATUS").errors_count1)


def test_a_link_that_requires_signatures_obeys_only_signed_frames(tmp_path: Path) -> None:
    with station("--signing", "require", "--signing-key", key_file(tmp_path)) as gcs:
        assert is_signed_by(heartbeat(gcs), KEY)  # telemetry is readable without a key
        before = refused(gcs)
        assert not answered(gcs)
        sign_with(gcs, OTHER_KEY)
        assert not answered(gcs)
        assert refused(gcs) == before + 2
        sign_with(gcs, KEY)
        assert answered(gcs)


def test_a_frame_that_is_sent_twice_counts_once(tmp_path: Path) -> None:
    with station("--signing", "require", "--signing-key", key_file(tmp_path)) as gcs:
        sign_with(gcs, KEY)
        frame = gcs._codec.command_long_encode(*gcs._target, RUN_PREARM_CHECKS, 0, *[0.0] * 7).pack(gcs._codec)
        gcs._socket.sendto(frame, gcs._peer)
        assert acknowledged(gcs)
        gcs._socket.sendto(frame, gcs._peer)
        assert not acknowledged(gcs)


def test_an_old_recording_is_refused_even_after_a_restart(tmp_path: Path) -> None:
    options = ("--signing", "require", "--signing-key", key_file(tmp_path), "--storage", tmp_path / "store")
    with station(*options) as gcs:
        sign_with(gcs, KEY)
        gcs._codec.signing.timestamp += 20 * 60 * 100000  # this station's clock is ahead
        assert answered(gcs)
        time.sleep(0.5)
    with station(*options) as gcs:
        sign_with(gcs, KEY)  # now the time of day again: twenty minutes before what was heard last
        assert not answered(gcs)


def test_radio_status_needs_no_signature(tmp_path: Path) -> None:
    with station("--signing", "require", "--signing-key", key_file(tmp_path)) as gcs:
        before = refused(gcs)
        gcs.send(gcs._codec.radio_status_encode(1, 2, 3, 4, 5, 6, 7))
        assert refused(gcs) == before


def test_a_link_that_accepts_takes_unsigned_frames_but_no_forged_ones(tmp_path: Path) -> None:
    with station("--signing", "off,accept", "--signing-key", key_file(tmp_path)) as gcs:
        assert is_signed_by(heartbeat(gcs), KEY)
        assert answered(gcs)
        sign_with(gcs, OTHER_KEY)
        assert not answered(gcs)
        sign_with(gcs, KEY)
        assert answered(gcs)


def test_without_signing_a_signature_is_passed_over() -> None:
    with station() as gcs:
        sign_with(gcs, OTHER_KEY)
        assert answered(gcs)
        gcs.send(gcs._codec.setup_signing_encode(*gcs._target, list(KEY), 0))
        sign_with(gcs, None)
        assert answered(gcs)
        assert not is_signed_by(heartbeat(gcs), KEY)


def test_a_trusted_link_sets_the_key_and_it_is_kept(tmp_path: Path) -> None:
    options = ("--signing", "off,trusted", "--storage", tmp_path / "store")
    with station(*options) as gcs:
        assert not is_signed_by(heartbeat(gcs), KEY)
        gcs.send(gcs._codec.setup_signing_encode(*gcs._target, list(KEY), 0))
        gcs.until(lambda m: m.get_type() == "STATUSTEXT" and m.text == "Command: signing key changed")
        gcs.until(lambda m: is_signed_by(m, KEY))
        time.sleep(0.5)
    with station(*options) as gcs:
        assert is_signed_by(heartbeat(gcs), KEY)


def test_an_armed_vehicle_keeps_its_key(tmp_path: Path) -> None:
    with station("--signing", "off,trusted", "--signing-key", key_file(tmp_path)) as gcs:
        gcs.arm()
        gcs.send(gcs._codec.setup_signing_encode(*gcs._target, list(OTHER_KEY), 0))
        gcs.until(lambda m: m.get_type() == "STATUSTEXT" and m.text == "Command: armed, signing key kept")
        assert is_signed_by(heartbeat(gcs), KEY)


def test_who_is_not_heard_is_told_why(tmp_path: Path) -> None:
    with station("--signing", "require", "--signing-key", key_file(tmp_path)) as gcs:
        sign_with(gcs, OTHER_KEY)
        assert not answered(gcs)
        assert "Signing: frames without a valid signature refused" in gcs.texts


def test_a_whole_recorded_session_does_nothing_when_it_is_played_again(tmp_path: Path) -> None:
    with station("--signing", "require", "--signing-key", key_file(tmp_path)) as gcs:
        sign_with(gcs, KEY)
        session = [
            gcs._codec.command_long_encode(*gcs._target, RUN_PREARM_CHECKS, 0, *[0.0] * 7).pack(gcs._codec)
            for _ in range(20)
        ]
        for frame in session:
            gcs._socket.sendto(frame, gcs._peer)
            assert acknowledged(gcs)
        before = refused(gcs)
        for frame in (*session, *reversed(session)):
            gcs._socket.sendto(frame, gcs._peer)
        assert not acknowledged(gcs)
        assert refused(gcs) == before + 2 * len(session)


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660, 0o777])
def test_a_key_that_others_may_use_is_no_key(tmp_path: Path, mode: int) -> None:
    file = key_file(tmp_path)
    file.chmod(mode)
    ended = Running(HALFROLL, "sitl", "--signing", "require", "--signing-key", file).wait()
    assert ended.code == 2
    assert f"chmod 600 {file}" in ended.err


def test_a_stored_key_is_its_owners_alone(tmp_path: Path) -> None:
    store = tmp_path / "store"
    store.mkdir()
    for region in "01":
        (store / f"signing.{region}.bin").touch(0o644)
    with station("--signing", "require", "--signing-key", key_file(tmp_path), "--storage", store) as gcs:
        refused(gcs)
    kept = list(store.glob("signing.*"))
    assert len(kept) == 2
    assert {file.stat().st_mode & 0o777 for file in kept} == {0o600}


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--signing", "require"), "needs a key"),
        (("--signing", "maybe"), "write off, require, accept or trusted"),
        (("--signing-key", "/nonexistent/key"), "cannot be read"),
    ],
)
def test_a_wrong_option_is_told(options: tuple[str, ...], complaint: str) -> None:
    ended = Running(HALFROLL, "sitl", *options).wait()
    assert ended.code == 2
    assert complaint in ended.err

"""Where fuzzing begins: what clients said in the tests of the contract, as a pytest plugin, and a few written by hand.

PYTHONPATH=tests pytest -p fuzz.seeds --seeds FOLDER tests/system/contract
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest

SITUATIONS = {"hovering": 1, "pilot": 1, "on_mission": 2}  # fixture: first byte of a byte stream; on the ground is 0
SIGNED, WELL_SIGNED = 3, 0x50  # the situation behind signing links; a good signature with a new time stamp
SETPOINTS = (82, 84, 86, 331, 138, 102, 11, 76)  # as in offboard_flight.cpp
_HEADER, _LONGEST = 10, 4000


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--seeds", type=Path, required=True, help="folder to write what clients say to")


def pytest_collection_finish(session: pytest.Session) -> None:
    written_by_hand(session.config.getoption("--seeds"))


def write(folder: Path, data: bytes) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / hashlib.sha1(data).hexdigest()).write_bytes(data)


def with_orders(frame: bytes, wait_ms: int, where: int) -> bytes:
    """When it comes and from where, in the bytes in which byte_stream.cpp reads that; its checksum follows."""
    from system.contract.aircraft import dialect

    body = bytes([frame[1], 0, wait_ms, where, *frame[5 : _HEADER + frame[1]]])
    known = dialect.mavlink_map.get(int.from_bytes(frame[7:10], "little"))
    crc = dialect.x25crc(body + bytes([known.crc_extra])).crc if known else 0
    return b"\xfd" + body + struct.pack("<H", crc)


@pytest.fixture(autouse=True)
def _overheard(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    from system.contract.aircraft import Aircraft, dialect

    said: list[tuple[int, int, bytes]] = []  # [ms], link, bytes
    serve, step = Aircraft.serve, Aircraft.step

    def serve_aloud(self: Aircraft, rx: bytes = b"", link: int = 1, slot: int = 0) -> None:
        said.append((self.t_ms, link, rx))
        serve(self, rx, link, slot)

    def step_aloud(self: Aircraft, rx: bytes = b"", link: int = 1, slot: int = 0, pose: bool = True) -> None:
        if rx:
            said.append((self.t_ms, link, rx))
        step(self, rx, link, slot, pose)

    monkeypatch.setattr(Aircraft, "serve", serve_aloud)
    monkeypatch.setattr(Aircraft, "step", step_aloud)
    yield
    folder: Path = request.config.getoption("--seeds")
    situation = max((SITUATIONS.get(name, 0) for name in request.fixturenames), default=0)
    stream, signed, setpoints, last_ms = bytes([situation]), b"", b"", said[0][0] if said else 0
    for t_ms, link, rx in said:
        if len(rx) < _HEADER + 2 or rx[0] != 0xFD or rx[2] != 0 or len(rx) != _HEADER + 2 + rx[1]:
            piece, number = rx, -1
        else:
            wait_ms = min(max(t_ms - last_ms, 0), 255)
            number = int.from_bytes(rx[7:10], "little")
            piece = with_orders(rx, wait_ms, link)
        if number in SETPOINTS and len(setpoints) < _LONGEST:
            size = struct.calcsize(dialect.mavlink_map[number].unpacker.format)
            payload = rx[_HEADER : _HEADER + rx[1]]
            setpoints += bytes([SETPOINTS.index(number), min(t_ms - last_ms, 63) % 64, 128]) + payload.ljust(
                size, b"\0"
            )
        if len(stream) + len(piece) > _LONGEST:
            break
        stream += piece
        signed += piece if number < 0 else with_orders(rx, wait_ms, link | WELL_SIGNED)
        last_ms = t_ms
    if len(stream) > 1:
        write(folder / "byte_stream", stream)
        write(folder / "byte_stream", bytes([SIGNED]) + signed)
    if setpoints:
        write(folder / "offboard_flight", setpoints)


def written_by_hand(folder: Path) -> None:
    """For the targets whose input is not what a client says."""
    talk = folder / "mission_talk"
    for other in (0, 0x80):
        upload = bytes([5 | other, 3, *[0 | other, 0, 1] * 3, 14, 9])
        write(talk, upload + bytes([8 | other, 0, 9 | other, 0, 9 | other, 2]))
        write(talk, upload + bytes([10 | other, 9, 9, 0 | other, 0, 7, 14, 40, 7 | other, 0, 14, 9]))
        write(
            talk, bytes([5 | other, 3, 0 | other, 0, 1, 5 | (other ^ 0x80), 2, 14, 30, 11 | other, 1, 14, 255, 14, 255])
        )
        write(talk, bytes([76]) + upload + bytes([12, 14, 255, 14, 255, 14, 200]))
        write(talk, bytes([6 | other, 6, *[0 | other, 0, 1] * 96, 14, 9, 13 | other, 40]))
    flown = folder / "mission_flight"
    square = [(0, 0, 128 + 40 * (n % 2), 128 + 40 * (n // 2), 60) for n in range(4)]
    rest = [bytes([12, 250]) * 6, bytes([12, 60, 1, 0, 12, 60, 1, 1, 12, 250, 12, 250]), bytes([12, 99, 2, 2, 12, 200])]
    for kind in range(24):  # each kind of item between waypoints
        items = [*square[:2], (kind, 20, 130, 120, 40), *square[2:], (7, 0, 128, 128, 0)]
        write(flown, bytes([len(items), *(byte for item in items for byte in item)]) + rest[kind % 3])
    store = folder / "stored_images"
    values = [("ATT_WN", 14.0), ("MIS_TAKEOFF_ALT", 3.0), ("NO_SUCH", 1.0), ("COM_OBL_RC_ACT", float("nan"))]
    record = b"".join(name.encode().ljust(16, b"\0") + struct.pack("<f", value) for name, value in values)
    item = struct.pack("<4f2ifHBB", 0.0, 0.0, 0.0, 0.0, 473977420, 85455940, 10.0, 16, 3, 1)
    for sealed in (0, 128):
        write(store, bytes([sealed]) + bytes(range(200)))
        write(store, bytes([sealed | 1]) + bytes(12) + record)
        write(store, bytes([sealed | 2]) + bytes(12) + item * 3)
        write(store, bytes([sealed | 3]) + bytes(48))

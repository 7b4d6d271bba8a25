"""What only the ground knows of a flight, appended to the log that the simulator writes.

Why: a log is whole by itself: what was asked, the plan, the reference as it was flown, how it ended. Each addition is
appended in one piece while the simulator appends its own, so what a killed process leaves can be read all the same.
"""

from __future__ import annotations

import contextlib
import json
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfroll.errors import HalfrollError
from halfroll.station.record import Event
from halfroll.wire.frames import to_wire

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan
    from halfroll.station.record import Record

EMBEDDED_PIECE = 15_000  # characters, of at most four bytes: a message of ULog has at most 65535
_SEVERITY = {"left": 4, "plan-failed": 4, "late": 4, "released": 5}  # as in syslog; others inform
_TOLD = ("mission", "planned", "plan-failed", "late", "approach", "flying", "left", "handed-back", "released")
_REFERENCE_HZ = 100.0
_GROUND = "ground: "
_BLOCK = 1000  # samples that are evaluated at once
_HEADER = 16  # bytes
# The simulator's log says what these hold; it numbers its own topics from 0.
_TRAJECTORY, _POSITION_SETPOINT = (60001, "trajectory_reference"), (60002, "vehicle_local_position_setpoint")

_DATA = [("size", "<u2"), ("kind", "S1"), ("topic", "<u2"), ("t_us", "<u8")]  # how a message of a topic begins
_SAMPLE = np.dtype([("ours", [*_DATA, ("x", "<f4", 15)]), ("px4", [*_DATA, ("x", "<f4", 10)])])


class FlightRecorder:
    """embedded: texts to keep in the log, by name. It hears every event of the flight, then how it ended."""

    def __init__(self, log: Path, embedded: Mapping[str, str]) -> None:
        self._log, self._embedded = log, embedded
        self._file: int | None = None
        self._plan: Plan | None = None
        self._start_s: float | None = None
        self._written = 0  # samples of the plan
        self._ahead = np.empty(0, dtype=_SAMPLE)  # the block of them that is being written

    @property
    def begun(self) -> bool:
        """Whether there is a log to append to."""
        return self._file is not None

    def hear(self, event: Event) -> None:
        """Also begins: the simulator has made its log before anything is heard of it."""
        if self._file is None:
            self._begin()
        if event.planned is not None:
            self._plan, self._start_s = event.planned.plan, None
            self._embed("plan", self._plan.as_json())
        if event.kind in _TOLD:
            self._say(event)
        if event.kind == "flying":
            self._start_s, self._written = event.t_s, 0
            self._append(_typed(b"I", "double plan_start_s", struct.pack("<d", event.t_s)))
        self._add_reference(event.t_s)
        if event.kind in ("left", "handed-back", "released"):
            self._start_s = None

    def end(self, record: Record | None, error: HalfrollError | None, facts: Mapping[str, Any]) -> None:
        """How it ended: `error` is the reason why it did before its time."""
        if self._file is None:
            return
        if record is not None and record.plan_start_s is not None:
            self._append(_typed(b"I", "double plan_start_s", struct.pack("<d", record.plan_start_s)))
        links = {} if record is None else record.as_json()
        why = {} if error is None else {"error": {"kind": error.kind, "message": str(error), "item": error.item}}
        self._embed("outcome", json.dumps({**links, **facts, **why}))
        os.close(self._file)
        self._file = None

    def _begin(self) -> None:
        with contextlib.suppress(OSError):  # without a log nothing is recorded; who asked for it hears so elsewhere
            self._file = os.open(self._log, os.O_WRONLY | os.O_APPEND)
            for key, text in self._embedded.items():
                self._embed(key, text)
            for number, name in (_TRAJECTORY, _POSITION_SETPOINT):
                self._append(_message(b"A", struct.pack("<BH", 0, number) + name.encode()))

    def _add_reference(self, t_s: float) -> None:
        """The plan's samples up to now."""
        if self._plan is None or self._start_s is None:
            return
        end_s = min(t_s - self._start_s, self._plan.T)
        count = int(end_s * _REFERENCE_HZ + 1e-6) + 1
        while self._written < count:
            block, at = divmod(self._written, _BLOCK)
            if at == 0:
                self._ahead = _samples(self._plan, self._start_s, block * _BLOCK)
            ready = self._ahead[at : count - block * _BLOCK]
            self._append(ready.tobytes())
            self._written += len(ready)

    def _say(self, event: Event) -> None:
        severity = ord("0") + _SEVERITY.get(event.kind, 6)
        line = f"{_GROUND}{event.text}".encode()
        self._append(_message(b"L", struct.pack("<BQ", severity, round(event.t_s * 1e6)) + line))

    def _embed(self, key: str, text: str) -> None:
        """A text of any length, in pieces."""
        pieces = [text[i : i + EMBEDDED_PIECE].encode() for i in range(0, len(text), EMBEDDED_PIECE)] or [b""]
        self._append(
            b"".join(
                _typed(b"M", f"char[{len(piece)}] {key}", piece, struct.pack("<B", i > 0))
                for i, piece in enumerate(pieces)
            )
        )

    def _append(self, messages: bytes) -> None:
        if self._file is not None:
            with contextlib.suppress(OSError):  # the disk is full: the simulator says so
                os.write(self._file, messages)


def _samples(plan: Plan, start_s: float, first: int) -> NDArray[np.void]:
    """A block of the plan's samples as the messages of a log, from the one of this number on."""
    t = np.arange(first, min(first + _BLOCK, int(plan.T * _REFERENCE_HZ + 1e-6) + 1)) / _REFERENCE_HZ
    d = plan.trajectory.derivatives(t)
    p, v, a, yaw = d[:, 0, :3], d[:, 1, :3], d[:, 2, :3], d[:, 0, 3:]
    ours = (t[:, None], p, v, a, yaw, plan.outputs(t).rotors)
    px4 = (to_wire(p), -yaw, to_wire(v), to_wire(a))
    samples = np.empty(len(t), dtype=_SAMPLE)
    for part, (topic, _), columns in (("ours", _TRAJECTORY, ours), ("px4", _POSITION_SETPOINT, px4)):
        message = samples[part]
        message["size"], message["kind"], message["topic"] = message.dtype.itemsize - 3, b"D", topic
        message["t_us"] = np.rint((start_s + t) * 1e6)
        message["x"] = np.hstack(columns)
    return samples


def copy_of_the_grounds(log: Path, new_log: Path) -> None:
    """Appends to the log of a flight that was flown again what the ground had appended to the first. Raises OSError."""
    whole, at, kept = log.read_bytes(), _HEADER, []
    while at + 3 <= len(whole):
        size, kind = struct.unpack_from("<HB", whole, at)
        body = whole[at + 3 : at + 3 + size]
        if len(body) < size:
            break
        if _is_the_grounds(chr(kind), body):
            kept.append(whole[at : at + 3 + size])
        at += 3 + size
    with new_log.open("ab") as file:
        file.write(b"".join(kept))


def _is_the_grounds(kind: str, body: bytes) -> bool:
    if kind == "L":
        return body[9:].startswith(_GROUND.encode())
    if kind == "A":
        return int.from_bytes(body[1:3], "little") >= _TRAJECTORY[0]
    if kind == "D":
        return int.from_bytes(body[:2], "little") >= _TRAJECTORY[0]
    return kind == "M" or (kind == "I" and b" plan_start_s" in body[:32])


def _message(kind: bytes, body: bytes) -> bytes:
    return struct.pack("<H", len(body)) + kind + body


def _typed(kind: bytes, type_and_key: str, value: bytes, before: bytes = b"") -> bytes:
    return _message(kind, before + struct.pack("<B", len(type_and_key)) + type_and_key.encode() + value)

"""A link's bytes kept as they went by: MAVProxy's .tlog.

Why: what was said on the wire can be read, and played, by any MAVLink tool.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from pathlib import Path

from halfroll.wire.cutting import frames
from halfroll.wire.transport import Transport

_LONGEST = 64 * 1024  # bytes that wait to be written


class RecordedTransport:
    """Passes on to another transport, and writes each frame of both directions, behind its time, into a file.

    time_us: vehicle time, which the stamps count from now, whatever the wall's pace: a flight that flew faster than
    real time plays at its own. Raises OSError where there can be no file.
    """

    def __init__(self, transport: Transport, path: Path) -> None:
        self._transport = transport
        self._file = path.open("wb", buffering=_LONGEST)
        self._begun_us = time.time_ns() // 1000
        self._flushed_us = 0
        self.time_us: Callable[[], int] = lambda: 0

    def send(self, datagram: bytes) -> None:
        self._write(datagram)
        self._transport.send(datagram)

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        datagrams = self._transport.receive(timeout_s)
        for datagram in datagrams:
            self._write(datagram)
        return datagrams

    def close(self) -> None:
        self._file.close()

    def _write(self, datagram: bytes) -> None:
        t_us = self.time_us()
        stamp = struct.pack(">Q", self._begun_us + t_us)
        self._file.write(b"".join(stamp + frame for frame in frames(datagram)))
        if t_us - self._flushed_us > 100_000:
            self._flushed_us = t_us
            self._file.flush()

"""Between autopilot and ground station: passes every datagram on, and keeps what went by. Why: what is seen on the wire
is the wire's own account, not the ground station's.
"""

from __future__ import annotations

import importlib
import select
import socket
import threading
from typing import Any

dialect: Any = importlib.import_module("halfroll._dialect")


class Wire:
    """The simulator's peer is `port`, the ground station's is us."""

    def __init__(self, simulator_port: int, ground_port: int) -> None:
        self._near, self._far = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        for each in (self._near, self._far):
            each.bind(("127.0.0.1", 0))
        self._simulator, self._ground = ("127.0.0.1", simulator_port), ("127.0.0.1", ground_port)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._up, self._down = bytearray(), bytearray()

    @property
    def port(self) -> int:
        return int(self._near.getsockname()[1])

    def __enter__(self) -> Wire:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self._near.close()
        self._far.close()

    def _carry(self) -> None:
        ways = {self._near: (self._far, self._ground, self._down), self._far: (self._near, self._simulator, self._up)}
        while not self._ended.is_set():
            for here in select.select(list(ways), [], [], 0.1)[0]:
                there, peer, kept = ways[here]
                try:
                    datagram = here.recv(65535)
                except ConnectionRefusedError:  # an earlier datagram met a closed port
                    continue
                kept += datagram
                there.sendto(datagram, peer)

    def from_ground(self, kind: str) -> list[Any]:
        return _messages(self._up, kind)

    def from_autopilot(self, kind: str) -> list[Any]:
        return _messages(self._down, kind)


def _messages(stream: bytearray, kind: str) -> list[Any]:
    codec = dialect.MAVLink(None)
    codec.robust_parsing = True
    return [message for message in codec.parse_buffer(bytes(stream)) or () if message.get_type() == kind]

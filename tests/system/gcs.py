"""A ground control station in as few lines as the protocol allows. Why: an opinion on the wire that shares no line with
halfroll's own link; plain pymavlink on a plain socket.
"""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Callable, Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mav

ACCEPTED = 0
DEADLINE_S = 120.0
AGAIN_S = 0.5

Item = tuple[int, int, int, tuple[float, float, float, float], int, int, float]  # frame, command, autocontinue, ...


def bits(item: Item) -> tuple[Any, ...]:
    """Comparable in every bit, NaN included."""
    frame, command, autocontinue, params, x, y, z = item
    return frame, command, autocontinue, struct.pack("<5f", *params, z), x, y


class Gcs:
    """On the link of ground control stations, or between other ports."""

    def __init__(self, instance: int, ours: int = 14550, theirs: int = 18570) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", ours + instance))
        self._socket.settimeout(0.05)
        self._codec = mav.MAVLink(None, srcSystem=255, srcComponent=190)
        self._codec.robust_parsing = True
        self._peer = ("127.0.0.1", theirs + instance)
        self._target = (1 + instance, 1)
        self.texts: list[str] = []
        self.last: dict[str, Any] = {}  # the latest message of each kind

    def __enter__(self) -> Gcs:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def send(self, frame: Any) -> None:
        self._socket.sendto(frame.pack(self._codec), self._peer)
        self._codec.seq = (self._codec.seq + 1) % 256

    def heartbeat(self) -> Any:
        return self._codec.heartbeat_encode(mav.MAV_TYPE_GCS, mav.MAV_AUTOPILOT_INVALID, 0, 0, 0)

    def receive(self) -> list[Any]:
        try:
            datagram = self._socket.recv(65535)
        except TimeoutError:
            return []
        messages = self._codec.parse_buffer(datagram) or []
        for message in messages:
            self.last[message.get_type()] = message
            if message.get_type() == "STATUSTEXT":
                self.texts.append(message.text)
        return messages

    def until(self, accepts: Callable[[Any], bool], ask: Any = None) -> Any:
        """The first message accepted; ask is sent, and sent again."""
        began, asked = time.monotonic(), -AGAIN_S
        while time.monotonic() - began < DEADLINE_S:
            if ask is not None and time.monotonic() - asked > AGAIN_S:
                asked = time.monotonic()
                self.send(ask)
            for message in self.receive():
                if accepts(message):
                    return message
        raise AssertionError(f"no answer to {ask}; last heard {self.last}, {self.texts}")

    def command(self, number: int, *params: float) -> int:
        filled = (*params, *[0.0] * (7 - len(params)))
        ask = self._codec.command_long_encode(*self._target, number, 0, *filled)
        return int(self.until(lambda m: m.get_type() == "COMMAND_ACK" and m.command == number, ask).result)

    def upload(self, items: Sequence[Item]) -> int:
        """The MISSION_ACK's type."""
        ask = self._codec.mission_count_encode(*self._target, len(items))
        while True:
            answer = self.until(lambda m: m.get_type() in ("MISSION_REQUEST_INT", "MISSION_ACK"), ask)
            if answer.get_type() == "MISSION_ACK":
                return int(answer.type)
            frame, command, autocontinue, params, x, y, z = items[answer.seq]
            fields = (answer.seq, frame, command, int(answer.seq == 0), autocontinue, *params, x, y, z)
            ask = self._codec.mission_item_int_encode(*self._target, *fields)

    def download(self) -> list[Item]:
        ask = self._codec.mission_request_list_encode(*self._target)
        count = self.until(lambda m: m.get_type() == "MISSION_COUNT", ask).count
        return [self._item(seq) for seq in range(count)]

    def _item(self, seq: int) -> Item:
        ask = self._codec.mission_request_int_encode(*self._target, seq)
        m = self.until(lambda m: m.get_type() == "MISSION_ITEM_INT" and m.seq == seq, ask)
        return m.frame, m.command, m.autocontinue, (m.param1, m.param2, m.param3, m.param4), m.x, m.y, m.z

    def mission_current(self) -> Any:
        return self.until(lambda m: m.get_type() == "MISSION_CURRENT")

    def arm(self) -> None:
        """Again and again: a simulator just started may not know yet where it is."""
        while self.command(400, 1) != ACCEPTED:
            self.until(lambda m: m.get_type() == "HEARTBEAT")

    def until_landed(self) -> None:
        for wanted in (True, False):
            self.until(lambda m, w=wanted: m.get_type() == "HEARTBEAT" and bool(m.base_mode & 128) == w)

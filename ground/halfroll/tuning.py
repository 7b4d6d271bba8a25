"""Parameters of a running autopilot, to a file and back.

Why: beside any ground control station: this asks from a port of its own, so nobody has to hang up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from halfroll import _firmware
from halfroll.errors import LinkError
from halfroll.wire.conversations import Conversation, Talk, read_param, write_param
from halfroll.wire.link import Link
from halfroll.wire.messages import GCS, GCS_SYSTEM
from halfroll.wire.transport import LOOPBACK, UdpTransport

GCS_PORT = 18570  # where halfroll-sitl listens for ground control stations
_LISTEN_S = 0.05
_READ_ONLY = 4

T = TypeVar("T")


@dataclass(frozen=True)
class Imported:
    """What became of a file's values, by name."""

    changed: tuple[str, ...]
    unknown: tuple[str, ...]  # the autopilot has no such parameter
    refused: tuple[str, ...]  # out of range, or locked while armed
    read_only: tuple[str, ...]


def export_params(instance: int = 0) -> dict[str, float]:
    """All parameters. Raises LinkError if nobody answers."""

    def all_of_them(link: Link) -> Conversation[dict[str, float]]:
        values = {}
        for info in _firmware.parameter_table():
            values[info.id] = yield from read_param(link, info.id)
        return values

    return _talk(instance, all_of_them)


def import_params(values: Mapping[str, float], instance: int = 0) -> Imported:
    """Set what differs. One value that is refused does not keep out the others. Raises LinkError if nobody answers."""
    known = {info.id: info for info in _firmware.parameter_table()}
    read_only = tuple(name for name in values if name in known and known[name].flags & _READ_ONLY)
    wanted = {name: value for name, value in values.items() if name in known and name not in read_only}

    def those(link: Link) -> Conversation[tuple[list[str], list[str]]]:
        changed, refused = [], []
        for name, value in wanted.items():
            if (yield from read_param(link, name)) == np.float32(value):
                continue
            try:
                yield from write_param(link, name, value)
            except LinkError:
                refused.append(name)
            else:
                changed.append(name)
        return changed, refused

    changed, refused = _talk(instance, those)
    unknown = tuple(name for name in values if name not in known)
    return Imported(tuple(changed), unknown, tuple(refused), read_only)


def _talk(instance: int, conversation: Callable[[Link], Conversation[T]]) -> T:
    transport = UdpTransport.bind(0, (LOOPBACK, GCS_PORT + instance))
    try:
        link = Link(transport, GCS, GCS_SYSTEM)
        link.vehicle_system = 1 + instance  # it does not know us before it has heard us
        link.send(link.heartbeat())
        talk = Talk(link, conversation(link))
        while not talk.done:
            for message in link.receive(_LISTEN_S):
                talk.hear(message)
            talk.go_on()
        assert talk.result is not None
        return talk.result
    finally:
        transport.close()

"""A link that loses, delays and reorders datagrams, in vehicle time and by a seed.

Why: what a radio does to a transfer must be the same in each run, and its duration a matter of the protocol alone.
"""

from __future__ import annotations

import heapq
import random
from collections.abc import Callable, Sequence
from typing import Any

from system.contract.aircraft import Aircraft, Client, Item

AGAIN_MS = 1500  # when clients repeat themselves
GIVES_UP_AFTER = 5  # repetitions


class LossyLink:
    """One client's datagrams, both ways."""

    def __init__(self, client: Client, seed: int, loss: float, delay_ms: tuple[int, int]) -> None:
        self._client, self._random, self._loss, self._delay_ms = client, random.Random(seed), loss, delay_ms
        self._up: list[tuple[int, int, bytes]] = []
        self._down: list[tuple[int, int, Any]] = []
        self._number = self._heard = 0

    def send(self, message: Any) -> None:
        self._post(self._up, self._client.pack(message))

    def _post(self, queue: list[Any], what: Any) -> None:
        self._number += 1
        if self._random.random() >= self._loss:
            due = self._client.aircraft.t_ms + self._random.randint(*self._delay_ms)
            heapq.heappush(queue, (due, self._number, what))  # a later one may come sooner

    def step(self) -> list[Any]:
        """One millisecond; what reached the client in it."""
        aircraft = self._client.aircraft
        rx = b"".join(self._due(self._up))
        aircraft.step(rx, self._client.link, self._client.slot)
        for _, message in self._client.heard[self._heard :]:
            self._post(self._down, message)
        self._heard = len(self._client.heard)
        return self._due(self._down)

    def _due(self, queue: list[Any]) -> list[Any]:
        arrived = []
        while queue and queue[0][0] <= self._client.aircraft.t_ms:
            arrived.append(heapq.heappop(queue)[2])
        return arrived


class Upload:
    """How QGroundControl uploads: answers requests, repeats the count, and ends at a MISSION_ACK."""

    def __init__(self, client: Client, items: Sequence[Item], send: Callable[[Any], None]) -> None:
        self._client, self._items, self._send = client, items, send
        self.result: int | None = None
        self._repeated, self._moved_ms = 0, client.aircraft.t_ms
        self._count()

    def _count(self) -> None:
        self._send(self._client.encode.mission_count_encode(1, 1, len(self._items)))

    def hear(self, message: Any) -> None:
        if message.get_type() == "MISSION_ACK" and self.result is None:
            self.result = int(message.type)
        if message.get_type() == "MISSION_REQUEST_INT" and self.result is None:
            self._moved_ms, self._repeated = self._client.aircraft.t_ms, GIVES_UP_AFTER
            frame, command, autocontinue, params, x, y, z = self._items[message.seq]
            fields = (message.seq, frame, command, 0, autocontinue, *params, x, y, z)
            self._send(self._client.encode.mission_item_int_encode(1, 1, *fields))

    def tick(self) -> None:
        """Every millisecond: the count is repeated until the first request."""
        if self._repeated < GIVES_UP_AFTER and self._client.aircraft.t_ms - self._moved_ms >= AGAIN_MS:
            self._repeated += 1
            self._moved_ms = self._client.aircraft.t_ms
            self._count()


def upload_over(aircraft: Aircraft, items: Sequence[Item], seed: int, loss: float, delay_ms: tuple[int, int]) -> float:
    """Seconds of vehicle time from the first count to the moment when the vehicle has the mission."""
    client = aircraft.client()
    link = LossyLink(client, seed, loss, delay_ms)
    began = aircraft.t_ms
    upload = Upload(client, items, link.send)
    while not client.all("MISSION_ACK"):
        assert aircraft.t_ms - began < 60_000, "a minute and still no mission"
        for message in link.step():
            upload.hear(message)
        upload.tick()
    assert [m.type for m in client.all("MISSION_ACK")] == [0]
    return (aircraft.t_ms - began) / 1000

"""What a bad radio does to datagrams: loses, delays, reorders, repeats, spoils and throttles them, by a seed.

Why: what goes wrong on a link must go wrong the same way in each run. The fate of a datagram is a function of the seed
and of its number alone; the clock is the caller's, vehicle time in one process and the wall's between two sockets.
"""

from __future__ import annotations

import heapq
import math
import random
from collections import Counter
from dataclasses import dataclass

HELD_BACK_MS = 25.0  # a reordered datagram: two ticks pass it
SECOND_COPY_MS = 15.0  # at most so much later
QUEUE_S = 0.25  # what waits longer for a throttled line is lost


@dataclass(frozen=True)
class Faults:
    """Of one direction. Shares are of its datagrams."""

    loss: float = 0.0
    burst_ms: float = 0.0  # nothing passes for half to all of this ...
    burst_every_s: float = 2.0  # ... once in this time
    delay_ms: float = 0.0
    jitter_ms: float = 0.0  # up to so much more, for each on its own: a later one may come sooner
    reorder: float = 0.0
    duplicate: float = 0.0
    corrupt: float = 0.0  # bits turned, or the end cut off
    rate_B_s: float = 0.0  # 0: as much as comes


class Way:
    """One direction of a link. Times [s] are whatever clock the caller keeps to."""

    def __init__(self, faults: Faults = Faults(), seed: int | str = 0) -> None:
        self._faults, self._seed = faults, seed
        self._posted, self._line_free_s = 0, 0.0
        self._under_way: list[tuple[float, int, bytes]] = []
        self.suffered: Counter[str] = Counter()  # by name of the fault

    def post(self, now_s: float, datagram: bytes) -> None:
        faults, chance = self._faults, random.Random(f"{self._seed} {self._posted}")
        self._posted += 1
        lost, spoiled, held_back, repeated = (chance.random() for _ in range(4))
        late_s, second_s = 1e-3 * faults.jitter_ms * chance.random(), 1e-3 * SECOND_COPY_MS * chance.random()
        if self._in_burst(now_s):
            self.suffered["burst"] += 1
            return
        if lost < faults.loss:
            self.suffered["loss"] += 1
            return
        sent_s = self._through_the_line(now_s, len(datagram))
        if sent_s is None:
            self.suffered["rate"] += 1
            return
        if spoiled < faults.corrupt:
            self.suffered["corrupt"] += 1
            datagram = _spoilt(datagram, chance)
        due_s = sent_s + 1e-3 * faults.delay_ms + late_s
        if held_back < faults.reorder:
            self.suffered["reorder"] += 1
            due_s += 1e-3 * HELD_BACK_MS
        heapq.heappush(self._under_way, (due_s, self._posted, datagram))
        if repeated < faults.duplicate:
            self.suffered["duplicate"] += 1
            heapq.heappush(self._under_way, (due_s + second_s, self._posted, datagram))

    def arrived(self, now_s: float) -> list[bytes]:
        """What is due, in the order in which it arrives."""
        there = []
        while self.next_s <= now_s:
            there.append(heapq.heappop(self._under_way)[2])
        return there

    @property
    def next_s(self) -> float:
        """When the next one arrives; infinite while nothing is under way."""
        return self._under_way[0][0] if self._under_way else math.inf

    def _in_burst(self, now_s: float) -> bool:
        faults = self._faults
        if faults.burst_ms == 0.0:
            return False
        number, into_s = divmod(now_s, faults.burst_every_s)
        chance = random.Random(f"{self._seed} burst {number:.0f}")
        length_s = 1e-3 * faults.burst_ms * chance.uniform(0.5, 1.0)
        begins_s = chance.uniform(0.0, faults.burst_every_s - length_s)
        return begins_s <= into_s < begins_s + length_s

    def _through_the_line(self, now_s: float, size: int) -> float | None:
        """When its last byte has gone out; None if it would wait too long."""
        if self._faults.rate_B_s == 0.0:
            return now_s
        begins_s = max(now_s, self._line_free_s)
        if begins_s - now_s > QUEUE_S:
            return None
        self._line_free_s = begins_s + size / self._faults.rate_B_s
        return self._line_free_s


def _spoilt(datagram: bytes, chance: random.Random) -> bytes:
    if chance.random() < 0.25:
        return datagram[: chance.randrange(len(datagram))]
    spoilt = bytearray(datagram)
    for bit in chance.sample(range(8 * len(spoilt)), chance.randint(1, 4)):
        spoilt[bit // 8] ^= 1 << bit % 8
    return bytes(spoilt)

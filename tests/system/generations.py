"""A client that writes parameters and missions, one generation after another, and knows what may be found afterwards.

Why: whoever loses its power, process or board, must answer for the same.
"""

from __future__ import annotations

from typing import Any

from system.gcs import ACCEPTED, Gcs, Item, bits
from system.processes import Running

PREFLIGHT_STORAGE, SAVE = 245, 1
REAL32 = 9
NAMES = ("MIS_TAKEOFF_ALT", "NAV_ACC_RAD")  # written as a pair, then stored


class Killed(Exception):
    """The other end is no more."""


class Writer(Gcs):
    """Writes one generation after another until the process is gone."""

    def __init__(self, instance: int, running: Running) -> None:
        super().__init__(instance)
        self._running = running

    def receive(self) -> list[Any]:
        if self._running.process.poll() is not None:
            raise Killed
        return super().receive()

    def write_params(self, generation: int) -> None:
        self.set_params(generation)
        assert self.command(PREFLIGHT_STORAGE, SAVE) == ACCEPTED

    def set_params(self, generation: int) -> None:
        for name in NAMES:
            ask = self._codec.param_set_encode(*self._target, name.encode(), value_of(generation), REAL32)
            self.until(lambda m, n=name: m.get_type() == "PARAM_VALUE" and m.param_id == n, ask)

    def read_params(self) -> list[float]:
        values = []
        for name in NAMES:
            ask = self._codec.param_request_read_encode(*self._target, name.encode(), -1)
            answer = self.until(lambda m, n=name: m.get_type() == "PARAM_VALUE" and m.param_id == n, ask)
            values.append(answer.param_value)
        return values


def value_of(generation: int) -> float:
    return 1.0 + (generation % 64) / 64  # exact in a float


def mission_of(generation: int) -> list[Item]:
    """Every item tells its generation; the count changes, too."""
    height = 10.0 + generation / 64
    return [(3, 16, 1, (0.0, 0.0, 0.0, 0.0), 473977420 + i, 85455940, height) for i in range(5 + generation % 17)]


class Store:
    """What may be found: the last generation acknowledged, or the one that was being written."""

    def __init__(self) -> None:
        self.params = [0, 0]
        self.mission = [0, 0]
        self.generation = 0

    def check(self, client: Writer) -> None:
        found = client.read_params()
        assert found in ([value_of(g)] * 2 for g in self.params), (found, self.params)
        items = [bits(item) for item in client.download()]
        assert items in ([bits(item) for item in mission_of(g)] for g in self.mission), self.mission
        assert not any("damaged" in text for text in client.texts)
        self.params = [g for g in self.params if found == [value_of(g)] * 2][:1] * 2
        self.mission = [g for g in self.mission if items == [bits(i) for i in mission_of(g)]][:1] * 2

    def write_on(self, client: Writer) -> None:
        """Until the other end is killed."""
        while True:
            self.generation += 1
            self.write(client, self.generation)

    def write(self, client: Writer, generation: int) -> None:
        self.params[1] = generation
        client.write_params(generation)
        self.params[0] = generation
        self.mission[1] = generation
        assert client.upload(mission_of(generation)) == ACCEPTED
        self.mission[0] = generation

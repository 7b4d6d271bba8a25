"""One vehicle and one ground station in this process, a millisecond at a time. Why: faults are put between autopilot
and world, where neither knows of them, and every word on the link is kept with its time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from halfroll import _dialect as dialect
from halfroll import _firmware

TAKEOFF, ARM, SET_MODE, REPOSITION = 22, 400, 176, 192


class Session:
    def __init__(self, vehicle: str = "mit-vp", scenario: str = "ideal", seed: int = 3) -> None:
        setup = _firmware.vehicle_setup(vehicle)
        self.autopilot = _firmware.Autopilot(setup.vehicle, setup.params)
        self.world = _firmware.World(setup.plant, scenario, seed)
        self.state_of_charge = 1.0
        self.effectiveness = [1.0] * 4  # share of its command that each rotor gives
        self.stuck: list[float | None] = [None] * 4  # [N], whatever it is told
        self.gyro: Callable[[Any], Any] = lambda world: world.gyro
        self.heard: list[tuple[int, Any]] = []  # (t_ms, message) on link A
        self._start_link()

    def _start_link(self) -> None:
        self._ours = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self._theirs = dialect.MAVLink(None)
        self._theirs.robust_parsing = True

    def copy(self) -> Session:
        twin = Session.__new__(Session)
        twin.__dict__.update(self.__dict__)
        twin.autopilot, twin.world = self.autopilot.copy(), self.world.copy()
        twin.effectiveness, twin.stuck, twin.heard = [*self.effectiveness], [*self.stuck], []
        twin._start_link()
        twin.heard = [(t, m) for t, m in self.heard if m.get_type() in ("SYS_STATUS", "HEARTBEAT")][-2:]
        return twin

    @property
    def t_ms(self) -> int:
        return int(self.autopilot.t_us // 1000)

    def step(self, *frames: Any, rx: bytes = b"") -> list[float]:
        for frame in frames:
            rx += frame.pack(self._ours)
            self._ours.seq = (self._ours.seq + 1) % 256
        w = self.world
        out = self.autopilot.step(self.gyro(w), w.accelerometer, w.pose, rx=rx, state_of_charge=self.state_of_charge)
        given = [
            told * share if stuck is None else stuck
            for told, share, stuck in zip(out.thrust, self.effectiveness, self.stuck, strict=True)
        ]
        w.step(given)
        for link, _, sent in out.tx:
            if link == 0:
                self.heard += [(self.t_ms, message) for message in self._theirs.parse_buffer(sent) or ()]
        return list(out.thrust)

    def run(self, ms: int) -> None:
        for _ in range(ms):
            self.step()

    def command(self, number: int, *params: float) -> int:
        """The result with which it was acknowledged."""
        filled = (*params, *[0.0] * (7 - len(params)))
        return self.ask(self._ours.command_long_encode(1, 1, number, 0, *filled))

    def ask(self, frame: Any) -> int:
        since = len(self.heard)
        self.step(frame)
        self.run(2)
        (ack,) = (m for _, m in self.heard[since:] if m.get_type() == "COMMAND_ACK")
        return int(ack.result)

    def mode(self, main: int, sub: int = 0) -> int:
        return self.command(SET_MODE, 1, main, sub)

    def set(self, name: str, value: float) -> None:
        self.step(self._ours.param_set_encode(1, 1, name.encode(), value, dialect.MAV_PARAM_TYPE_REAL32))
        self.run(1)
        assert self.autopilot.params[name] == pytest.approx(value, rel=1e-6), name

    def heartbeat(self) -> None:
        self.step(self._ours.heartbeat_encode(dialect.MAV_TYPE_GCS, 8, 0, 0, 0))

    def reposition(self, north: float = 0.0, west: float = 0.0, height: float | None = None) -> int:
        """Metres from the local origin."""
        lat, lon = 47.397742 + north / 111180.0, 8.545594 - west / 75430.0
        alt = math.nan if height is None else 488.0 + height
        frame = self._ours.command_int_encode(
            1, 1, 0, REPOSITION, 0, 0, -1, 1, 0, math.nan, round(lat * 1e7), round(lon * 1e7), alt
        )
        return self.ask(frame)

    def texts(self) -> list[tuple[int, int, str]]:
        return [(t, m.severity, m.text.rstrip("\0")) for t, m in self.heard if m.get_type() == "STATUSTEXT"]

    def last(self, kind: str) -> Any:
        return next(m for _, m in reversed(self.heard) if m.get_type() == kind)

    @property
    def up(self) -> float:
        """Cosine of the tilt: 1 upright, -1 inverted."""
        _, x, y, _ = self.world.q_WB
        return float(1.0 - 2.0 * (x * x + y * y))


def hovering(vehicle: str = "mit-vp", scenario: str = "ideal", height: float = 3.0) -> Session:
    """In HOLD, `height` metres over the origin, at rest."""
    flight = Session(vehicle, scenario)
    flight.run(1000)
    assert flight.command(TAKEOFF, 0, 0, 0, math.nan, 0, 0, height) == 0
    assert flight.command(ARM, 1) == 0
    flight.run(7000 + int(400 * height))
    assert flight.autopilot.mode == "Hold"
    flight.heard = [(t, m) for t, m in flight.heard if m.get_type() != "STATUSTEXT"]
    return flight

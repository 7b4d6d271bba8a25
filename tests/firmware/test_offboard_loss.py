"""What happens when the ground station falls silent in OFFBOARD, step by step in vehicle time.

The firmware flies a simulated vehicle inside this process; it is spoken to in bytes that pymavlink packs, as any ground
station's would be.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from halfroll import _firmware

dialect: Any = importlib.import_module("halfroll._dialect")

HOLD, OFFBOARD = 4 << 16 | 3 << 24, 6 << 16  # custom_mode
ARM_DISARM, SET_MODE, TAKEOFF, MESSAGE_INTERVAL = 400, 176, 22, 511
ATTITUDE_TARGET = 83
WARNING, INFO, CRITICAL = 4, 6, 2
ACTIVE, FAILSAFE = 4, 5  # system_status

HOVER = 0.571 * 9.80665 / 12.0  # mit-vp, of VEH_T_REF
LEVEL, INVERTED = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)
STREAM_MS, LATE_MS = 10, 25  # each step of the ladder may come this late


class Flight:
    """Autopilot and world, a millisecond at a time, and all that the autopilot has said: (t_ms, message)."""

    def __init__(self, autopilot: Any, world: Any, sent: int = 0) -> None:
        self.autopilot, self.world = autopilot, world
        self.heard: list[tuple[int, Any]] = []
        self._ours = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self._ours.seq = sent
        self._theirs = dialect.MAVLink(None)

    def copy(self) -> Flight:
        return Flight(self.autopilot.copy(), self.world.copy(), self._ours.seq)

    @property
    def t_ms(self) -> int:
        return int(self.autopilot.t_us // 1000)

    def step(self, *frames: Any) -> None:
        rx = b""
        for frame in frames:
            rx += frame.pack(self._ours)
            self._ours.seq = (self._ours.seq + 1) % 256
        w = self.world
        out = self.autopilot.step(w.gyro, w.accelerometer, w.pose, rx=rx)
        w.step(out.thrust)
        for link, _, sent in out.tx:
            if link == 0:
                self.heard += [(self.t_ms, message) for message in self._theirs.parse_buffer(sent) or ()]

    def run(self, ms: int) -> None:
        for _ in range(ms):
            self.step()

    def command(self, number: int, *params: float) -> int:
        """The result with which it was acknowledged."""
        filled = (*params, *[0.0] * (7 - len(params)))
        since = len(self.heard)
        self.step(self._ours.command_long_encode(1, 1, number, 0, *filled))
        self.run(2)
        (ack,) = (m for _, m in self.heard[since:] if m.get_type() == "COMMAND_ACK")
        return int(ack.result)

    def set_param(self, name: bytes, value: float) -> None:
        self.step(self._ours.param_set_encode(1, 1, name, value, dialect.MAV_PARAM_TYPE_REAL32))

    def stream(self, ms: int, q: tuple[float, ...], thrust: float, rates: tuple[float, ...] = (0.0, 0.0, 0.0)) -> None:
        """One SET_ATTITUDE_TARGET every 10 ms; the last one is 10 ms old at the end. On the wire's axes."""
        for _ in range(ms // STREAM_MS):
            self.step(self._ours.set_attitude_target_encode(self.t_ms, 1, 1, 0, q, *rates, thrust))
            self.run(STREAM_MS - 1)

    def said(self, kind: str, since_ms: int = 0) -> Iterator[tuple[int, Any]]:
        return ((t, m) for t, m in self.heard if m.get_type() == kind and t > since_ms)

    def texts(self) -> list[tuple[int, int, str]]:
        return [(t, m.severity, m.text.rstrip("\0")) for t, m in self.said("STATUSTEXT")]

    @property
    def up(self) -> float:
        """Cosine of the tilt: 1 upright, -1 inverted."""
        _, x, y, _ = self.world.q_WB
        return float(1.0 - 2.0 * (x * x + y * y))


@pytest.fixture(scope="module")
def offboard() -> Flight:
    """Hovering upright at 12 m in OFFBOARD, where a stream of level setpoints has begun."""
    setup = _firmware.vehicle_setup("mit-vp")
    flight = Flight(_firmware.Autopilot(setup.vehicle, setup.params), _firmware.World(setup.plant, "ideal", 0))
    flight.run(2000)
    assert flight.command(TAKEOFF, 0, 0, 0, math.nan, 0, 0, 12.0) == 0
    assert flight.command(ARM_DISARM, 1) == 0
    flight.run(15000)
    assert flight.world.p_WB[2] == pytest.approx(12.0, abs=0.1)
    assert flight.command(MESSAGE_INTERVAL, ATTITUDE_TARGET, 2500) == 0
    assert flight.command(SET_MODE, 1, 6, 0) == 0
    flight.stream(300, LEVEL, HOVER)
    return flight


@pytest.fixture(scope="module")
def lost(offboard: Flight) -> tuple[Flight, int]:
    """A yawing stream that ended, two seconds ago; and when its last setpoint came."""
    flight = offboard.copy()
    flight.stream(500, LEVEL, HOVER, rates=(0.0, 0.0, 1.0))
    last_ms = flight.t_ms - STREAM_MS + 1
    flight.run(2000)
    return flight, last_ms


@pytest.fixture(scope="module")
def lost_inverted(offboard: Flight) -> tuple[Flight, int]:
    """A stream that ended in inverted hover, eight seconds ago."""
    flight = offboard.copy()
    flight.stream(1200, INVERTED, -HOVER)
    assert flight.up < -0.99
    last_ms = flight.t_ms - STREAM_MS + 1
    flight.run(8000)
    return flight, last_ms


def after(event_ms: int, last_ms: int, age_ms: int) -> bool:
    """The step due at that age came, and not more than LATE_MS late. One millisecond belongs to the wire."""
    return age_ms <= event_ms - last_ms + 1 <= age_ms + 1 + LATE_MS


def test_a_steady_stream_is_followed_without_a_word(offboard: Flight) -> None:
    flight = offboard.copy()
    flight.stream(2000, LEVEL, HOVER)
    assert flight.texts() == []
    assert flight.autopilot.mode == "Offboard"


def test_a_stream_of_20_Hz_is_no_loss(offboard: Flight) -> None:
    flight = offboard.copy()
    for _ in range(20):
        flight.stream(STREAM_MS, LEVEL, HOVER)
        flight.run(40)
    assert flight.texts() == []
    assert flight.autopilot.mode == "Offboard"


def test_after_30_ms_the_body_rates_are_dropped_and_the_attitude_is_kept(lost: tuple[Flight, int]) -> None:
    flight, last_ms = lost
    kept = [
        (t, m)
        for t, m in flight.said("ATTITUDE_TARGET", since_ms=last_ms)
        if t < last_ms + 140 and m.body_yaw_rate == 0.0
    ]
    followed = [
        t for t, m in flight.said("ATTITUDE_TARGET") if t <= last_ms + 25 and m.body_yaw_rate == pytest.approx(1.0)
    ]
    assert followed[-1] >= last_ms + 25 - 3
    assert after(kept[0][0], last_ms, 30)
    assert all(np.abs(m.q[0]) > 0.99 and m.thrust == pytest.approx(HOVER, abs=1e-6) for _, m in kept)


def test_after_150_ms_it_recovers_and_says_so_while_still_in_offboard(lost: tuple[Flight, int]) -> None:
    flight, last_ms = lost
    t, severity, text = flight.texts()[0]
    assert (severity, text) == (WARNING, "Offboard: setpoints lost, recovering")
    assert after(t, last_ms, 150)
    modes = [m.custom_mode for s, m in flight.said("HEARTBEAT", since_ms=last_ms) if s < last_ms + 500]
    assert set(modes) <= {OFFBOARD}


def test_after_500_ms_it_holds_and_its_status_is_critical(lost: tuple[Flight, int]) -> None:
    flight, last_ms = lost
    t, severity, text = flight.texts()[1]
    assert (severity, text) == (CRITICAL, "Failsafe: offboard lost, Hold")
    assert after(t, last_ms, 500)
    told, heartbeat = next((s, m) for s, m in flight.said("HEARTBEAT", since_ms=last_ms) if m.custom_mode == HOLD)
    assert told - t <= 100
    assert heartbeat.system_status == FAILSAFE
    assert flight.autopilot.armed


def test_the_critical_status_ends_after_five_seconds(lost_inverted: tuple[Flight, int]) -> None:
    flight, last_ms = lost_inverted
    beats = [(t, m.system_status) for t, m in flight.said("HEARTBEAT", since_ms=last_ms + 500)]
    critical = [t for t, status in beats if status == FAILSAFE]
    assert critical[-1] <= last_ms + 500 + 5000 + LATE_MS
    assert [status for t, status in beats if t > last_ms + 500 + 5000 + LATE_MS + 100] == [ACTIVE] * 2


def test_a_setpoint_within_500_ms_resumes_the_flight_at_once(offboard: Flight) -> None:
    flight = offboard.copy()
    flight.run(400)
    flight.stream(1000, LEVEL, HOVER)
    assert [(severity, text) for _, severity, text in flight.texts()] == [
        (WARNING, "Offboard: setpoints lost, recovering"),
        (INFO, "Offboard: setpoints regained"),
    ]
    assert flight.autopilot.mode == "Offboard"


def test_a_setpoint_after_500_ms_changes_nothing(offboard: Flight) -> None:
    flight = offboard.copy()
    flight.run(700)
    flight.stream(1000, LEVEL, HOVER)
    assert flight.autopilot.mode == "Hold"


def test_lost_in_inverted_flight_it_rolls_upright_and_stops(lost_inverted: tuple[Flight, int]) -> None:
    flight, _ = lost_inverted
    assert [text for _, _, text in flight.texts()] == [
        "Offboard: setpoints lost, recovering",
        "Failsafe: offboard lost, Hold",
    ]
    assert flight.up > 0.999
    assert np.linalg.norm(flight.world.v_WB) < 0.05
    assert flight.autopilot.mode == "Hold"


def test_the_height_lost_while_rolling_upright_is_less_than_two_metres(offboard: Flight) -> None:
    flight = offboard.copy()
    flight.stream(1200, INVERTED, -HOVER)
    began, lowest = flight.world.p_WB[2], math.inf
    for _ in range(3000):
        flight.step()
        lowest = min(lowest, flight.world.p_WB[2])
    assert began - lowest < 2.0


def lost_at_speed(flight: Flight) -> tuple[float, float]:
    """Tilted by 60 deg at full thrust for 0.3 s, then silence: least cosine of the tilt, and distance from the loss."""
    flight.stream(300, (math.cos(math.pi / 6), 0.0, -math.sin(math.pi / 6), 0.0), 1.0)
    assert flight.up > 0.4
    place, lowest_up, farthest = np.array(flight.world.p_WB), 1.0, 0.0
    for _ in range(4000):
        flight.step()
        lowest_up = min(lowest_up, flight.up)
        farthest = max(farthest, float(np.linalg.norm(flight.world.p_WB - place)))
    assert flight.up > 0.999
    assert np.linalg.norm(flight.world.v_WB) < 0.05
    return lowest_up, farthest


def test_at_speed_it_brakes_upside_down_where_that_is_nearer_and_then_rolls_upright(offboard: Flight) -> None:
    high, low = offboard.copy(), offboard.copy()
    low.set_param(b"INV_MIN_ALT", 20.0)
    lowest_up, farthest = lost_at_speed(high)
    lowest_up_upright, farthest_upright = lost_at_speed(low)
    assert lowest_up < -0.3
    assert lowest_up_upright > 0.3  # too low for the half roll: upright, as everywhere else
    assert farthest < farthest_upright - 0.2


def test_without_any_setpoint_offboard_is_left_after_a_second(offboard: Flight) -> None:
    flight = offboard.copy()
    assert flight.command(SET_MODE, 1, 4, 3) == 0
    flight.run(200)
    assert flight.command(SET_MODE, 1, 6, 0) == 0
    entered_ms = flight.t_ms - 2
    flight.run(1500)
    t, _, text = flight.texts()[-1]
    assert text == "Offboard: no setpoints"
    assert after(t, entered_ms, 1000)
    assert flight.autopilot.mode == "Hold"


@pytest.mark.parametrize(("action", "mode"), [(1, "Land"), (2, "Return"), (3, "Hold")])
def test_what_follows_the_loss_is_a_parameter(offboard: Flight, action: int, mode: str) -> None:
    flight = offboard.copy()
    flight.set_param(b"OFB_LOSS_ACT", float(action))
    flight.run(600)
    assert flight.autopilot.mode == mode

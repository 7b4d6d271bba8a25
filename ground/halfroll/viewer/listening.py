"""A flight that goes on now: telemetry by a link of the viewer's own, and what the ground station tells.

Why: a viewer is a companion of the autopilot that asks for its streams and else says nothing, so that it works beside
any ground control station and disturbs none. What a person orders at the page goes out here, too, for one thread owns
the link.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from halfroll.errors import LinkError
from halfroll.vehicle import Vehicle
from halfroll.viewer.moments import Gate, Moment, Setting
from halfroll.wire import messages as wire
from halfroll.wire.conversations import ARM_DISARM, Conversation, Talk, command, set_mode
from halfroll.wire.link import Link
from halfroll.wire.messages import Message, Telemetry
from halfroll.wire.told import ToldPlan, ToldReference, unpacked
from halfroll.wire.transport import Clock, UdpTransport, wall_s

HEARTBEAT_S = 1.0
RATE_S = 0.02  # wanted between two samples of what comes on request
STALE_US = 100_000  # of vehicle time: a reference as far away as that says nothing
FAILSAFE_ACTS = 5  # system_status: critical; 6: terminated
CUT_LINK, CUT_S = 0, 1.0  # link A, the ground station's
GUST_M_S, GUST_RISE_S, GUST_HOLD_S = 6.0, 0.3, 0.5
_SET_MESSAGE_INTERVAL, _MISSION_START, _GUST, _CUT = 511, 300, 31011, 31012
_ON_REQUEST = {"ACTUATOR_OUTPUT_STATUS": 375, "ATTITUDE_TARGET": 83, "ODOMETRY": 331}
_RESULTS = ("done", "refused for now", "refused", "not known here", "failed")


class Listener:
    """transport: to the autopilot, which is `system`; told: where a ground station says what it flies, or None."""

    def __init__(
        self,
        transport: UdpTransport,
        told: UdpTransport | None,
        vehicle: Vehicle,
        system: int,
        title: str,
        clock: Clock = wall_s,
    ) -> None:
        self._link = Link(transport, wire.VIEWER, also=tuple(_ON_REQUEST))
        self._link.address(system)  # it talks to who has talked to it
        self._told, self._vehicle, self._clock = told, vehicle, clock
        self._largest_N = vehicle.rotor.thrust_max_N
        self.setting = Setting(title, (vehicle.rotor.thrust_min_N, vehicle.rotor.thrust_max_N), vehicle.arm_m)
        self.moment: Moment | None = None  # the latest
        self.said: deque[str] = deque(maxlen=6)  # by the autopilot, and answers to what was ordered
        self._plan: ToldPlan | None = None
        self._references: deque[ToldReference] = deque(maxlen=64)
        self._mode, self._armed, self._status = "", False, 0
        self._current: wire.MissionCurrent | None = None
        self._rotor_N: wire.Array | None = None
        self._wanted: wire.Array | None = None
        self._failsafe = ""
        self._heard_s: deque[float] = deque(maxlen=256)  # wall clock of telemetry
        self._beat_s = self._asked_s = -math.inf
        self._talk: Talk[int] | None = None
        self._orders: deque[tuple[str, Conversation[int]]] = deque()
        self._ordered = ""

    @property
    def heard(self) -> bool:
        return self.moment is not None

    def listen(self, timeout_s: float) -> bool:
        """Waits at most timeout_s for something; whether there is a new moment."""
        before = self.moment
        if self._told:
            for datagram in self._told.receive():
                self._hear_told(unpacked(datagram))
            self._told.forget_peer()  # another station may speak next
        for message in self._link.receive(timeout_s):
            self._hear(message)
        self._go_on()
        if self.moment is before and self.moment is not None:
            self.moment = replace(self.moment, link_age_s=self._age(), link_rate_Hz=self._rate())
            return False
        return self.moment is not before

    # What a person orders; one after the other.

    def start(self) -> None:
        """Arms, and starts the mission that is stored."""
        self._order("arm", command(self._link, ARM_DISARM, 1.0, what="to arming"))
        self._order("start", command(self._link, _MISSION_START, what="to the mission's start"))

    def hold(self) -> None:
        self._order("hold", set_mode(self._link, wire.HOLD))

    def land(self) -> None:
        self._order("land", set_mode(self._link, wire.LAND))

    def gust(self) -> None:
        """From the west, in the simulated world."""
        said = (0.0, GUST_M_S, 0.0, GUST_RISE_S, GUST_HOLD_S)
        self._order("gust", command(self._link, _GUST, *said, what="to a gust", component=wire.WORLD))

    def cut_link(self) -> None:
        """The ground station's, in the simulated world."""
        self._order("cut", command(self._link, _CUT, CUT_LINK, CUT_S, what="to a cut", component=wire.WORLD))

    def _order(self, name: str, conversation: Conversation[int]) -> None:
        self._orders.append((name, conversation))

    def _go_on(self) -> None:
        now_s = self._clock()
        if now_s - self._beat_s >= HEARTBEAT_S:
            self._beat_s = now_s
            self._link.send(self._link.heartbeat())
            if self._rotor_N is None or now_s - self._asked_s > 10.0:  # it may have been restarted
                self._asked_s = now_s
                for number in _ON_REQUEST.values():
                    self._link.send(self._link.command(_SET_MESSAGE_INTERVAL, float(number), 1e6 * RATE_S))
        if self._talk is None and self._orders:
            self._ordered, conversation = self._orders.popleft()
            self._talk = Talk(self._link, conversation, self._clock)
        if self._talk:
            try:
                self._talk.go_on()
            except LinkError as error:
                self.said.append(f"{self._ordered}: {error}")
                self._talk = None

    def _hear(self, message: Message) -> None:
        if self._talk:
            self._talk.hear(message)
            if self._talk.done:
                result = self._talk.result or 0
                self.said.append(f"{self._ordered}: {_RESULTS[result] if result < len(_RESULTS) else result}")
                self._talk = None
        if isinstance(message, Telemetry):
            self._hear_telemetry(message)
        elif isinstance(message, wire.Heartbeat):
            self._mode = wire.MODE_NAMES.get(message.mode, str(message.mode))
            self._armed, self._status = message.armed, message.status
            if message.status < FAILSAFE_ACTS:
                self._failsafe = ""
        elif isinstance(message, wire.MissionCurrent):
            self._current = message if message.total != wire.NO_SEQUENCE else None
        elif isinstance(message, wire.RotorThrusts):
            self._rotor_N = message.fractions * self._largest_N
        elif isinstance(message, wire.AttitudeWanted):
            self._wanted = message.q_WD
        elif isinstance(message, wire.StatusText):
            self.said.append(message.text)
            if message.text.startswith("Failsafe"):
                self._failsafe = message.text

    def _hear_telemetry(self, here: Telemetry) -> None:
        self._heard_s.append(self._clock())
        reference = reference_at(self._references, here.t_us)
        self.moment = Moment(
            t_s=here.t_us * 1e-6,
            p_WB=here.p_WB,
            q_WB=here.q_WB,
            v_WB=here.v_WB,
            w_WB_B=here.w_WB_B,
            rotor_N=self._rotor_N,
            reference_p=reference.p if reference else None,
            reference_q=reference.q_WD if reference else self._wanted if self._armed else None,
            mode=self._mode,
            armed=self._armed,
            item=self._current.seq if self._current else None,
            items=self._current.total if self._current else None,
            warning=self._warning(),
            link_rate_Hz=self._rate(),
            link_age_s=self._age(),
        )

    def _hear_told(self, told: ToldPlan | ToldReference | None) -> None:
        if isinstance(told, ToldReference):
            self._references.append(told)
        elif told is not None and (self._plan is None or not np.array_equal(told.path, self._plan.path)):
            self._plan = told
            gates = tuple(Gate(p, q) for p, q in told.gates)
            self._largest_N = told.thrust_N[1]
            self.setting = Setting(self.setting.title, told.thrust_N, told.arm_m, told.path, gates)

    def _warning(self) -> str:
        return (self._failsafe or "Failsafe") if self._status >= FAILSAFE_ACTS else ""

    def _rate(self) -> float:
        """Samples in the last second."""
        now_s = self._clock()
        return float(sum(1 for heard_s in self._heard_s if now_s - heard_s <= 1.0))

    def _age(self) -> float:
        return self._clock() - self._heard_s[-1] if self._heard_s else math.inf


def reference_at(told: Sequence[ToldReference], t_us: int) -> ToldReference | None:
    """What was wanted at t_us: position along the line through the two references that are nearest, attitude of the
    nearer one; at 12 m/s the 20 ms between two would otherwise pass for an error of 0.2 m. None where none is near."""
    near = sorted((each for each in told if abs(each.t_us - t_us) < STALE_US), key=lambda each: abs(each.t_us - t_us))
    if not near:
        return None
    first = near[0]
    other = next((each for each in near if each.t_us != first.t_us), None)
    if other is None:
        return first
    share = (t_us - first.t_us) / (other.t_us - first.t_us)
    return ToldReference(t_us, first.p + share * (other.p - first.p), first.q_WD)

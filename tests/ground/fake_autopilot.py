"""An autopilot of a hundred lines: answers as the contract says, flies as it is told, and writes down what it heard.

Why: station, pilot and link are tested against this, in one process and without a clock; it shares no line with them
but the generated dialect.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

dialect = importlib.import_module("halfroll._dialect")

HOLD, MISSION, LAND, OFFBOARD = 50593792, 67371008, 100925440, 393216
PARAMS = {
    "ACT_LEAD": 0.021, "ATT_WN": 16.0, "ATT_ZETA": 0.9, "FADE_FORCE": 6.0, "HOLD_FORCE": 0.1, "LAG_COMP": 3.0,
    "POS_KD_XY": 6.3, "POS_KD_Z": 6.3, "POS_KI_XY": 1.0, "POS_KI_Z": 1.0, "POS_KP_XY": 12.0, "POS_KP_Z": 12.0,
    "SIGN_RULE": 0.0, "VEH_DRAG": 0.0, "VEH_T_REF": 12.0, "MIS_TAKEOFF_ALT": 2.5,
}  # fmt: skip


@dataclass
class FakeAutopilot:
    """links: our ends of offboard and GCS link; lost(frame) true: what it sends, or would hear, is lost."""

    links: list[Any]
    lockstep: bool = False
    lost: Callable[[Any], bool] = lambda frame: False
    refuse: dict[int, int] = field(default_factory=dict)  # command -> result
    mode: int = HOLD
    armed: bool = False
    seq: int = 0
    mission_state: int = 1
    items: list[Any] = field(default_factory=list)
    incoming: list[Any] | None = None
    expected: int = 0
    t_ms: int = 0
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))  # north, east, down
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    home: np.ndarray = field(default_factory=lambda: np.zeros(3))
    heard: list[tuple[int, Any]] = field(default_factory=list)  # (vehicle time in ms, frame)
    quiet: int = 0  # times it listened in vain
    released: int = -1  # stamp of the last echo
    params: dict[str, float] = field(default_factory=lambda: dict(PARAMS))

    def __post_init__(self) -> None:
        self.codecs = [dialect.MAVLink(None, srcSystem=1, srcComponent=1) for _ in self.links]
        for codec in self.codecs:
            codec.robust_parsing = True

    # What a test asks of it.

    def names_heard(self) -> list[str]:
        return [frame.get_type() for _, frame in self.heard]

    def setpoints(self) -> list[Any]:
        return [frame for _, frame in self.heard if frame.get_type() == "SET_ATTITUDE_TARGET"]

    def commands(self) -> list[tuple[int, float, float, float]]:
        kinds = ("COMMAND_LONG",)
        return [(f.command, f.param1, f.param2, f.param3) for _, f in self.heard if f.get_type() in kinds]

    @property
    def mission_id(self) -> int:
        return 1 + sum(item.x & 0xFFFF for item in self.items) if self.items else 0

    # Its life.

    def send(self, name: str, *fields: Any, link: int | None = None) -> None:
        for number, (transport, codec) in enumerate(zip(self.links, self.codecs, strict=True)):
            if link in (None, number):
                frame = getattr(codec, name + "_encode")(*fields)
                if not self.lost(frame):
                    transport.send(frame.pack(codec))

    def heartbeat(self) -> None:
        self.send("heartbeat", 2, 0, 29 + 128 * self.armed, self.mode, 4 if self.armed else 3)

    def tell_mission(self) -> None:
        self.send("mission_current", self.seq, len(self.items), self.mission_state, 1, self.mission_id)

    def tell_place(self) -> None:
        lat, lon = 473977420, 85455940
        self.send("gps_global_origin", lat, lon, 488000)
        north, east, down = (float(x) for x in self.home)
        still = [1.0, 0.0, 0.0, 0.0]
        alt = round(488000 - 1000 * down)
        self.send("home_position", lat, lon, alt, north, east, down, still, math.nan, math.nan, math.nan)

    def set_mode(self, mode: int) -> None:
        self.mode = mode
        self.heartbeat()

    def reach(self, seq: int) -> None:
        """Item seq was flown; the next is the current one."""
        self.send("mission_item_reached", seq)
        self.seq = seq + 1
        self.tell_mission()

    def tick(self) -> bool:
        """10 ms, unless lockstep holds time. Telemetry first, then the request."""
        self.listen()
        if self.lockstep and self.released < self.t_ms * 1_000_000 and self.t_ms:
            return False
        self.t_ms += 10
        if self.t_ms % 1000 == 10:
            self.heartbeat()
        if self.t_ms % 500 == 10:
            self.tell_mission()
            self.tell_place()
        p, v = self.position.tolist(), self.velocity.tolist()
        self.send("attitude_quaternion", self.t_ms, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.send("local_position_ned", self.t_ms, *p, *v)
        if self.lockstep:
            self.ask_time()
        return True

    def ask_time(self) -> None:
        self.send("timesync", 0, self.t_ms * 1_000_000, link=0)

    def listen(self) -> None:
        self.quiet += 1
        if self.incoming is not None and self.quiet % 25 == 0:
            self.send("mission_request_int", 255, 190, len(self.incoming))
        for number, (transport, codec) in enumerate(zip(self.links, self.codecs, strict=True)):
            for datagram in transport.receive():
                for frame in codec.parse_buffer(datagram) or ():
                    if self.lost(frame):
                        continue
                    self.quiet = 0
                    self.heard.append((self.t_ms, frame))
                    answer = getattr(self, "hear_" + frame.get_type().lower(), None)
                    if answer:
                        answer(frame, number)

    # Answers, one for each message of the contract that a test needs.

    def hear_timesync(self, frame: Any, link: int) -> None:
        if frame.tc1 == 0:
            self.send("timesync", self.t_ms * 1_000_000 + 1, frame.ts1, link=link)
        elif frame.get_srcComponent() == 191:
            self.released = frame.ts1

    def hear_command_long(self, frame: Any, link: int) -> None:
        result = self.refuse.get(frame.command, 0)
        if result == 0 and frame.command == 176:
            self.mode = int(frame.param2) << 16 | int(frame.param3) << 24
        if result == 0 and frame.command == 400:
            self.armed = bool(frame.param1)
        if result == 0 and frame.command == 224:
            self.seq = int(frame.param1)
        self.send("command_ack", frame.command, result, link=link)
        if frame.command in (176, 400):
            self.heartbeat()

    def hear_param_request_read(self, frame: Any, link: int) -> None:
        if frame.param_id not in self.params:
            self.send("param_error", 0, 0, frame.param_id.encode(), -1, 1, link=link)
            return
        self.send("param_value", frame.param_id.encode(), self.params[frame.param_id], 9, 45, 0, link=link)

    def hear_param_set(self, frame: Any, link: int) -> None:
        self.params[frame.param_id] = frame.param_value
        self.hear_param_request_read(frame, link)

    def hear_mission_request_list(self, frame: Any, link: int) -> None:
        self.send("mission_count", 255, 190, len(self.items), 0, self.mission_id, link=link)

    def hear_mission_request_int(self, frame: Any, link: int) -> None:
        m = self.items[frame.seq]
        params = (m.param1, m.param2, m.param3, m.param4)
        fields = (frame.seq, m.frame, m.command, 0, m.autocontinue, *params, m.x, m.y, m.z)
        self.send("mission_item_int", 255, 190, *fields, link=link)

    def hear_mission_count(self, frame: Any, link: int) -> None:
        self.incoming, self.expected = [], frame.count
        self.send("mission_request_int", 255, 190, 0, link=link)

    def hear_mission_item_int(self, frame: Any, link: int) -> None:
        if self.incoming is None or frame.seq != len(self.incoming):
            return
        if frame.command == 31:
            self.incoming = None
            self.send("mission_ack", 255, 190, 3, link=link)
            return
        self.incoming.append(frame)
        if len(self.incoming) < self.expected:
            self.send("mission_request_int", 255, 190, len(self.incoming), link=link)
            return
        self.items, self.incoming, self.seq, self.mission_state = self.incoming, None, 0, 2
        self.send("mission_ack", 255, 190, 0, 0, self.mission_id, link=link)
        self.tell_mission()

"""The autopilot in its simulated vehicle, and clients on its links: bytes in, bytes out, nothing between them.

Why: a contract is about the wire. Clients here pack and read frames with pymavlink alone; time passes only when a test
says so, and the shell's wall clock is a number the test turns.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterable
from typing import Any

from halfroll import _firmware

dialect: Any = importlib.import_module("halfroll._dialect")

A, B, C = 0, 1, 2  # links: offboard, ground control stations, companion
EVERYONE = 255  # slot: all endpoints of a link
NAN, INF = math.nan, math.inf
INT32_MAX = 2**31 - 1

ACCEPTED, NOT_NOW, DENIED, UNSUPPORTED, FAILED = range(5)  # MAV_RESULT
HOLD, MISSION, RTL, LAND, TAKEOFF = (4 << 16 | sub << 24 for sub in (3, 4, 5, 6, 2))
OFFBOARD = 6 << 16
ORIGIN_LAT, ORIGIN_LON, ORIGIN_ALT_M = 473977420, 85455940, 488.0  # degE7: where the simulator stands by default

Item = tuple[
    int, int, int, tuple[float, float, float, float], int, int, float
]  # frame, command, autocontinue, p1..p4, x, y, z


class Client:
    """Somebody on a link: what it sends, and all that it heard, as (vehicle time in ms, message)."""

    def __init__(self, aircraft: Aircraft, link: int, slot: int, system: int, component: int) -> None:
        self.aircraft, self.link, self.slot = aircraft, link, slot
        self.encode = dialect.MAVLink(None, srcSystem=system, srcComponent=component)
        self._parse = dialect.MAVLink(None)
        self._parse.robust_parsing = True
        self.heard: list[tuple[int, Any]] = []
        self.frames: list[bytes] = []

    def receive(self, frame: bytes) -> None:
        self.frames.append(frame)
        self.heard += [(self.aircraft.t_ms, message) for message in self._parse.parse_buffer(frame) or ()]

    def pack(self, message: Any, **options: Any) -> bytes:
        self.encode.seq = (self.encode.seq + 1) % 256
        return bytes(message.pack(self.encode, **options))

    def ask(self, message: Any | bytes) -> list[Any]:
        """What was heard in answer, while no time passed."""
        since = len(self.heard)
        self.aircraft.serve(message if isinstance(message, bytes) else self.pack(message), self.link, self.slot)
        return [answer for _, answer in self.heard[since:]]

    def only(self, kind: str, message: Any) -> Any:
        """The one answer of a kind."""
        answers = [m for m in self.ask(message) if m.get_type() == kind]
        assert len(answers) == 1, answers
        return answers[0]

    def all(self, kind: str, since_ms: int = -1) -> list[Any]:
        return [m for t, m in self.heard if m.get_type() == kind and t > since_ms]

    def times(self, kind: str, since_ms: int = -1) -> list[int]:
        return [t for t, m in self.heard if m.get_type() == kind and t > since_ms]

    @property
    def texts(self) -> list[str]:
        return [m.text for m in self.all("STATUSTEXT")]

    # What clients do

    def acknowledged(self, message: Any) -> int:
        """The result of the one COMMAND_ACK to a command."""
        ack = self.only("COMMAND_ACK", message)
        assert (ack.target_system, ack.target_component) == (self.encode.srcSystem, self.encode.srcComponent)
        return int(ack.result)

    def command(self, number: int, *params: float, target: tuple[int, int] = (1, 1)) -> int:
        """COMMAND_LONG; params not given are 0."""
        filled = (*params, *[0.0] * (7 - len(params)))
        return self.acknowledged(self.encode.command_long_encode(*target, number, 0, *filled))

    def command_int(self, number: int, frame: int, params: Iterable[float], x: int, y: int, z: float) -> int:
        return self.acknowledged(self.encode.command_int_encode(1, 1, frame, number, 0, 0, *params, x, y, z))

    def set_mode(self, custom_mode: int) -> int:
        return self.command(176, 1, custom_mode >> 16 & 0xFF, custom_mode >> 24)

    def request(self, message_id: int, parameter: float = 0.0) -> Any:
        """A message asked for: the one that came."""
        kind = dialect.mavlink_map[message_id].msgname
        answers = self.ask(self.encode.command_long_encode(1, 1, 512, 0, message_id, parameter, 0, 0, 0, 0, 0))
        assert [m.get_type() for m in answers] == ["COMMAND_ACK", kind]
        return answers[1]

    def set_param(self, name: str, value: float, kind: int = 9) -> list[Any]:
        return self.ask(self.encode.param_set_encode(1, 1, name.encode(), value, kind))

    def read_param(self, name: str) -> float:
        ask = self.encode.param_request_read_encode(1, 1, name.encode(), -1)
        return float(self.only("PARAM_VALUE", ask).param_value)

    def count(self, n: int, kind: int = 0) -> list[Any]:
        return self.ask(self.encode.mission_count_encode(1, 1, n, kind))

    def item(self, seq: int, item: Item, *, current: int = 0, kind: int = 0) -> list[Any]:
        frame, command, autocontinue, params, x, y, z = item
        return self.ask(
            self.encode.mission_item_int_encode(
                1, 1, seq, frame, command, current, autocontinue, *params, x, y, z, mission_type=kind
            )
        )

    def upload(self, items: list[Item]) -> int:
        """The type of the MISSION_ACK that ends it."""
        answers = self.count(len(items))
        while answers[-1].get_type() == "MISSION_REQUEST_INT":
            seq = answers[-1].seq
            since = len(self.heard)
            self.item(seq, items[seq])
            for _ in range(1000):  # a long mission is checked and named in pieces, a millisecond each
                heard = [m for _, m in self.heard[since:]]
                answers = [m for m in heard if m.get_type() in ("MISSION_REQUEST_INT", "MISSION_ACK")]
                if answers:
                    break
                self.aircraft.step()
        return int(answers[-1].type)

    def download(self) -> list[Item]:
        n = self.only("MISSION_COUNT", self.encode.mission_request_list_encode(1, 1)).count
        items: list[Item] = []
        for seq in range(n):
            m = self.only("MISSION_ITEM_INT", self.encode.mission_request_int_encode(1, 1, seq))
            params = (m.param1, m.param2, m.param3, m.param4)
            items.append((m.frame, m.command, m.autocontinue, params, m.x, m.y, m.z))
        return items

    def attitude_target(self, **fields: Any) -> Any:
        """SET_ATTITUDE_TARGET: level, hovering, dated now, unless said otherwise."""
        given = {
            "time_boot_ms": self.aircraft.t_ms,
            "target_system": 1,
            "target_component": 1,
            "type_mask": 0,
            "q": [1.0, 0.0, 0.0, 0.0],
            "body_roll_rate": 0.0,
            "body_pitch_rate": 0.0,
            "body_yaw_rate": 0.0,
            "thrust": HOVER,
        }
        return self.encode.set_attitude_target_encode(**{**given, **fields})


HOVER = 0.571 * 9.80665 / 12.0  # of VEH_T_REF, for mit-vp


class Aircraft:
    """Autopilot, world and the clients that listen. A value: `copy` is another aircraft with nobody on its links."""

    def __init__(self, autopilot: Any, world: Any) -> None:
        self.autopilot, self.world = autopilot, world
        self.stood_us = 0  # wall clock that passed while the vehicle's time stood
        self.commanded = [0.0] * 4  # rotor thrusts [N] of the last step
        self._clients: list[Client] = []

    @classmethod
    def new(
        cls, *, px4_identity: bool = False, speed: float = 1.0, scenario: str = "ideal", **params: float
    ) -> Aircraft:
        setup = _firmware.vehicle_setup("mit-vp", [f"params.{name}={value}" for name, value in params.items()])
        options = {"px4_identity": px4_identity, "simulation_speed": speed}
        autopilot = _firmware.Autopilot(setup.vehicle, setup.params, **options)  # type: ignore[arg-type]
        return cls(autopilot, _firmware.World(setup.plant, scenario, 0))

    def copy(self) -> Aircraft:
        twin = Aircraft(self.autopilot.copy(), self.world.copy())
        twin.stood_us = self.stood_us
        return twin

    @property
    def t_ms(self) -> int:
        return int(self.autopilot.t_us // 1000)

    @property
    def wall_us(self) -> int:
        return int(self.autopilot.t_us) + self.stood_us

    def client(self, link: int = B, slot: int = 0, system: int = 255, component: int = 190) -> Client:
        self._clients.append(Client(self, link, slot, system, component))
        return self._clients[-1]

    def serve(self, rx: bytes = b"", link: int = B, slot: int = 0) -> None:
        """Bytes in while no time passes; then nothing, as often as checking and storing a long mission need."""
        for bytes_in in (rx, *[b""] * 12):
            self._deliver(self.autopilot.service(bytes_in, link, slot, self.wall_us))

    def stand(self, wall_s: float, period_s: float = 0.02) -> None:
        """Time stands while the wall clock runs: the simulator is paused."""
        for _ in range(round(wall_s / period_s)):
            self.stood_us += round(period_s * 1e6)
            self._deliver(self.autopilot.service(b"", B, 0, self.wall_us))

    def step(self, rx: bytes = b"", link: int = B, slot: int = 0, pose: bool = True) -> None:
        w = self.world
        out = self.autopilot.step(
            w.gyro, w.accelerometer, w.pose if pose else None, rx=rx, link=link, slot=slot, wall_us=self.wall_us + 1000
        )
        w.step(out.thrust)
        self.commanded = out.thrust
        self._deliver(out.tx)

    def run(self, s: float, pose: bool = True) -> None:
        for _ in range(round(s * 1000)):
            self.step(pose=pose)

    def fly(self, s: float) -> None:
        """Without anybody listening."""
        self.autopilot.fly(self.world, round(s * 1000))

    def stream(self, client: Client, s: float, period_ms: int = 10, **fields: Any) -> None:
        """SET_ATTITUDE_TARGETs of one client; the last is one period old at the end."""
        for _ in range(round(s * 1000 / period_ms)):
            self.step(client.pack(client.attitude_target(**fields)), client.link, client.slot)
            self.run((period_ms - 1) / 1000)

    def _deliver(self, packets: list[tuple[int, int, bytes]]) -> None:
        for link, slot, frame in packets:
            for client in self._clients:
                if client.link == link and slot in (client.slot, EVERYONE):
                    client.receive(frame)

"""Every message that the autopilot understands, with NaN, infinity, denormal and huge numbers in every field in turn.

Why: what a field may do in flight is written down here and nowhere assumed: it is refused aloud and the flight stays as
it was, bit for bit; or it means nothing there, and the flight is that of the same message without it; or it is a
number like any other, and those are listed.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from halfroll import _firmware
from system.contract.aircraft import HOVER, ORIGIN_LAT, ORIGIN_LON, Aircraft, dialect

FLOATS = {
    "NaN": math.nan,
    "infinite": math.inf,
    "minus infinite": -math.inf,
    "denormal": 1e-42,
    "huge": 3e38,
    "minus huge": -3e38,
}
ADDRESS = {"target_system", "target_component", "target"}  # whom it is for; nothing that the autopilot obeys
LETTERS = {"int8_t": "b", "uint8_t": "B", "int16_t": "h", "uint16_t": "H", "int32_t": "i", "uint32_t": "I"}
LONG_LETTERS = {"int64_t": "q", "uint64_t": "Q"}
COMMAND_LONG, COMMAND_INT = 76, 75
UNSUPPORTED = 3
FLOWN_S = 0.25
ANSWERS = (  # what is said to one client alone
    "PARAM_VALUE",
    "MISSION_COUNT",
    "MISSION_ITEM",
    "MISSION_ITEM_INT",
    "MISSION_REQUEST_INT",
    "TIMESYNC",
    "PING",
    "MISSION_CURRENT",
    "FILE_TRANSFER_PROTOCOL",
)

Fields = dict[str, Any]


def extremes(kind: str) -> dict[str, Any]:
    """Values to try in a field of this wire type."""
    if kind == "float":
        return FLOATS
    if kind == "char":
        return {}
    letter = {**LETTERS, **LONG_LETTERS}[kind]
    bits = 8 * struct.calcsize(letter)
    if letter.isupper():
        return {"largest": 2**bits - 1}
    return {"largest": 2 ** (bits - 1) - 1, "smallest": -(2 ** (bits - 1))}


@dataclass(frozen=True)
class Case:
    """One message with one field that is extreme; `plain` is the same without."""

    message: str
    command: int | None
    field: str
    value: str
    fields: Fields
    plain: Fields
    zero: Fields  # the same with 0 in that field

    @property
    def what(self) -> str:
        """Message or command, and its field; elements of an array are alike."""
        return f"{self.message if self.command is None else self.command} {self.field.split('[')[0]}"

    @property
    def name(self) -> str:
        number = "" if self.command is None else f" {self.command}"
        return f"{self.message}{number}: {self.field} {self.value}"


def understood() -> list[int]:
    """Ids of the messages that the firmware does not pass over."""
    codec = dialect.MAVLink(None)
    found = []
    for number, kind in dialect.mavlink_map.items():
        fields = zeros(kind)
        if _firmware.understands(bytes(kind(*[fields[name] for name in kind.fieldnames]).pack(codec))):
            found.append(number)
    return found


def zeros(kind: Any) -> Fields:
    lengths = dict(zip(kind.ordered_fieldnames, kind.array_lengths, strict=True))
    out: Fields = {}
    for name, wire in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        blank: Any = b"" if wire == "char" else 0
        out[name] = [0] * lengths[name] if lengths[name] and wire != "char" else blank
        if name in ADDRESS:
            out[name] = 1
    return out


def plain(kind: Any, aircraft: Aircraft) -> Fields:
    """A message that a client might send now."""
    at = {
        "time_boot_ms": aircraft.t_ms,
        "q": [1.0, 0.0, 0.0, 0.0],
        "thrust": HOVER,
        "param_id": b"ATT_WN",
        "param_type": 9,
        "param_value": 14.0,
        "param_index": -1,
        "latitude": ORIGIN_LAT,
        "longitude": ORIGIN_LON,
        "altitude": 488000,
        "frame": 3,
        "frame_id": 1,
        "coordinate_frame": 1 if "LOCAL" in kind.msgname else 6,
        "lat_int": ORIGIN_LAT,
        "lon_int": ORIGIN_LON,
        "alt": 12.0,
        "command": 16,
        "autocontinue": 1,
        "base_mode": 1,
        "custom_mode": 50593792,
    }
    fields = zeros(kind)
    known = {name: value for name, value in at.items() if name in fields}
    if kind.msgname.startswith("SET_POSITION_TARGET"):
        known["z"] = -12.0
    if kind.msgname.startswith("MISSION_ITEM"):
        whole = kind.msgname.endswith("INT")
        known |= {"x": ORIGIN_LAT if whole else 47.3977, "y": ORIGIN_LON if whole else 8.5455, "z": 10.0}
    return {**fields, **{name: value for name, value in known.items() if name in fields}}


PLAIN_COMMANDS: dict[int, tuple[float, ...]] = {  # parameters with which a command could be meant; zeros otherwise
    22: (0, 0, 0, 0, 0, 0, 12.0),
    115: (30.0,),
    176: (1, 4, 3),
    178: (1, 3.0),
    192: (-1, 1, 0, math.nan, ORIGIN_LAT / 1e7, ORIGIN_LON / 1e7, 500.0),
    193: (1,),
    400: (1,),
    511: (32, 100000),
    512: (242,),
    510: (32,),
    31010: (1, 1, 6.0, 9.0),
}


def commands(aircraft: Aircraft) -> list[int]:
    """Those that the firmware does not call unsupported."""
    numbers = sorted(number for number in dialect.enums["MAV_CMD"] if number <= 0xFFFF)
    return [number for number in numbers if aircraft.copy().client().command(number) != UNSUPPORTED]


def changes(kind: Any, base: Fields) -> Iterator[tuple[str, str, Fields, Fields]]:
    """Field, what is in it, the whole message, and the message with 0 there."""
    for name, wire in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        if name in ADDRESS:
            continue
        for what, value in extremes(wire).items():
            if isinstance(base[name], list):
                places = range(len(base[name])) if wire == "float" else (0, len(base[name]) - 1)
                for i in places:
                    extreme, zero = ([*base[name][:i], x, *base[name][i + 1 :]] for x in (value, 0))
                    yield f"{name}[{i}]", what, {**base, name: extreme}, {**base, name: zero}
            else:
                yield name, what, {**base, name: value}, {**base, name: 0}


def cases(aircraft: Aircraft) -> Iterator[Case]:
    for number in understood():
        kind = dialect.mavlink_map[number]
        if number in (COMMAND_LONG, COMMAND_INT):
            for command in commands(aircraft):
                meant = PLAIN_COMMANDS.get(command, ())
                params = [*meant, *[0.0] * (7 - len(meant))]
                base = {**plain(kind, aircraft), "command": command}
                base |= {f"param{i}": params[i - 1] for i in range(1, 8) if f"param{i}" in base}
                if number == COMMAND_INT:
                    base |= {"x": ORIGIN_LAT, "y": ORIGIN_LON, "z": 12.0}
                for field, value, fields, zero in changes(kind, base):
                    if field != "command":
                        yield Case(kind.msgname, command, field, value, fields, base, zero)
        else:
            base = plain(kind, aircraft)
            for field, value, fields, zero in changes(kind, base):
                yield Case(kind.msgname, None, field, value, fields, base, zero)


@dataclass
class Outcome:
    """A quarter of a second after a message: the aircraft, and what was said to whom sent it."""

    aircraft: Aircraft
    answers: list[str]

    @property
    def refused(self) -> bool:
        """Whether anybody could know that something was not taken."""
        return any(
            said.split()[-1] not in ("0", "5") or said.startswith(("STATUSTEXT", "PARAM_ERROR"))
            for said in self.answers
        )

    def flies_as(self, other: Outcome) -> bool:
        """Bit for bit."""
        return bool(self.aircraft.world.same_state(other.aircraft.world))

    def same_as(self, other: Outcome) -> bool:
        return self.flies_as(other) and self.answers == other.answers


def said(message: Any) -> str | None:
    """An answer in short: its kind and its verdict last."""
    kind = str(message.get_type())
    if kind in ("COMMAND_ACK", "MISSION_ACK"):
        return f"{kind} {message.result if kind == 'COMMAND_ACK' else message.type}"
    if kind in ("STATUSTEXT", "PARAM_ERROR"):
        return f"{kind} {message.text if kind == 'STATUSTEXT' else message.error}"
    return f"{kind} 0" if kind in ANSWERS else None


def after(aircraft: Aircraft, message: str, fields: Fields | None, link: int) -> Outcome:
    """Of a copy that hears this message, or nothing."""
    twin = aircraft.copy()
    client = twin.client(link)
    if fields is not None:
        kind = next(kind for kind in dialect.mavlink_map.values() if kind.msgname == message)
        if message.startswith("MISSION_ITEM"):
            client.count(1)  # one that was not asked for says nothing
            client.heard.clear()
        twin.serve(client.pack(kind(*[fields[name] for name in kind.fieldnames])), link)
    twin.fly(FLOWN_S)
    twin.serve()
    return Outcome(twin, [words for _, m in client.heard if (words := said(m))])

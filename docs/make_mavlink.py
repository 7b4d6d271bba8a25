"""Write docs/mavlink.md: words from mavlink.md.in, tables from the firmware itself.

What the firmware does is asked of the firmware: the tables that it carries, each message's frame, each command's
answer. A command that it learns and nobody describes here stops this program.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from halfroll import _firmware

dialect: Any = importlib.import_module("halfroll._dialect")

WORDS = Path(__file__).with_name("mavlink.md.in")
UNSUPPORTED = 3


# What a command does. The numbers are the firmware's: one that it answers and that is missing here is an error.
COMMANDS = {
    20: "RTL",
    21: "land here",
    22: "climb to p7 above home (`--identity px4`: above sea level in COMMAND_LONG); before arming it waits for it",
    115: "turn to p1, or by p1 if p4 is 1; upright HOLD",
    176: "p2 main, p3 sub mode, or the whole custom_mode in p2",
    178: "p1 0/1 ground speed p2 of the on-board follower; -2 the default",
    179: "p1 1 here, 0 the given place",
    185: "p1 1: motors off until reboot",
    192: "fly there in HOLD; p2 bit 0 changes to HOLD; nothing given: stop",
    193: "p1 0 HOLD and remember, 1 go on with the mission",
    210: "p1 1 inverted, 0 upright; HOLD",
    224: "p1 item, p2 1: jump counters, too",
    241: "nothing to calibrate",
    245: "p1 1 save, 0 reload, 2 defaults",
    246: "p1 1 reboot, 2 shut down",
    262: "p1 standard mode",
    300: "MISSION, from item p1",
    400: "p1 1 arm, 0 disarm; p2 21196 forces",
    401: "says each failing arming check",
    410: "HOME_POSITION",
    510: "MESSAGE_INTERVAL of p1",
    511: "p1 message, p2 microseconds; 2500 is the least",
    512: "p1 message, p2 its index",
    520: "AUTOPILOT_VERSION",
    611: "GPS_GLOBAL_ORIGIN; disarmed",
    31010: "flip: p1 axis, p2 turns, p3 least height, p4 longest time; HOLD",
}
MISSION_ONLY = (16, 17, 19, 82, 93, 112, 177, 31000)


def table(heads: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    heads = list(heads)
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    lines += ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def command_name(number: int) -> str:
    entry = dialect.enums["MAV_CMD"].get(number)
    return str(entry.name).removeprefix("MAV_CMD_") if entry else str(number)


def answered_commands() -> Iterator[tuple[int, int]]:
    """Each command of the dialect, sent with all parameters 0 to an autopilot just booted, and its result."""
    setup = _firmware.vehicle_setup("mit-vp")
    fresh = _firmware.Autopilot(setup.vehicle, setup.params)
    fresh.step([0.0] * 3, [0.0, 0.0, 9.81])
    for number in sorted(dialect.enums["MAV_CMD"]):
        if number > 0xFFFF:
            continue
        autopilot, gcs, parser = fresh.copy(), dialect.MAVLink(None, 255, 190), dialect.MAVLink(None)
        frame = gcs.command_long_encode(1, 1, number, 0, *[0.0] * 7).pack(gcs)
        for _, _, sent in autopilot.service(frame, link=1):
            for message in parser.parse_buffer(bytes(sent)) or ():
                if message.get_type() == "COMMAND_ACK":
                    yield number, message.result


def command_rows() -> Iterator[tuple[object, ...]]:
    known = {number for number, result in answered_commands() if result != UNSUPPORTED} - set(MISSION_ONLY)
    if known != COMMANDS.keys():
        raise SystemExit(f"docs/make_mavlink.py: commands without words or without effect: {known ^ COMMANDS.keys()}")
    for number, words in COMMANDS.items():
        yield number, command_name(number), words


def understood_messages() -> list[str]:
    """Names of all messages whose frames say anything to the autopilot."""
    found = []
    gcs = dialect.MAVLink(None, 255, 190)
    for _, kind in sorted(dialect.mavlink_map.items()):
        fields = {name: default(kind, i) for i, name in enumerate(kind.fieldnames)}
        frame = kind(**fields).pack(gcs)
        if _firmware.understands(frame):
            found.append(kind.msgname)
    return found


def default(kind: Any, index: int) -> Any:
    """A one for each field: an all-zero payload is no frame."""
    count = kind.array_lengths[kind.ordered_fieldnames.index(kind.fieldnames[index])]
    if kind.fieldtypes[index] == "char":
        return b"A"
    return [1] * count if count else 1


def stream_rows() -> Iterator[tuple[object, ...]]:
    for row in _firmware.stream_table():
        yield dialect.mavlink_map[row["id"]].msgname, *(f"{rate:g}" for rate in row["rates_hz"])


def allowed(rule: tuple[float, float, bool, float]) -> str:
    least, most, nan, step = rule
    bounded = f"{least:g} … {most:g}" if most < 1e30 else f"≥ {least:g}" if least > -1e30 else "any"
    if least == most == 0.0:
        return "0 or NaN"
    if {0.0, 1.0} == {least, most} and step == 1.0:
        bounded = "0, 1"
    elif step == 1.0:
        bounded += ", whole"
    elif step:
        bounded += f", multiple of {step:g}"
    return bounded + (" or NaN" if nan else "")


def item_rows() -> Iterator[tuple[object, ...]]:
    for row in _firmware.mission_item_table():
        if all(rule == row["params"][0] and allowed(rule) == "any or NaN" for rule in row["params"]) and row["skipped"]:
            continue
        name = f"{command_name(row['command'])} ({row['command']})"
        yield name, *(allowed(rule) for rule in row["params"]), "passed over" if row["skipped"] else "flown"


def passed_over() -> str:
    """Items that are stored and do nothing, whatever their parameters."""
    numbers = [
        f"{row['command']}"
        for row in _firmware.mission_item_table()
        if row["skipped"] and all(allowed(rule) == "any or NaN" for rule in row["params"])
    ]
    return ", ".join(numbers)


def mode_rows() -> Iterator[tuple[object, ...]]:
    for row in _firmware.mode_table():
        main, sub = row["custom_mode"] >> 16 & 0xFF, row["custom_mode"] >> 24
        yield row["name"], f"{main}/{sub}", row["custom_mode"], row["standard_mode"] or ""


def rule_rows() -> Iterator[tuple[object, ...]]:
    for rule in _firmware.mode_rule_table():
        everything = len(_firmware.mode_table())
        shown = [", ".join(names) if len(names) < everything else "any" for names in (rule["from"], rule["to"])]
        yield rule["who"], *shown, rule["when"], rule["why"]


def failsafe_rows() -> Iterator[tuple[object, ...]]:
    for row in _firmware.failsafe_table():
        yield row["condition"], row["action"], row["recovery"], row["words"]


def text() -> str:
    parts = {
        "modes": table(["mode", "main/sub", "custom_mode", "standard mode"], mode_rows()),
        "mode rules": table(["asked by", "from", "to", "when", "reason"], rule_rows()),
        "failsafes": table(["condition", "action", "over when", "words"], failsafe_rows()),
        "mission only": ", ".join(str(number) for number in MISSION_ONLY),
        "commands": table(["number", "command", "effect"], command_rows()),
        "messages": ", ".join(understood_messages()),
        "streams": table(["message", "A [Hz]", "B [Hz]", "C [Hz]"], stream_rows()),
        "items": table(["item", "p1", "p2", "p3", "p4", "on board"], item_rows()),
        "passed over": passed_over(),
    }
    return re.sub(r"\{\{([^}]+)\}\}", lambda place: parts[place.group(1)], WORDS.read_text())


if __name__ == "__main__":
    Path(__file__).with_name("mavlink.md").write_text(text())

"""What can go wrong, for people: which item, which value, which limit, what to do.

Why: one tree, mapped to exit codes and JSON in one place (cli.py). Third-party exceptions are turned into these at
the edge where they arise.

HalfrollError
├── InputError            exit 2   bad mission, vehicle, option or file
│   ├── MissionError               one mission item is the reason
│   ├── VehicleError
│   └── ScenarioError
├── PlanError             exit 1   good input, but no trajectory inside the limits
│   └── InfeasibleSegment
├── FlightError           exit 1   flown, but not within limits or not to the end
└── LinkError             exit 3   link or process failure
    ├── PortInUse
    └── SimulatorDied
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_LONGEST = 1500  # of a message, in characters


def _readable(message: str) -> str:
    """What a file says may be quoted in it: no command to a terminal, and no page of digits."""
    if len(message) > _LONGEST:
        message = f"{message[: _LONGEST - 400]} … {message[-400:]}"
    if message.isprintable():
        return message
    return "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in message)


class HalfrollError(Exception):
    """Base of all errors halfroll raises on purpose. `kind` is the stable name in JSON.

    files: what was left all the same, by name.
    """

    exit_code = 2
    kind = "error"

    def __init__(self, message: str, item: int | None = None) -> None:
        super().__init__(_readable(message))
        self.item = item
        self.files: Mapping[str, str] = {}

    def as_json(self) -> dict[str, Any]:
        """For programs: what every object says that tells of it."""
        about: dict[str, str | int] = {"kind": self.kind, "message": str(self)}
        return {"error": about if self.item is None else {**about, "item": self.item}, **self.files}


class InputError(HalfrollError):
    kind = "input"


class MissionError(InputError):
    """`item` is the sequence number of the mission item that is the reason, if one is."""

    kind = "mission"


class VehicleError(InputError):
    kind = "vehicle"


class ScenarioError(InputError):
    kind = "scenario"


class PlanError(HalfrollError):
    exit_code = 1
    kind = "plan"


class InfeasibleSegment(PlanError):
    kind = "infeasible"


class FlightError(HalfrollError):
    exit_code = 1
    kind = "flight"


class LinkError(HalfrollError):
    exit_code = 3
    kind = "link"


class PortInUse(LinkError):
    kind = "port"


class SimulatorDied(LinkError):
    kind = "simulator"

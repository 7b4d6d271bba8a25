"""A flight as its log tells it: what was asked, planned and flown, and how it ended.

Why: report, info, figures and comparison need nothing but the log, whoever flew, and however the flight ended.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from halfroll.errors import HalfrollError, InputError
from halfroll.planner.plan import Plan
from halfroll.reading import parse_json
from halfroll.results.evaluation import FlightFigures, evaluate
from halfroll.results.log import Log
from halfroll.vehicle import Vehicle

SEVERE = 3  # syslog: errors and worse
WORTH_SAYING = 4  # warnings


@dataclass(frozen=True)
class LoggedFlight:
    """plan and start_s (vehicle time) are None where none was made, or flown; vehicle, where the log does not name it.

    figures: of the planned part; None without one. outcome: as the ground station left it, empty if it left nothing.
    """

    log: Log
    mission: str
    command: str | None
    plan: Plan | None
    start_s: float | None
    vehicle: Vehicle | None
    figures: FlightFigures | None
    outcome: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, log: Log) -> LoggedFlight:
        """Raises InputError for a plan, a vehicle or an outcome in it that cannot be read."""
        kept = log.embedded
        plan = Plan.of_json(kept["plan"], f"the plan in {log.path}") if "plan" in kept else None
        start_s = float(log.info["plan_start_s"]) if plan is not None and "plan_start_s" in log.info else None
        vehicle = plan.vehicle if plan is not None else _vehicle(log)
        figures = None
        if plan is not None and start_s is not None and vehicle is not None and start_s < log["vehicle_truth"].t[-1]:
            figures = evaluate(plan, start_s, log, vehicle)
        name = kept.get("mission", log.path.stem)
        return cls(log, name, kept.get("command"), plan, start_s, vehicle, figures, _outcome(log))

    @property
    def error(self) -> str | None:
        """What ended it before its time."""
        error = self.outcome.get("error")
        return str(error["message"]) if error else None

    @property
    def verdict(self) -> Verdict:
        return _verdict(self)


@dataclass(frozen=True)
class Verdict:
    """One line, and why, for the first thing a reader sees. causes: the first is the nearest to the root."""

    good: bool
    line: str
    causes: tuple[str, ...] = ()


def _verdict(flight: LoggedFlight) -> Verdict:
    said = [text for text in flight.log.texts if text.severity <= WORTH_SAYING]
    severe = [f"{text.t_s:.2f} s: {text.text}" for text in said if text.severity <= SEVERE]
    told = severe or [f"{text.t_s:.2f} s: {text.text}" for text in said]
    broken = () if flight.figures is None else tuple(c for c in flight.figures.checks if not c.holds)
    measured = [f"{check.what}: {check.got}, allowed {check.allowed}" for check in broken]
    crashed = next((text.text for text in flight.log.texts if text.text.startswith("crashed at")), None)
    ended = "commands_sha256" in flight.log.info
    if crashed is not None:
        first = [cause for cause in told if crashed not in cause]
        return Verdict(False, f"Crashed: {crashed}", _distinct([*first[:2], *_why(flight), *measured]))
    if flight.error is not None:
        return Verdict(False, f"Failed: {flight.error}", _distinct([*told[:3], *measured]))
    if broken:
        return Verdict(False, f"Out of limits: {measured[0]}", _distinct([*told[:3], *measured[1:]]))
    if not ended:
        last = flight.log["vehicle_truth"].t[-1]
        return Verdict(False, f"The log ends at {last:.2f} s in flight: the simulator was killed", tuple(told[:3]))
    if flight.figures is not None:
        return Verdict(True, "Flown within limits")
    if flight.plan is not None:
        return Verdict(False, "The plan was not flown: the autopilot flew the mission alone", tuple(told[:3]))
    flew = bool(np.any(flight.log["vehicle_state"]["armed"])) if "vehicle_state" in flight.log else True
    if not flew:
        return Verdict(False, "It never flew", tuple(told[:3]))
    return Verdict(not severe, "Flown without a plan", tuple(told[:3]))


def _why(flight: LoggedFlight) -> list[str]:
    return [] if flight.error is None else [flight.error]


def _distinct(causes: list[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(causes))


def _vehicle(log: Log) -> Vehicle | None:
    text = log.embedded.get("vehicle_numbers")
    if text is None:
        return None
    try:
        return Vehicle.model_validate_json(text)
    except ValueError as error:
        raise InputError(f"{log.path}: the vehicle in it cannot be read ({error})") from None


def _outcome(log: Log) -> dict[str, Any]:
    text = log.embedded.get("outcome")
    if not text:
        return {}
    try:
        return dict(parse_json(text))
    except (ValueError, TypeError) as error:
        raise InputError(f"{log.path}: the outcome in it cannot be read ({error})") from None


def require_flight(log: Log) -> LoggedFlight:
    """As LoggedFlight.of, for what is drawn and judged: raises InputError for a log without the simulator's truth."""
    if "vehicle_truth" not in log:
        raise InputError(
            f"{log.path}: no simulated flight (it has no vehicle_truth); only logs of halfroll-sitl have one"
        )
    try:
        return LoggedFlight.of(log)
    except HalfrollError:
        raise
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{log.path}: what it says about the flight is damaged ({error})") from None

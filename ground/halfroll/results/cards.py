"""Missions, plans and flights as a notebook shows them: a few figures and a picture.

Why: the values themselves know nothing of pictures; each asks here, once somebody looks at it.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from halfroll.drawing import inline_picture
from halfroll.errors import InputError
from halfroll.missions.mission_items import command_name
from halfroll.results.evaluation import evaluate
from halfroll.results.log import read_log
from halfroll.results.logged_flight import LoggedFlight
from halfroll.results.pictures import overview

if TYPE_CHECKING:
    from halfroll.flight import FlightResult
    from halfroll.missions.mission import Mission
    from halfroll.planner.plan import Plan


def mission_card(mission: Mission) -> str:
    rows = [
        (number, command_name(item.command), *(f"{x:g}" for x in item.params), f"{item.z:g}")
        for number, item in enumerate(mission.items)
    ]
    notes = "".join(f"<div>{html.escape(note)}</div>" for note in mission.warnings)
    title = f"{mission.name}: {len(mission.items)} items"
    return _titled(title, _table(("item", "command", "p1", "p2", "p3", "p4", "up, m"), rows) + notes)


def plan_card(plan: Plan) -> str:
    limits = plan.vehicle.rotor
    verdict = "inside the limits at every time" if plan.certified else f"over the limits by {plan.violation_N:.3f} N"
    rows = [
        ("duration", f"{plan.T:.3f} s, mode {plan.mode}, {len(plan.waypoints)} waypoints"),
        ("rotors", f"{min(plan.rotor_min):.2f} … {max(plan.rotor_max):.2f} N"),
        ("may be", f"{limits.thrust_min_N:g} … {limits.thrust_max_N:g} N: {verdict}"),
    ]
    notes = "".join(f"<div>{html.escape(note)}</div>" for note in plan.warnings)
    return _titled(f"plan for {plan.vehicle.name}", _table((), rows) + notes + inline_picture(plan.plot()))


def flight_card(flight: FlightResult) -> str:
    if flight.plan is None or flight.plan_start_s is None:
        rows: list[tuple[str, str]] = [("flown", "by the autopilot alone"), ("log", str(flight.log_path))]
        return _titled(f"{flight.mission.name}, {flight.vehicle.name}", _table((), rows))
    figures = evaluate(flight.plan, flight.plan_start_s, read_log(flight.log_path), flight.vehicle)
    failed = [f"{check.what} {check.got}, allowed {check.allowed}" for check in figures.checks if not check.holds]
    rows = [
        ("verdict", "flown within limits" if not failed else "out of limits: " + "; ".join(failed)),
        ("duration", f"{figures.T_flown_s:.2f} s of {figures.T_planned_s:.2f} s planned"),
        ("tracking error", f"{1e3 * figures.tracking_rms_m:.1f} mm RMS, {1e3 * figures.tracking_max_m:.1f} mm largest"),
        ("waypoints", f"missed by {1e3 * figures.waypoint_miss_max_m:.1f} mm at most"),
        ("log", str(flight.log_path)),
    ]
    title = f"{flight.mission.name}, {flight.vehicle.name}"
    return _titled(title, _table((), rows) + inline_picture(picture_of(flight)))


def picture_of(flight: FlightResult) -> Any:
    """A matplotlib figure. Raises InputError for a flight without a plan."""
    if flight.plan is None or flight.plan_start_s is None:
        raise InputError("the autopilot flew alone: there is no plan to draw the flight beside")
    return overview(LoggedFlight.of(read_log(flight.log_path)))


def _titled(title: str, inside: str) -> str:
    return f"<div><b>{html.escape(title)}</b>{inside}</div>"


def _table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    top = "".join(f"<th>{html.escape(name)}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{f'<tr>{top}</tr>' if head else ''}{body}</table>"

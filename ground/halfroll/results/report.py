"""The report of a flight: verdict and cause, figures and pictures, as one HTML page and as a PDF.

Why: a flight is judged by its log alone, so a flight that failed is reported as one that did not.
"""

from __future__ import annotations

import html
import platform
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata, resources
from pathlib import Path
from string import Template
from typing import Any

import halfroll
from halfroll.results.evaluation import FlightFigures, waypoints
from halfroll.results.logged_flight import LoggedFlight
from halfroll.results.pictures import page_pictures

Row = tuple[str, ...]
_MOST_TEXTS = 60


def report_json(flight: LoggedFlight) -> dict[str, Any]:
    """The numbers of the report, for programs."""
    plan, verdict, figures = flight.plan, flight.verdict, flight.figures
    return {
        "mission": flight.mission,
        "good": verdict.good,
        "verdict": verdict.line,
        "causes": list(verdict.causes),
        "plan": None
        if plan is None
        else {
            "T_s": plan.T,
            "mode": plan.mode,
            "times_s": list(plan.times_s),
            "certified": plan.certified,
            "violation_N": plan.violation_N,
            "rotor_min_N": list(plan.rotor_min),
            "rotor_max_N": list(plan.rotor_max),
        },
        "flown": None if figures is None else figures.as_json(),
        "failed": [] if figures is None else [c.what for c in figures.checks if not c.holds],
        "link": {name: flight.outcome[name] for name in LINK_FIGURES if name in flight.outcome},
        "commands_sha256": flight.log.info.get("commands_sha256"),
        "log": str(flight.log.path),
    }


LINK_FIGURES = ("references_sent", "rate_by_vehicle_Hz", "rate_by_wall_Hz", "interval_p99_s")


def write_report(
    path: str | Path, flight: LoggedFlight, facts: Mapping[str, str] | None = None, replay: str | None = None
) -> None:
    """One HTML file that needs nothing else: verdict and cause, what was asked, planned and flown, pictures.

    facts: more rows for the last table; replay: where it lies, seen from here. Raises OSError.
    """
    verdict, figures, plan = flight.verdict, flight.figures, flight.plan
    sections = [
        _section("Limits", "", _table(("condition", "measured", "allowed", ""), limit_rows(figures)))
        if figures is not None
        else "",
        _section("Asked", "", _table((), asked_rows(flight))),
        _section("Planned", "", _table((), planned_rows(flight))) if plan is not None else "",
        _section("Link", "", _table((), link_rows(flight))) if link_rows(flight) else "",
    ]
    said = [(f"{text.t_s:.2f} s", text.text) for text in flight.log.texts]
    page = Template(resources.files("halfroll.results").joinpath("report.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(f"{flight.mission}: {verdict.line}"),
        mission=html.escape(flight.mission),
        replay="" if replay is None else f'<a href="{html.escape(replay)}">see it fly</a>',
        verdict=("✓ " if verdict.good else "✗ ") + html.escape(verdict.line),
        verdict_class="good" if verdict.good else "bad",
        causes="".join(f"<li>{html.escape(cause)}</li>" for cause in verdict.causes),
        tiles="".join(_tile(*tile) for tile in headlines(flight)),
        sections="".join(sections),
        path_note="True position in the simulator"
        + (" against the plan. Red ticks point along body up; waypoints are numbered." if plan is not None else "."),
        waypoints=_table(("#", "due", "north, west, up [m]", "miss"), waypoint_rows(flight)),
        rotors=_table(("rotor", "least", "most"), rotor_rows(figures)),
        texts=_table(("time", "said"), said[:_MOST_TEXTS]),
        made_by="".join(_row(name, html.escape(fact)) for name, fact in made_rows(flight, facts)),
        **page_pictures(flight),
    )
    Path(path).write_text(page, encoding="utf-8")


def headlines(flight: LoggedFlight) -> list[tuple[str, str, str]]:
    """Label, figure, unit of what is read first."""
    figures, truth = flight.figures, flight.log["vehicle_truth"]
    if figures is None:
        return [
            ("logged", f"{truth.t[-1] - truth.t[0]:.1f}", "s"),
            ("highest", f"{truth['p'][:, 2].max():.2f}", "m"),
            ("farthest from take-off", f"{max((truth['p'][:, :2] ** 2).sum(axis=1)) ** 0.5:.2f}", "m"),
        ]
    return [
        ("planned", f"{figures.T_planned_s:.2f}", "s"),
        ("flown", f"{figures.T_flown_s:.2f}", "s"),
        ("tracking, RMS", *_length(figures.tracking_rms_m)),
        ("tracking, worst", *_length(figures.tracking_max_m)),
        ("waypoint missed by", *_length(figures.waypoint_miss_max_m)),
        ("rotor at a limit", f"{figures.rotor_saturated * 100:.1f}", "%"),
        ("arm to disarm", f"{figures.flight_s:.1f}", "s"),
    ]


def limit_rows(figures: FlightFigures | None) -> list[Row]:
    checks = () if figures is None else figures.checks
    return [(check.what, check.got, check.allowed, "✓" if check.holds else "✗") for check in checks]


def asked_rows(flight: LoggedFlight) -> list[Row]:
    info = flight.log.info
    return [
        ("mission", flight.mission),
        ("vehicle", str(info.get("vehicle", "–")) if flight.vehicle is None else flight.vehicle.name),
        ("scenario", f"{info.get('scenario', '–')}, seed {info.get('seed', '–')}"),
    ]


def planned_rows(flight: LoggedFlight) -> list[Row]:
    """Times, limits and certificate."""
    plan = flight.plan
    if plan is None:
        return []
    rotor = plan.vehicle.rotor
    proven = (
        "proven inside the rotor limits between samples, too" if plan.certified else f"over by {plan.violation_N:.3f} N"
    )
    return [
        ("time", f"{plan.T:.3f} s, mode {plan.mode}, {len(plan.waypoints)} waypoints"),
        ("certificate", proven),
        ("rotor thrust", f"{min(plan.rotor_min):.2f} … {max(plan.rotor_max):.2f} N"),
        ("rotor limits", f"{rotor.thrust_min_N:.2f} … {rotor.thrust_max_N:.2f} N"),
        *(("note", warning) for warning in plan.warnings),
    ]


def link_rows(flight: LoggedFlight) -> list[Row]:
    told = flight.outcome
    if not told.get("references_sent"):
        return []
    return [
        ("references sent", str(told["references_sent"])),
        ("rate, vehicle time", f"{told['rate_by_vehicle_Hz']:.2f} a second"),
        ("rate, wall clock", f"{told['rate_by_wall_Hz']:.2f} a second"),
        ("99 % of intervals within", f"{told['interval_p99_s'] * 1e3:.2f} ms of wall clock"),
    ]


def waypoint_rows(flight: LoggedFlight) -> list[Row]:
    plan, figures = flight.plan, flight.figures
    if plan is None:
        return []
    misses = (
        ["–"] * len(plan.times_s) if figures is None else [f"{miss * 1e3:.0f} mm" for miss in figures.waypoint_miss_m]
    )
    rows = zip(plan.times_s, waypoints(plan), misses, strict=True)
    return [
        (str(number), f"{due:.2f} s", ", ".join(f"{x:.2f}" for x in point), miss)
        for number, (due, point, miss) in enumerate(rows, start=1)
    ]


def rotor_rows(figures: FlightFigures | None) -> list[Row]:
    if figures is None:
        return []
    extremes = zip(figures.rotor_min_N, figures.rotor_max_N, strict=True)
    return [(str(number), f"{low:.2f} N", f"{high:.2f} N") for number, (low, high) in enumerate(extremes, start=1)]


def made_rows(flight: LoggedFlight, facts: Mapping[str, str] | None = None) -> Iterator[tuple[str, str]]:
    info = flight.log.info
    yield "command", flight.command or "–"
    yield from (facts or {}).items()
    yield "fly it again", f"halfroll log replay {flight.log.path}"
    yield "rotor commands, SHA-256", str(info.get("commands_sha256", "– (the log ends early)"))
    yield "simulator", f"halfroll {info.get('ver_halfroll', '–')}, commit {info.get('ver_sw', '–')}"
    yield "report", versions()


def versions() -> str:
    found = [f"halfroll {halfroll.__version__}"]
    found += [f"{name} {metadata.version(name)}" for name in ("numpy", "scipy", "pymavlink")]
    return ", ".join([*found, f"Python {platform.python_version()}", f"{platform.system()} {platform.machine()}"])


def _section(heading: str, note: str, content: str) -> str:
    return f"<section><h2>{heading}</h2>{f'<p>{note}</p>' if note else ''}{content}</section>"


def _table(heads: Row, rows: Sequence[Row]) -> str:
    if not rows:
        return "<p>–</p>"
    head = "<tr>" + "".join(f"<th>{head}</th>" for head in heads) + "</tr>" if heads else ""
    return f"<table>{head}{''.join(_row(*(html.escape(cell) for cell in row)) for row in rows)}</table>"


def _length(metres: float) -> tuple[str, str]:
    """Figure and unit, as one would say it."""
    return (f"{metres:.2f}", "m") if metres >= 1.0 else (f"{1e3 * metres:.0f}", "mm")


def _tile(label: str, value: str, unit: str) -> str:
    return f'<div class="tile"><b>{value}<small> {unit}</small></b><span>{label}</span></div>'


def _row(*cells: str) -> str:
    return "<tr>" + "".join(f"<td{_MARKS.get(cell, '')}>{cell}</td>" for cell in cells) + "</tr>"


_MARKS = {"✓": ' class="good"', "✗": ' class="bad"'}

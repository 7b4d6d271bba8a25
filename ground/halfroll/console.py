"""What a person sees of the commands, and what a program reads. Why: the only module that knows Rich, so that every
command speaks alike. Results go to standard output, progress to standard error.
"""

from __future__ import annotations

import contextlib
import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from halfroll.missions.mission_items import command_name
from halfroll.paper.claims import shown

if TYPE_CHECKING:
    from halfroll.flight import FlightResult
    from halfroll.paper.claims import Claim
    from halfroll.planner.plan import Plan
    from halfroll.preflight import Preflight
    from halfroll.replay import Replayed
    from halfroll.results.evaluation import FlightFigures
    from halfroll.results.flight_files import FlightFiles
    from halfroll.vehicle import Vehicle


def console(stderr: bool = False) -> Console:
    """As wide as the terminal; where there is none, wide enough not to fold a table."""
    return Console(stderr=stderr, width=None if (sys.stderr if stderr else sys.stdout).isatty() else 120)


def show_check(found: Preflight) -> None:
    out = console()
    table = Table("item", "command", "", title=found.mission.name, title_justify="left", box=None)
    for i, item in enumerate(found.mission.items):
        mine = [finding for finding in found.findings if finding.index == i]
        words = Text("\n").join(
            Text(f"{finding.severity.value}: {finding.why}", "red" if finding.is_error else "dim") for finding in mine
        )
        table.add_row(str(i), command_name(item.command), words)
    out.print(table)
    for sentence in (*found.added, *found.warnings):
        out.print(Text(f"note: {sentence}", "yellow"))
    if found.plan is not None:
        show_plan(found.plan)
    elif found.supported and found.no_plan is None:
        out.print("Nothing to plan: the autopilot flies this mission alone.")


def show_plan(made: Plan) -> None:
    out = console()
    table = Table("waypoint", "due, s", "north, m", "west, m", "up, m", box=None, title_justify="left")
    for column in table.columns:
        column.justify = "right"
    for number, (due, waypoint) in enumerate(zip(made.times_s, made.waypoints, strict=True), start=1):
        table.add_row(str(number), f"{due:.3f}", *(_hundredths(x) for x in waypoint.position))
    out.print(table)
    verdict = "inside the limits" if made.certified else f"[red]over the limits by {made.violation_N:.3f} N[/red]"
    used, allowed = _range(made.rotor_min, made.rotor_max), _rotor_limits(made.vehicle)
    out.print(
        f"{made.vehicle.name}: [bold]T = {made.T:.3f} s[/bold], {verdict}; rotors {used} of {allowed}", highlight=False
    )
    for warning in made.warnings:
        out.print(f"note: {warning}", style="yellow", markup=False, highlight=False)


def show_flight(flown: FlightResult, figures: FlightFigures | None, files: FlightFiles, real_time: bool) -> None:
    out = console()
    for note in flown.notes:
        out.print(Text(f"note: {note}", "yellow"))
    if figures is None:
        out.print(Text("flown by the autopilot alone: there was nothing to plan", "bold green"))
        for name, path in (("log", files.log), ("report", files.report)):
            out.print(Text(f"{name:7}{path}"), soft_wrap=True)
        return
    table = Table("", "", "", box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, measured, beside in _flight_rows(flown, figures, real_time):
        table.add_row(Text(name, "dim"), Text(measured, "bold"), Text(beside, "dim"))
    out.print(table)
    for check in figures.checks:
        if not check.holds:
            out.print(Text(f"out of limits: {check.what} {check.got}, allowed {check.allowed}", "red"))
    if figures.within_limits:
        out.print(Text("flown within limits", "bold green"))
    for name, path in (("log", files.log), ("report", files.report)):
        out.print(Text(f"{name:7}{path}"), soft_wrap=True)


def show_replay(again: Replayed, differs_s: float | None, first: Mapping[str, Any], second: Mapping[str, Any]) -> None:
    out = console()
    out.print(Text(f"flew {again.flown_s:.3f} s again, commands {again.commands_sha256}"), soft_wrap=True)
    if differs_s is None:
        out.print(Text("every rotor command is equal in every bit", "bold green"))
    else:
        out.print(Text(f"rotor commands differ from {differs_s:.3f} s on", "bold red"))
        commits = [str(info.get("ver_sw"))[:12] for info in (first, second)]
        if commits[0] != commits[1]:
            out.print(
                Text(f"the log is of commit {commits[0]}, this is {commits[1]}: they may fly otherwise", "yellow")
            )
    out.print(Text(f"log    {again.log}"), soft_wrap=True)


def show_claims(claims: Sequence[Claim], folder: Path) -> None:
    out = console()
    table = Table("", "claim", "paper", "here", "tolerance", "", box=None)
    for claim in claims:
        mark = Text("holds", "green") if claim.holds else Text("fails", "bold red")
        what = Text(claim.what) if claim.holds or not claim.note else Text(f"{claim.what} ({claim.note})")
        here = Text(f"{shown(claim.got)} {claim.unit}".rstrip(), "bold")
        table.add_row(claim.id, what, shown(claim.paper), here, Text(claim.tolerance, "dim"), mark)
    out.print(table)
    failed = [claim.id for claim in claims if not claim.holds]
    verdict = f"all {len(claims)} claims hold" if not failed else f"{', '.join(failed)}: not within tolerance"
    out.print(Text(verdict, "bold red" if failed else "bold green"))
    out.print(Text(f"pictures {folder / 'README.md'}"), soft_wrap=True)


def claims_json(claims: Sequence[Claim]) -> dict[str, Any]:
    return {"claims": [asdict(claim) for claim in claims]}


def _flight_rows(flown: FlightResult, figures: FlightFigures, real_time: bool) -> list[tuple[str, str, str]]:
    """Name, figure, and what it may be or means."""
    rows = [
        ("time, planned", f"{figures.T_planned_s:.3f} s", ""),
        ("time, flown", f"{figures.T_flown_s:.3f} s", f"arm to disarm {figures.flight_s:.1f} s"),
        ("tracking error, RMS", f"{figures.tracking_rms_m * 1e3:.1f} mm", ""),
        ("tracking error, largest", f"{figures.tracking_max_m * 1e3:.1f} mm", ""),
        ("largest waypoint miss", f"{figures.waypoint_miss_max_m * 1e3:.1f} mm", ""),
        ("rotor commands", _range(figures.rotor_min_N, figures.rotor_max_N), f"limits {_rotor_limits(flown.vehicle)}"),
        ("references sent", f"{flown.references_sent}", f"{flown.reference_rate_Hz:.2f} per second"),
    ]
    if flown.board is not None:
        board = flown.board
        bits = f"{board['differing_bits']} bits differ" if board["compared"] else "not compared"
        rows.append(("steps on the board", f"{board['steps']}", bits))
        if board["worst_instructions"]:
            median, worst = board["median_instructions"], board["worst_instructions"]
            rows.append(("instructions a step", f"{median}", f"at most {worst}"))
    if real_time:
        rows.append(("99 % of intervals within", f"{flown.interval_p99_s * 1e3:.1f} ms", "10 ms wanted"))
    return rows


def _hundredths(x: float) -> str:
    return f"{round(x, 2) + 0.0:.2f}"  # never -0.00


def _range(low: Sequence[float], high: Sequence[float]) -> str:
    return f"{_hundredths(min(low))} … {_hundredths(max(high))} N"


def _rotor_limits(vehicle: Vehicle) -> str:
    return _range([vehicle.rotor.thrust_min_N], [vehicle.rotor.thrust_max_N])


@contextlib.contextmanager
def status(what: str) -> Iterator[Callable[[str], None]]:
    """A line on standard error that says what is going on."""
    out = console(stderr=True)
    with out.status(what) as line:
        yield lambda said: line.update(Text(f"{what}: {said}"))


@contextlib.contextmanager
def phases() -> Iterator[Callable[[str, float | None], None]]:
    """Progress of many parts on standard error: a bar on a terminal, a line a phase elsewhere."""
    out = console(stderr=True)
    if not out.is_terminal:
        yield one_line_a_phase()
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=out) as progress:
        tasks: dict[str, Any] = {}

        def said(phase: str, fraction: float | None) -> None:
            if phase not in tasks:
                for task in tasks.values():
                    progress.update(task, total=1.0, completed=1.0)
                    progress.stop_task(task)
                tasks[phase] = progress.add_task(phase, total=None if fraction is None else 1.0)
            if fraction is not None:
                progress.update(tasks[phase], total=1.0, completed=fraction)

        yield said
        for task in tasks.values():
            progress.update(task, total=1.0, completed=1.0)


def one_line_a_phase() -> Callable[[str, float | None], None]:
    """Progress of a flight on standard error where there is no terminal."""
    seen: list[str] = []

    def said(phase: str, fraction: float | None) -> None:
        if phase not in seen[-1:]:
            seen.append(phase)
            print(phase, file=sys.stderr, flush=True)

    return said


# For programs.


def print_json(outcome: Mapping[str, Any]) -> None:
    print(json.dumps(_finite(outcome), allow_nan=False))


def _finite(value: Any) -> Any:
    """JSON knows no NaN and no infinity; numpy's numbers become Python's."""
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value.item() if hasattr(value, "item") else value


def check_json(found: Preflight) -> dict[str, Any]:
    notes: dict[int, list[str]] = {}
    for finding in found.findings:
        notes.setdefault(finding.index, []).append(finding.why)
    return {
        "mission": str(found.mission.source or found.mission.name),
        "vehicle": found.vehicle.name,
        "supported": found.supported,
        "items": [
            {"index": i, "command": item.command, "name": command_name(item.command), "notes": notes.get(i, [])}
            for i, item in enumerate(found.mission.items)
        ],
        "unsupported": [{"index": f.index, "command": f.command, "why": f.why} for f in found.refusals],
        "added": list(found.added),
        "warnings": list(found.warnings),
        "T_s": found.plan.T if found.plan else None,
        "rotor_min_N": list(found.plan.rotor_min) if found.plan else None,
        "rotor_max_N": list(found.plan.rotor_max) if found.plan else None,
    }


def plan_json(made: Plan, mission: str, solve_s: float) -> dict[str, Any]:
    return {
        "mission": mission,
        "vehicle": made.vehicle.name,
        "mode": made.mode,
        "waypoints": len(made.waypoints),
        "T_s": made.T,
        "times_s": list(made.times_s),
        "rotor_min_N": list(made.rotor_min),
        "rotor_max_N": list(made.rotor_max),
        "certified": made.certified,
        "violation_N": made.violation_N,
        "solve_s": solve_s,
        "warnings": list(made.warnings),
    }

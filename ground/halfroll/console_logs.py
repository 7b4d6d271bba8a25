"""What a person sees of logs. Why: tables of `halfroll log`, apart from those of flights that are just flown."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table
from rich.text import Text

from halfroll.console import console
from halfroll.results.comparison import Comparison
from halfroll.results.log_facts import LogFacts
from halfroll.results.logged_flight import LoggedFlight

_SEVERITIES = ("emergency", "alert", "critical", "error", "warning", "notice", "info", "debug")
_WARNING = 4


def show_verdict(flight: LoggedFlight) -> None:
    out, verdict = console(), flight.verdict
    out.print(Text(verdict.line, "bold green" if verdict.good else "bold red"))
    for cause in verdict.causes:
        out.print(Text(f"  {cause}"))


def show_facts(found: LogFacts) -> None:
    out, log = console(), found.flight.log
    info = log.info
    show_verdict(found.flight)
    end = "" if found.complete else ", not closed by its writer"
    out.print(
        Text(
            f"{log.path}: {found.duration_s:.2f} s, {found.bytes / 1e6:.1f} MB{end}; mission {found.flight.mission}, "
            f"vehicle {info.get('vehicle', '–')}, scenario {info.get('scenario', '–')}, seed {info.get('seed', '–')}, "
            f"halfroll {info.get('ver_halfroll', '–')}, commit {str(info.get('ver_sw', '–'))[:12]}"
        ),
        soft_wrap=True,
    )
    table = Table("topic", "samples", "a second", "from, s", "to, s", "longest gap, ms", "gaps", box=None)
    for column in table.columns[1:]:
        column.justify = "right"
    for topic in found.topics:
        gaps = "–" if topic.gaps is None else str(topic.gaps)
        table.add_row(
            topic.name,
            str(topic.samples),
            f"{topic.rate_hz:.1f}",
            f"{topic.first_s:.2f}",
            f"{topic.last_s:.2f}",
            f"{topic.longest_interval_s * 1e3:.0f}",
            Text(gaps, "bold red" if topic.gaps else ""),
        )
    out.print(table)
    for text in log.texts:
        word = _SEVERITIES[text.severity] if text.severity < len(_SEVERITIES) else str(text.severity)
        out.print(Text(f"{text.t_s:9.2f} s  {word:9} {text.text}", "red" if text.severity <= _WARNING else "dim"))
    if log.embedded:
        out.print(Text(f"kept in it: {', '.join(sorted(log.embedded))}"))


def show_comparison(found: Comparison) -> None:
    out = console()
    for flight in found.flights:
        out.print(Text(str(flight.log.path), "bold"), soft_wrap=True)
        show_verdict(flight)
    table = Table("", "first", "second", "difference", "", box=None)
    for column in table.columns[1:4]:
        column.justify = "right"
    for figure in found.figures:
        numbers = (figure.first, figure.second, figure.difference)
        table.add_row(figure.name, *("–" if x is None else f"{x:.3f}" for x in numbers), figure.unit)
    out.print(table)
    for name, first, second in found.parameters:
        out.print(Text(f"{name}: {first} and {second}", "yellow"))
    out.print(Text(f"apart by {found.apart_rms_m * 1e3:.1f} mm RMS, {found.apart_max_m * 1e3:.1f} mm at most"))
    same = "every rotor command is equal in every bit"
    out.print(Text(same if found.same_commands else f"rotor commands differ from {found.same_until_s:.3f} s on"))


def show_files(files: list[Path]) -> None:
    for file in files:
        console().print(Text(str(file)), soft_wrap=True)

"""The report as a PDF, drawn without a browser.

Why: what is sent and printed; the same rows and pictures as the page.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from halfroll.drawing import ON_PAPER, style
from halfroll.results import report
from halfroll.results.logged_flight import LoggedFlight
from halfroll.results.pictures import drawings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PAGE = (8.27, 11.69)  # A4, inch
_LEFT, _TOP, _LINE = 0.07, 0.95, 0.0165  # of the page
_GOOD, _BAD = "#15803d", ON_PAPER.alert
_ON_FIRST_PAGE = 12  # waypoints


def write_pdf(path: str | Path, flight: LoggedFlight) -> None:
    """Verdict, cause and tables, then a page for each picture. Raises OSError if the file cannot be written."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_pdf import PdfPages
    from matplotlib.figure import Figure

    with rc_context(style(ON_PAPER)), PdfPages(path, metadata={"CreationDate": None}) as pages:
        first = Figure(figsize=_PAGE, facecolor="white")
        _write_first_page(first, flight)
        pages.savefig(first)
        for name, figure in drawings(flight, ON_PAPER):
            figure.set_facecolor("white")
            figure.suptitle(name.removesuffix("_picture"))
            pages.savefig(figure)


def _write_first_page(page: Figure, flight: LoggedFlight) -> None:
    verdict, at = flight.verdict, _TOP
    page.text(_LEFT, at, textwrap.shorten(flight.mission, 60), fontsize=18, weight="bold", va="top")
    at -= 2.4 * _LINE
    mark = "✓ " if verdict.good else "✗ "
    for line in textwrap.wrap(mark + verdict.line, 75):
        page.text(_LEFT, at, line, fontsize=12, weight="bold", color=_GOOD if verdict.good else _BAD, va="top")
        at -= 1.4 * _LINE
    for cause in verdict.causes:
        for line in textwrap.wrap(f"· {cause}", 100):
            page.text(_LEFT, at, line, fontsize=9.5, va="top")
            at -= _LINE
    tiles = [(label, f"{figure} {unit}") for label, figure, unit in report.headlines(flight)]
    tables: list[tuple[str, Sequence[report.Row]]] = [
        ("Flown", tiles),
        ("Limits", report.limit_rows(flight.figures)),
        ("Asked", report.asked_rows(flight)),
        ("Planned", report.planned_rows(flight)),
        ("Link", report.link_rows(flight)),
        ("Waypoints: due, north west up [m], miss", report.waypoint_rows(flight)[:_ON_FIRST_PAGE]),
        ("How it was made", list(report.made_rows(flight))),
    ]
    for heading, rows in tables:
        if not rows:
            continue
        at -= 0.6 * _LINE
        page.text(_LEFT, at, heading, fontsize=11, weight="bold", va="top")
        at -= 1.2 * _LINE
        for row in rows:
            at = _write_row(page, at, row)


def _write_row(page: Figure, at: float, row: report.Row) -> float:
    width = 0.34 if len(row) == 2 else 0.86 / len(row)
    page.text(_LEFT, at, row[0], fontsize=8.5, va="top", color="#5d6779")
    if len(row) == 2:
        for line in textwrap.wrap(row[1], 78) or [""]:
            page.text(_LEFT + 0.27, at, line, fontsize=8.5, va="top")
            at -= 0.85 * _LINE
        return at
    for i, cell in enumerate(row[1:], start=1):
        page.text(_LEFT + i * width, at, cell, fontsize=8.5, va="top")
    return at - 0.85 * _LINE

"""A flight in a terminal while it goes on: mode, waypoint, speed, error, link, and what each rotor does.

Why: beside console.py, for it redraws where the others print. It is told ten times a second and costs the flight
nothing: this process only watches.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

from rich.console import Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from halfroll.console import console, one_line_a_phase
from halfroll.station.record import Event, Glance

LOOKS_HZ = 10
_BAR = 12  # characters on either side of zero
_PUSHES, _PULLS, _AT_LIMIT = "#E69F00", "#56B4E9", "bold #D55E00"  # nobody needs to tell red from green
_ROTORS = ("left", "rear", "right", "front")
_LAST_WORDS = 3

Said = Callable[[str, "float | None"], None]


@contextlib.contextmanager
def watched_flight(title: str) -> Iterator[tuple[Said, Callable[[Event], None]]]:
    """progress and report of a flight, shown on standard error: redrawn on a terminal, a line a phase elsewhere."""
    out = console(stderr=True)
    if not out.is_terminal:
        yield one_line_a_phase(), lambda event: None
        return
    board = Dashboard(title)
    with Live(board, console=out, refresh_per_second=LOOKS_HZ, transient=True):
        yield board.said, board.report


class Dashboard:
    """Holds what was heard last; Rich asks for it when it draws."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._phase, self._fraction = "start", 0.0
        self._t_s, self._glance = 0.0, None  # type: float, Glance | None
        self._words: list[str] = []

    def said(self, phase: str, fraction: float | None) -> None:
        self._phase = phase
        if fraction is not None:
            self._fraction = fraction

    def report(self, event: Event) -> None:
        self._t_s = max(self._t_s, event.t_s)
        if event.glance:
            self._glance = event.glance
        elif event.kind == "text":
            self._words = [*self._words, event.text][-_LAST_WORDS:]

    def __rich__(self) -> RenderableType:
        head = Text.assemble((self._title, "bold"), f"  {self._t_s:7.2f} s  ", (self._phase, "cyan"))
        bar = Table.grid()  # a bar alone ends no line
        bar.add_row(ProgressBar(total=1.0, completed=self._fraction, width=40))
        parts: list[RenderableType] = [head, bar]
        if self._glance:
            parts += [figures(self._glance), rotor_bars(self._glance.rotors)]
        return Group(*parts, *(Text(words, "dim") for words in self._words))


def figures(seen: Glance) -> RenderableType:
    table = Table.grid(padding=(0, 2))
    error = "–" if seen.error_m is None else f"{1e3 * seen.error_m:.0f} mm"
    item = "–" if seen.item is None else f"{seen.item} of {seen.items - 1}"
    cells = (
        ("mode", f"{seen.mode}{'' if seen.armed else ' (disarmed)'}"),
        ("item", item),
        ("speed", f"{seen.speed_m_s:5.2f} m/s"),
        ("error", error),
        ("link", f"{seen.link_rate_Hz:.0f}/s"),
        ("time", f"×{seen.vehicle_rate:.1f}"),
    )
    table.add_row(*(Text(name, "dim") for name, _ in cells))
    table.add_row(*(Text(value, "bold") for _, value in cells))
    return table


def rotor_bars(rotors: tuple[float, ...] | None) -> RenderableType:
    """A bar a rotor from the middle: right pushes, left pulls."""
    if rotors is None:
        return Text("")
    return Group(*(rotor_bar(name, share) for name, share in zip(_ROTORS, rotors, strict=True)))


def rotor_bar(name: str, share: float) -> Text:
    """share: signed, of the largest thrust."""
    cells = min(round(abs(share) * _BAR), _BAR)
    full = abs(share) > 0.995
    style = _AT_LIMIT if full else _PUSHES if share >= 0.0 else _PULLS
    left, right = ("", "█" * cells) if share >= 0.0 else ("█" * cells, "")
    return Text.assemble(
        (f"{name:>6} ", "dim"), (f"{left:>{_BAR}}", style), ("│", "dim"), (f"{right:<{_BAR}}", style), f" {share:+5.2f}"
    )

"""`hr.view`: a flight in space, inline in a notebook or as a file. Why: the replay needs no server, so a notebook that
is sent to somebody still shows it.
"""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfroll.errors import InputError
from halfroll.viewer.replay import replay_html
from halfroll.viewer.sources import recording_of

if TYPE_CHECKING:
    from halfroll.flight import FlightResult
    from halfroll.missions.mission import Mission
    from halfroll.planner.plan import Plan
    from halfroll.results.log import Log


@dataclass(frozen=True)
class Replay:
    """A flight as one HTML page; the last line of a notebook's cell shows it."""

    page: str = field(repr=False)
    height_px: int = 480

    def save(self, path: str | Path) -> None:
        """Raises InputError where it cannot be written."""
        try:
            Path(path).write_text(self.page, encoding="utf-8")
        except OSError as error:
            raise InputError(f"{path}: the replay cannot be written: {error.strerror}; choose another name") from error

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{self.height_px}px;border:0"
        return f'<iframe srcdoc="{html.escape(self.page, quote=True)}" style="{style}"></iframe>'


def view(
    what: Plan | FlightResult | Log | Mission | str | Path,
    *,
    plan: Plan | str | Path | None = None,
    dark: bool = False,
    height_px: int = 480,
    **planning: Any,
) -> Replay:
    """A plan, a flight, a log or a mission (or a file of these) as it flies.

    plan: what a log is shown beside; planning: how a mission is planned, as for hr.plan. Raises InputError for what is
    none of these, and what reading and planning raise.
    """
    return Replay(replay_html(recording_of(what, plan=plan, **planning), dark), height_px)

"""Figures beside the scene: status, and what position, attitude, rates, rotors and link did in the last seconds.

Why: the only module that knows uPlot. It is given moments, never asks where they come from.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from halfroll.viewer import colours
from halfroll.viewer.moments import Array, Moment, Setting, roll_pitch_heading_deg

WINDOW_S = 10.0
SAMPLES = 200  # of a panel
_HEIGHT = 96  # [px] of a panel: five are seen at 1280×720
_INK = "#8a94a6"  # axes, on dark and light
_BANNER = "background:#D55E00;color:#fff;padding:4px 8px;border-radius:4px"
ROTORS = ("left", "rear", "right", "front")
_NAN4 = (np.nan,) * 4


@dataclass(frozen=True)
class _Panel:
    """values: of one moment, as many as lines."""

    title: str
    lines: tuple[str, ...]
    values: Callable[[Moment], Sequence[float]]
    limits: tuple[float, ...] = ()  # drawn as dashed lines


def panels_of(setting: Setting, live: bool) -> tuple[_Panel, ...]:
    panels = (
        _Panel("position error, mm", ("error",), lambda m: (np.nan if m.error_m is None else 1e3 * m.error_m,)),
        _Panel("attitude, °", ("roll", "pitch", "heading"), lambda m: roll_pitch_heading_deg(m.q_WB)),
        # wire's senses: right wing down, nose up, clockwise
        _Panel(
            "body rate, °/s",
            ("roll", "pitch", "yaw"),
            lambda m: np.degrees(m.w_WB_B * np.array([1.0, -1.0, -1.0])).tolist(),
        ),
        _Panel(
            "rotor command, N",
            ROTORS,
            lambda m: _NAN4 if m.rotor_N is None else m.rotor_N.tolist(),
            setting.thrust_N,
        ),
    )
    link = _Panel(
        "link: samples a second, age in ms",
        ("rate", "age"),
        lambda m: (
            np.nan if m.link_rate_Hz is None else m.link_rate_Hz,
            np.nan if m.link_age_s is None else 1e3 * m.link_age_s,
        ),
    )
    return (*panels, link) if live else panels


class Panels:
    """Draws the panels of a viser GUI; `show` is given the moments of the last WINDOW_S, oldest first."""

    def __init__(self, gui: Any, setting: Setting, live: bool) -> None:
        self._panels = panels_of(setting, live)
        self._charts = [self._add(gui, panel) for panel in self._panels]

    def show(self, moments: Sequence[Moment]) -> None:
        for panel, chart in zip(self._panels, self._charts, strict=True):
            chart.data = columns(panel.values, len(panel.lines), panel.limits, moments)

    @staticmethod
    def _add(gui: Any, panel: _Panel) -> Any:
        series: list[dict[str, Any]] = [{"label": "t"}]
        series += [
            {"label": name, "stroke": colour, "width": 1.5}
            for name, colour in zip(panel.lines, colours.SERIES, strict=False)
        ]
        series += [{"label": "limit", "stroke": colours.LIMIT, "width": 1, "dash": (4, 3)} for _ in panel.limits]
        grid = {"stroke": "rgba(138,148,166,0.25)", "width": 1}
        axis = {"stroke": _INK, "grid": grid, "ticks": {**grid, "size": 4}, "size": 44}
        names = "".join(
            f'<span style="color:{colour};font-weight:600;margin-left:8px">{name}</span>'
            for name, colour in zip(panel.lines, colours.SERIES, strict=False)
        )
        gui.add_html(f'<div style="font-size:12px;margin:2px 4px -6px">{panel.title}{names}</div>')
        return gui.add_uplot(
            columns(panel.values, len(panel.lines), panel.limits, ()),
            tuple(series),
            scales={"x": {"time": False}},
            axes=({**axis, "size": 28}, {**axis, "space": 18}),
            padding=(6, 10, 0, 0),
            legend={"show": False},
            height=_HEIGHT,
        )


def columns(
    values: Callable[[Moment], Sequence[float]], count: int, limits: Sequence[float], moments: Sequence[Moment]
) -> tuple[Array, ...]:
    """Times, then each line, then each limit; at least two samples, for uPlot draws no fewer."""
    if len(moments) < 2:
        return tuple(np.array([0.0, 1.0]) if i == 0 else np.full(2, np.nan) for i in range(1 + count + len(limits)))
    rows = np.array([[moment.t_s, *values(moment)] for moment in moments], dtype=np.float64)
    return (*rows.T, *(np.full(len(rows), limit) for limit in limits))


def status_html(setting: Setting, moment: Moment | None, said: Sequence[str], updates_Hz: float | None) -> str:
    """Mission and mode at one look; a banner while a failsafe acts."""
    title = html.escape(setting.title)
    if moment is None:
        return f"<p><b>{title}</b><br>waiting for the vehicle …</p>"
    banner = ""
    if moment.warning:
        words = html.escape(moment.warning)
        banner = f'<p role="alert" style="{_BANNER}"><b>{words}</b></p>'
    rows = [
        ("mode", f"{html.escape(moment.mode)}{'' if moment.armed else ', disarmed'}"),
        ("waypoint" if not said else "item", _of(moment.item, moment.items)),
        ("time", f"{moment.t_s:.2f} s"),
        ("position", " ".join(f"{x:.2f}" for x in moment.p_WB) + " m"),
        ("speed", f"{moment.speed:.2f} m/s"),
        ("error", "–" if moment.error_m is None else f"{1e3 * moment.error_m:.0f} mm"),
        ("rotors", "–" if moment.rotor_N is None else " ".join(f"{f:+.2f}" for f in moment.rotor_N) + " N"),
    ]
    if moment.link_age_s is not None:
        rows.append(("link", f"{moment.link_rate_Hz or 0.0:.0f}/s, {1e3 * moment.link_age_s:.0f} ms old"))
    if updates_Hz is not None:
        rows.append(("page", f"{updates_Hz:.0f} updates a second"))
    cells = "".join(
        f'<tr><td style="opacity:.65;padding-right:10px">{name}</td>'
        f'<td id="halfroll-{name}" style="font-variant-numeric:tabular-nums">{value}</td></tr>'
        for name, value in rows
    )
    words = "".join(f"<div>{html.escape(line)}</div>" for line in list(said)[-3:])
    return (
        f'<div style="font-size:13px;line-height:1.35;padding:0 10px"><b>{title}</b>{banner}<table>{cells}</table>'
        f'<div style="opacity:.65">{words}</div></div>'
    )


def _of(k: int | None, n: int | None) -> str:
    return "–" if k is None else f"{k} of {n}" if n is not None else str(k)

"""The report of a flight: its figures and pictures as one HTML page, and one picture alone.

Why: the only module that draws a flight.
"""

from __future__ import annotations

import html
import io
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import halfroll
from halfroll.body_axes import body_up
from halfroll.drawing import (
    ON_PAGE,
    ON_PAPER,
    Palette,
    angle_between,
    draw_thrust_limits,
    legend,
    style,
    tilt_deg,
)
from halfroll.results.evaluation import FlightFigures, at_times, between, evaluate, planned_positions, waypoints
from halfroll.results.log import Log

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from halfroll.planner.plan import Plan
    from halfroll.vehicle import Vehicle

__all__ = ["FlightFigures", "evaluate", "save_picture", "write_report"]

FloatArray = NDArray[np.float64]
MODES = ("hold", "takeoff", "mission", "return", "land", "offboard")  # order of the autopilot's Mode


@dataclass(frozen=True)
class _Flight:
    """What is drawn: plan and log, brought to plan time, thinned to what a picture can show."""

    plan: Plan
    start_s: float
    log: Log
    vehicle: Vehicle

    def samples(self, topic: str, margin_s: float = 0.4, count: int = 1200) -> tuple[FloatArray, Callable[[str], Any]]:
        """Plan times of the topic's samples around the planned part, and a function from a field to these samples."""
        chosen = self.log[topic]
        inside = np.flatnonzero(between(chosen, self.start_s - margin_s, self.start_s + self.plan.T + margin_s))
        inside = inside[:: max(1, len(inside) // count)]
        return chosen.t[inside] - self.start_s, lambda name: np.asarray(chosen[name][inside], dtype=np.float64)


def _draw_path(axes: Any, flight: _Flight, colours: Palette, zoom: float) -> None:
    """Plan and flown path in space; a tick along body up every so often shows how the vehicle lay."""
    from matplotlib.ticker import MaxNLocator

    t, truth = flight.samples("vehicle_truth", margin_s=0.0)
    p, up = truth("p"), body_up(truth("q"))
    points = waypoints(flight.plan)
    low, high = np.minimum(p.min(axis=0), points.min(axis=0)), np.maximum(p.max(axis=0), points.max(axis=0))
    size = float((high - low).max())
    path = planned_positions(flight.plan, np.linspace(0.0, flight.plan.T, 600))
    floor = min(0.0, float(low[2]))
    axes.plot(p[:, 0], p[:, 1], np.full(len(p), floor), color=colours.faint, lw=1.2)
    axes.plot(*path.T, color=colours.planned, lw=1.0, ls=(0, (4, 3)), label="planned")
    axes.plot(*p.T, color=colours.flown, lw=1.8, label="flown")
    every = np.searchsorted(t, np.arange(0.0, t[-1], max(flight.plan.T / 60, 0.04)))
    tip = p[every] + up[every] * 0.06 * size
    for foot, head in zip(p[every], tip, strict=True):
        axes.plot(*np.stack([foot, head]).T, color=colours.alert, lw=0.8, alpha=0.75)
    axes.plot([], [], [], color=colours.alert, lw=0.8, label="body up")
    axes.scatter(*points.T, s=16, color=colours.ink, depthshade=False)
    for point in np.unique(points.round(3), axis=0):
        here = np.flatnonzero(np.linalg.norm(points - point, axis=1) < 0.01 * size) + 1
        label = ", ".join(str(number) for number in here)
        x, y, z = point
        axes.text(x, y, z + 0.09 * size, label, color=colours.ink, ha="center", fontsize=9.5)
    centre = (low + high) / 2
    span = np.maximum(high - low, 0.3 * size) * 1.1
    axes.set_xlim(centre[0] - span[0] / 2, centre[0] + span[0] / 2)
    axes.set_ylim(centre[1] - span[1] / 2, centre[1] + span[1] / 2)
    axes.set_zlim(floor, max(high[2] + 0.08 * size, floor + span[2]))
    axes.set_box_aspect((span[0], span[1], axes.get_zlim()[1] - floor), zoom=zoom)
    axes.set(xlabel="north [m]", ylabel="west [m]", zlabel="up [m]")
    axes.zaxis.set_rotate_label(False)
    axes.zaxis.label.set_rotation(90)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((0, 0, 0, 0))
        axis.line.set_color(colours.faint)
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.view_init(elev=24, azim=-125)
    axes.legend(loc="upper left", ncols=3)


def _draw_tracking(axes: Sequence[Axes], flight: _Flight, colours: Palette) -> None:
    t, truth = flight.samples("vehicle_truth")
    planned = planned_positions(flight.plan, t)
    for i, (panel, name) in enumerate(zip(axes[:3], ("north", "west", "up"), strict=True)):
        panel.plot(t, planned[:, i], color=colours.planned, lw=1.1, ls=(0, (4, 3)), zorder=3, label="planned")
        panel.plot(t, truth("p")[:, i], color=colours.flown, label="flown")
        panel.set_ylabel(f"{name} [m]")
    _draw_error(axes[3], flight, colours)
    legend(axes[0])


def _draw_error(axes: Axes, flight: _Flight, colours: Palette) -> None:
    t, truth = flight.samples("vehicle_truth", margin_s=0.0)
    error = truth("p") - planned_positions(flight.plan, t)
    for name, colour, component in zip(("north", "west", "up"), colours.axes, error.T, strict=True):
        axes.plot(t, component * 1e3, color=colour, lw=1.0, label=name)
    axes.plot(t, np.linalg.norm(error, axis=1) * 1e3, color=colours.ink, lw=1.5, label="distance")
    axes.margins(y=0.25)
    axes.set_ylabel("error [mm]")
    legend(axes)


def _draw_attitude(axes: Sequence[Axes], flight: _Flight, colours: Palette) -> None:
    t, truth = flight.samples("vehicle_truth")
    t_ref, reference = flight.samples("attitude_reference")
    _draw_tilt(axes[0], flight, colours)
    attitude = at_times(flight.log["vehicle_truth"], "q", t_ref + flight.start_s)  # when new, not while it was held
    axes[1].plot(t_ref, np.degrees(angle_between(attitude, reference("q"))), color=colours.alert)
    axes[1].set_ylabel("attitude error [°]")
    for i, (name, colour) in enumerate(zip(("roll", "pitch", "yaw"), colours.axes, strict=True)):
        axes[2].plot(t_ref, np.degrees(reference("w")[:, i]), color=colours.planned, ls=(0, (4, 3)), lw=1.0)
        axes[2].plot(t, np.degrees(truth("w")[:, i]), color=colour, lw=1.2, label=name)
    axes[2].set_ylabel("body rate [°/s]")
    legend(axes[2])


def _draw_tilt(axes: Axes, flight: _Flight, colours: Palette) -> None:
    """Angle between body up and up: 180° is inverted."""
    t, truth = flight.samples("vehicle_truth")
    t_ref, reference = flight.samples("attitude_reference")
    axes.plot(
        t_ref, tilt_deg(reference("q")), color=colours.planned, lw=1.1, ls=(0, (4, 3)), zorder=3, label="reference"
    )
    axes.plot(t, tilt_deg(truth("q")), color=colours.flown, label="flown")
    axes.set_ylabel("tilt [°]")
    legend(axes)


def _draw_rotors(axes: Sequence[Axes], flight: _Flight, colours: Palette) -> None:
    t, commands = flight.samples("rotor_commands", count=2400)
    t_truth, truth = flight.samples("vehicle_truth", count=2400)
    low, high = flight.vehicle.rotor.thrust_min_N, flight.vehicle.rotor.thrust_max_N
    for i, panel in enumerate(axes):
        panel.plot(t, commands("thrust")[:, i], color=colours.planned, lw=0.9, label="command")
        panel.plot(t_truth, truth("f")[:, i], color=colours.flown, lw=1.3, label="thrust")
        draw_thrust_limits(panel, low, high, colours)
        panel.set_ylabel(f"rotor {i + 1} [N]")
    legend(axes[0])


def _draw_whole_flight(axes: Axes, flight: _Flight, colours: Palette) -> None:
    """Height from arming to disarming, with the mode that flew."""
    truth, state = flight.log["vehicle_truth"], flight.log["vehicle_state"]
    every = slice(None, None, max(1, len(truth) // 1500))
    axes.plot(truth.t[every], truth["p"][every, 2], color=colours.flown)
    axes.axvspan(flight.start_s, flight.start_s + flight.plan.T, color=colours.planned, alpha=0.16, lw=0)
    axes.set(ylabel="height [m]", xlabel="vehicle time [s]")
    top = max(0.5, float(truth["p"][:, 2].max())) * 1.25
    axes.set_ylim(min(0.0, float(truth["p"][:, 2].min())) - 0.05 * top, top)
    changes = np.flatnonzero(np.diff(state["mode"], prepend=-1))
    for i, end in zip(changes, [*changes[1:], len(state) - 1], strict=True):
        code = int(state["mode"][i])
        if i:
            axes.axvline(state.t[i], color=colours.faint, lw=0.9)
        if state.t[end] - state.t[i] > 0.06 * state.t[-1]:
            name = MODES[code] if code < len(MODES) else str(code)
            axes.text((state.t[i] + state.t[end]) / 2, 0.94 * top, name, ha="center", va="center", fontsize=9)


def _finish(axes: Sequence[Axes], flight: _Flight, colours: Palette) -> None:
    """What all panels over plan time share: the due times of the waypoints, and one time axis below."""
    for panel in axes:
        for due in flight.plan.times_s:
            panel.axvline(due, color=colours.faint, lw=0.9, zorder=0.5)
        panel.grid(axis="x", visible=False)
        panel.set_xlim(-0.4, flight.plan.T + 0.4)
    axes[-1].set_xlabel("plan time [s]; vertical lines: waypoints due")


def save_picture(path: str | Path, plan: Plan, plan_start_s: float, log: Log, vehicle: Vehicle) -> None:
    from matplotlib import rc_context

    with rc_context(style(ON_PAPER)):
        figure = flight_figure(plan, plan_start_s, log, vehicle)
        figure.savefig(path, dpi=130, facecolor="white", metadata={"Software": None})


def flight_figure(plan: Plan, plan_start_s: float, log: Log, vehicle: Vehicle) -> Figure:
    """One picture of the flight on white: path, error, tilt and the hardest worked rotor."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    flight, colours = _Flight(plan, plan_start_s, log, vehicle), ON_PAPER
    with rc_context(style(colours)):
        figure = Figure(figsize=(11, 5.6), layout="constrained", facecolor="white")
        grid = figure.add_gridspec(3, 2, width_ratios=(1.15, 1.0))
        _draw_path(figure.add_subplot(grid[:, 0], projection="3d"), flight, colours, zoom=0.95)
        panels = [figure.add_subplot(grid[row, 1]) for row in range(3)]
        _draw_error(panels[0], flight, colours)
        _draw_tilt(panels[1], flight, colours)
        _draw_all_thrusts(panels[2], flight, colours)
        _finish(panels, flight, colours)
    return figure


def _draw_all_thrusts(axes: Axes, flight: _Flight, colours: Palette) -> None:
    t, truth = flight.samples("vehicle_truth", count=2400)
    for i, colour in enumerate((colours.flown, *colours.axes)):
        axes.plot(t, truth("f")[:, i], color=colour, lw=1.0, label=f"rotor {i + 1}")
    draw_thrust_limits(axes, flight.vehicle.rotor.thrust_min_N, flight.vehicle.rotor.thrust_max_N, colours)
    axes.set_ylabel("thrust [N]")
    legend(axes)


def write_report(
    path: str | Path,
    figures: FlightFigures,
    plan: Plan,
    plan_start_s: float,
    log: Log,
    vehicle: Vehicle,
    *,
    mission: str,
    command: str,
    facts: Mapping[str, str] | None = None,
    replay: str | None = None,
) -> None:
    """One HTML file that needs nothing else: verdict, figures, pictures, and how to fly it again.

    mission: how the reader knows it (a file name); command: what to type to repeat the flight; facts: more rows for the
    last table; replay: where it lies, seen from here. Raises OSError if the file cannot be written.
    """
    flight = _Flight(plan, plan_start_s, log, vehicle)
    made_by = {
        "command": command,
        "vehicle": vehicle.name,
        "scenario": str(log.info.get("scenario", "–")),
        "seed": str(log.info.get("seed", "–")),
        **(facts or {}),
        "rotor commands, SHA-256": str(log.info.get("commands_sha256", "–")),
        "log": str(log.path),
        "versions": _versions(),
    }
    page = Template(resources.files("halfroll.results").joinpath("report.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(f"{mission} · {vehicle.name}"),
        mission=html.escape(mission),
        replay="" if replay is None else f'<a href="{html.escape(replay)}">see it fly</a>',
        verdict="Flown within limits" if figures.within_limits else "Out of limits",
        verdict_class="good" if figures.within_limits else "bad",
        tiles="".join(_tile(*tile) for tile in _headlines(figures)),
        checks="".join(_row(check.what, check.got, check.allowed, _mark(check.holds)) for check in figures.checks),
        waypoints="".join(
            _row(number, f"{due:.2f} s", ", ".join(f"{x:.2f}" for x in point), f"{miss * 1e3:.0f} mm")
            for number, (due, point, miss) in enumerate(
                zip(plan.times_s, waypoints(plan), figures.waypoint_miss_m, strict=True), start=1
            )
        ),
        rotors="".join(
            _row(number, f"{low:.2f} N", f"{high:.2f} N")
            for number, (low, high) in enumerate(zip(figures.rotor_min_N, figures.rotor_max_N, strict=True), start=1)
        ),
        made_by="".join(_row(name, html.escape(fact)) for name, fact in made_by.items()),
        **_pictures(flight),
    )
    Path(path).write_text(page, encoding="utf-8")


def _pictures(flight: _Flight) -> dict[str, str]:
    """Placeholder of the page to inline SVG."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    colours = ON_PAGE
    with rc_context(style(colours)):
        path = Figure(figsize=(9, 5.6), layout="constrained")
        _draw_path(path.add_subplot(projection="3d"), flight, colours, zoom=1.15)
        whole = Figure(figsize=(9, 2.2), layout="constrained")
        _draw_whole_flight(whole.add_subplot(), flight, colours)
        drawn = {"path": _svg(path), "whole": _svg(whole)}
        for name, draw, rows in (
            ("tracking", _draw_tracking, 4),
            ("attitude", _draw_attitude, 3),
            ("rotors_picture", _draw_rotors, 4),
        ):
            figure = Figure(figsize=(9, 1.7 * rows), layout="constrained")
            panels = list(figure.subplots(rows, 1, sharex=True))
            draw(panels, flight, colours)
            _finish(panels, flight, colours)
            drawn[name] = _svg(figure)
    return drawn


def _svg(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    for name, stand_in in vars(ON_PAGE).items():
        text = text.replace(stand_in, f"var(--{name})")
    return text[text.index("<svg") :]


def _headlines(figures: FlightFigures) -> list[tuple[str, str, str]]:
    return [
        ("planned", f"{figures.T_planned_s:.2f}", "s"),
        ("flown", f"{figures.T_flown_s:.2f}", "s"),
        ("tracking, RMS", f"{figures.tracking_rms_m * 1e3:.0f}", "mm"),
        ("tracking, worst", f"{figures.tracking_max_m * 1e3:.0f}", "mm"),
        ("largest waypoint miss", f"{figures.waypoint_miss_max_m * 1e3:.0f}", "mm"),
        ("arm to disarm", f"{figures.flight_s:.1f}", "s"),
    ]


def _tile(label: str, value: str, unit: str) -> str:
    return f'<div class="tile"><b>{value}<small> {unit}</small></b><span>{label}</span></div>'


def _row(*cells: object) -> str:
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _mark(holds: bool) -> str:
    return '<span class="good">✓</span>' if holds else '<span class="bad">✗</span>'


def _versions() -> str:
    found = [f"halfroll {halfroll.__version__}"]
    found += [f"{name} {metadata.version(name)}" for name in ("numpy", "scipy", "pymavlink")]
    return ", ".join([*found, f"Python {platform.python_version()}", f"{platform.system()} {platform.machine()}"])

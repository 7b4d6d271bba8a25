"""The pictures of a flight: as SVG for the page, as figures for paper, and two flights together.

Why: the only module that draws a flight, so page, PDF and `halfroll log plot` show the same.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

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
from halfroll.errors import InputError
from halfroll.results.evaluation import at_times, between, planned_positions, waypoints
from halfroll.results.logged_flight import LoggedFlight

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from halfroll.planner.plan import Plan
    from halfroll.results.log import Log

FloatArray = NDArray[np.float64]
MODES = ("hold", "mission", "return", "land", "takeoff", "offboard")  # order of the autopilot's Mode
IMAGES = (".png", ".pdf", ".svg")
_DASHES = (0, (4, 3))


@dataclass(frozen=True)
class _Flight:
    """What is drawn: plan, if there is one, and log, in seconds from start_s, thinned to what a picture can show."""

    plan: Plan | None
    start_s: float
    length_s: float
    log: Log
    thrust_N: tuple[float, float] | None

    def samples(self, topic: str, margin_s: float = 0.4, count: int = 1200) -> tuple[FloatArray, Callable[[str], Any]]:
        """Times of the topic's samples in what is drawn, and a function from a field to these samples."""
        chosen = self.log[topic]
        inside = np.flatnonzero(between(chosen, self.start_s - margin_s, self.start_s + self.length_s + margin_s))
        inside = inside[:: max(1, len(inside) // count)]
        return chosen.t[inside] - self.start_s, lambda name: np.asarray(chosen[name][inside], dtype=np.float64)


def _drawn(flight: LoggedFlight) -> _Flight:
    """The planned part of a good flight; of any other, all from there, or from arming, to the end of the log."""
    truth = flight.log["vehicle_truth"]
    end_s = float(truth.t[-1])
    limits = None if flight.vehicle is None else flight.vehicle.rotor
    thrust = None if limits is None else (limits.thrust_min_N, limits.thrust_max_N)
    if flight.plan is not None and flight.start_s is not None and flight.start_s < end_s:
        length_s = flight.plan.T if flight.verdict.good else end_s - flight.start_s
        return _Flight(flight.plan, flight.start_s, length_s, flight.log, thrust)
    state = flight.log["vehicle_state"]
    armed = state.t[np.asarray(state["armed"], dtype=bool)]
    start_s = float(armed[0]) if len(armed) else float(truth.t[0])
    return _Flight(None, start_s, end_s - start_s, flight.log, thrust)


def _draw_path(axes: Any, flight: _Flight, colours: Palette, zoom: float) -> None:
    """Plan and flown path in space; a tick along body up every so often shows how the vehicle lay."""
    from matplotlib.ticker import MaxNLocator

    t, truth = flight.samples("vehicle_truth", margin_s=0.0)
    p, up = truth("p"), body_up(truth("q"))
    points = np.empty((0, 3)) if flight.plan is None else waypoints(flight.plan)
    low, high = (side(np.vstack([p, points]), axis=0) for side in (np.min, np.max))
    size = max(float((high - low).max()), 0.1)
    floor = min(0.0, float(low[2]))
    axes.plot(p[:, 0], p[:, 1], np.full(len(p), floor), color=colours.faint, lw=1.2)
    if flight.plan is not None:
        path = planned_positions(flight.plan, np.linspace(0.0, flight.plan.T, 600))
        axes.plot(*path.T, color=colours.planned, lw=1.0, ls=_DASHES, label="planned")
    axes.plot(*p.T, color=colours.flown, lw=1.8, label="flown")
    every = np.searchsorted(t, np.arange(0.0, t[-1], max(flight.length_s / 60, 0.04)))
    tip = p[every] + up[every] * 0.06 * size
    for foot, head in zip(p[every], tip, strict=True):
        axes.plot(*np.stack([foot, head]).T, color=colours.alert, lw=0.8, alpha=0.75)
    axes.plot([], [], [], color=colours.alert, lw=0.8, label="body up")
    axes.scatter(*points.T, s=16, color=colours.ink, depthshade=False)
    for point in np.unique(points.round(3), axis=0):  # none without a plan
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
    planned = None if flight.plan is None else planned_positions(flight.plan, t)
    for i, (panel, name) in enumerate(zip(axes[:3], ("north", "west", "up"), strict=True)):
        if planned is not None:
            panel.plot(t, planned[:, i], color=colours.planned, lw=1.1, ls=_DASHES, zorder=3, label="planned")
        panel.plot(t, truth("p")[:, i], color=colours.flown, label="flown")
        panel.set_ylabel(f"{name} [m]")
    _draw_error(axes[3], flight, colours)
    legend(axes[0])


def _draw_error(axes: Axes, flight: _Flight, colours: Palette) -> None:
    if flight.plan is None:
        _draw_estimation_error(axes, flight, colours)
        return
    t, truth = flight.samples("vehicle_truth", margin_s=0.0)
    error = truth("p") - planned_positions(flight.plan, t)
    for name, colour, component in zip(("north", "west", "up"), colours.axes, error.T, strict=True):
        axes.plot(t, component * 1e3, color=colour, lw=1.0, label=name)
    axes.plot(t, np.linalg.norm(error, axis=1) * 1e3, color=colours.ink, lw=1.5, label="distance")
    axes.margins(y=0.25)
    axes.set_ylabel("error [mm]")
    legend(axes)


def _draw_estimation_error(axes: Axes, flight: _Flight, colours: Palette) -> None:
    """Without a plan there is nothing else to be off from."""
    if "vehicle_estimate" in flight.log:
        t, estimate = flight.samples("vehicle_estimate", margin_s=0.0)
        off = estimate("p") - at_times(flight.log["vehicle_truth"], "p", t + flight.start_s)
        axes.plot(t, np.linalg.norm(off, axis=1) * 1e3, color=colours.ink)
    axes.set_ylabel("estimate off by [mm]")


def _draw_attitude(axes: Sequence[Axes], flight: _Flight, colours: Palette) -> None:
    t, truth = flight.samples("vehicle_truth")
    t_ref, reference = flight.samples("attitude_reference")
    _draw_tilt(axes[0], flight, colours)
    attitude = at_times(flight.log["vehicle_truth"], "q", t_ref + flight.start_s)  # when new, not while it was held
    axes[1].plot(t_ref, np.degrees(angle_between(attitude, reference("q"))), color=colours.alert)
    axes[1].set_ylabel("attitude error [°]")
    for i, (name, colour) in enumerate(zip(("roll", "pitch", "yaw"), colours.axes, strict=True)):
        axes[2].plot(t_ref, np.degrees(reference("w")[:, i]), color=colours.planned, ls=_DASHES, lw=1.0)
        axes[2].plot(t, np.degrees(truth("w")[:, i]), color=colour, lw=1.2, label=name)
    axes[2].set_ylabel("body rate [°/s]")
    legend(axes[2])


def _draw_tilt(axes: Axes, flight: _Flight, colours: Palette) -> None:
    """Angle between body up and up: 180° is inverted."""
    t, truth = flight.samples("vehicle_truth")
    t_ref, reference = flight.samples("attitude_reference")
    axes.plot(t_ref, tilt_deg(reference("q")), color=colours.planned, lw=1.1, ls=_DASHES, zorder=3, label="reference")
    axes.plot(t, tilt_deg(truth("q")), color=colours.flown, label="flown")
    axes.set_ylabel("tilt [°]")
    legend(axes)


def _draw_rotors(axes: Sequence[Axes], flight: _Flight, colours: Palette) -> None:
    t, commands = flight.samples("rotor_commands", count=2400)
    t_truth, truth = flight.samples("vehicle_truth", count=2400)
    for i, panel in enumerate(axes):
        panel.plot(t, commands("thrust")[:, i], color=colours.planned, lw=0.9, label="command")
        panel.plot(t_truth, truth("f")[:, i], color=colours.flown, lw=1.3, label="thrust")
        if flight.thrust_N is not None:
            draw_thrust_limits(panel, *flight.thrust_N, colours)
        panel.set_ylabel(f"rotor {i + 1} [N]")
    legend(axes[0])


def _draw_whole_flight(axes: Axes, flight: _Flight, colours: Palette) -> None:
    """Height from arming to disarming, with the mode that flew."""
    truth, state = flight.log["vehicle_truth"], flight.log["vehicle_state"]
    every = slice(None, None, max(1, len(truth) // 1500))
    axes.plot(truth.t[every], truth["p"][every, 2], color=colours.flown)
    if flight.plan is not None:
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
        for due in () if flight.plan is None else flight.plan.times_s:
            panel.axvline(due, color=colours.faint, lw=0.9, zorder=0.5)
        panel.grid(axis="x", visible=False)
        panel.set_xlim(-0.4, flight.length_s + 0.4)
    axes[-1].set_xlabel(
        "time since arming [s]" if flight.plan is None else "plan time [s]; vertical lines: waypoints due"
    )


def save_picture(path: str | Path, flight: LoggedFlight) -> None:
    """One picture of the flight on white: path, error, tilt and all rotors; .png, .pdf or .svg. Raises InputError."""
    from matplotlib import rc_context

    with rc_context(style(ON_PAPER)), named_image(path):
        overview(flight).savefig(path, dpi=130, facecolor="white", metadata=_unstamped(path))


def overview(flight: LoggedFlight) -> Figure:
    """The figure of save_picture."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    drawn, colours = _drawn(flight), ON_PAPER
    with rc_context(style(colours)):
        figure = Figure(figsize=(11, 5.6), layout="constrained", facecolor="white")
        grid = figure.add_gridspec(3, 2, width_ratios=(1.15, 1.0))
        _draw_path(figure.add_subplot(grid[:, 0], projection="3d"), drawn, colours, zoom=0.95)
        panels = [figure.add_subplot(grid[row, 1]) for row in range(3)]
        _draw_error(panels[0], drawn, colours)
        _draw_tilt(panels[1], drawn, colours)
        _draw_all_thrusts(panels[2], drawn, colours)
        _finish(panels, drawn, colours)
    return figure


@contextlib.contextmanager
def named_image(path: str | Path) -> Iterator[None]:
    """Raises InputError for a file that is named as no image that can be written."""
    if Path(path).suffix.lower() not in IMAGES:
        raise InputError(f"{path}: pictures are written as {', '.join(IMAGES)}; end the name in one of them")
    yield


def _unstamped(path: str | Path) -> dict[str, None]:
    """No date in the file: the same flight gives the same picture."""
    return {
        ".png": {"Software": None},
        ".pdf": {"CreationDate": None},
        ".svg": {"Date": None},
    }[Path(path).suffix.lower()]


def _draw_all_thrusts(axes: Axes, flight: _Flight, colours: Palette) -> None:
    t, truth = flight.samples("vehicle_truth", count=2400)
    for i, colour in enumerate((colours.flown, *colours.axes)):
        axes.plot(t, truth("f")[:, i], color=colour, lw=1.0, label=f"rotor {i + 1}")
    if flight.thrust_N is not None:
        draw_thrust_limits(axes, *flight.thrust_N, colours)
    axes.set_ylabel("thrust [N]")
    legend(axes)


def drawings(flight: LoggedFlight, colours: Palette) -> Iterator[tuple[str, Figure]]:
    """Name and figure of each picture of the report. Call it, and draw, within rc_context(style(colours))."""
    from matplotlib.figure import Figure

    drawn = _drawn(flight)
    path = Figure(figsize=(9, 5.6), layout="constrained")
    _draw_path(path.add_subplot(projection="3d"), drawn, colours, zoom=1.15)
    yield "path", path
    whole = Figure(figsize=(9, 2.2), layout="constrained")
    _draw_whole_flight(whole.add_subplot(), drawn, colours)
    yield "whole", whole
    for name, draw, rows in (
        ("tracking", _draw_tracking, 4),
        ("attitude", _draw_attitude, 3),
        ("rotors_picture", _draw_rotors, 4),
    ):
        figure = Figure(figsize=(9, 1.7 * rows), layout="constrained")
        panels = list(figure.subplots(rows, 1, sharex=True))
        draw(panels, drawn, colours)
        _finish(panels, drawn, colours)
        yield name, figure


def page_pictures(flight: LoggedFlight) -> dict[str, str]:
    """Placeholder of the page to inline SVG."""
    from matplotlib import rc_context

    with rc_context(style(ON_PAGE)):
        return {name: _svg(figure) for name, figure in drawings(flight, ON_PAGE)}


def _svg(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    for name, stand_in in vars(ON_PAGE).items():
        text = text.replace(stand_in, f"var(--{name})")
    return text[text.index("<svg") :]


def save_pictures(folder: Path, flight: LoggedFlight, suffix: str = ".png") -> list[Path]:
    """Every picture of the report as a file of its own; their names. Raises InputError, OSError."""
    from matplotlib import rc_context

    saved = []
    with rc_context(style(ON_PAPER)), named_image(f"picture{suffix}"):
        for name, figure in (("overview", overview(flight)), *drawings(flight, ON_PAPER)):
            saved.append(folder / f"{name.removesuffix('_picture')}{suffix}")
            figure.savefig(saved[-1], dpi=130, facecolor="white", metadata=_unstamped(saved[-1]))
    return saved


def save_comparison(path: Path, flights: Sequence[LoggedFlight]) -> None:
    """Two flights over the same time: position, distance of one from the other, tilt, rotors. Raises InputError."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    colours, (first, second) = ON_PAPER, (_drawn(flight) for flight in flights)
    with rc_context(style(colours)), named_image(path):
        figure = Figure(figsize=(9, 9), layout="constrained", facecolor="white")
        panels = list(figure.subplots(6, 1, sharex=True))
        looks = ((first, colours.flown, "-"), (second, colours.y, _DASHES))
        for flight, colour, dashes in looks:
            t, truth = flight.samples("vehicle_truth", margin_s=0.0)
            for i, (panel, name) in enumerate(zip(panels[:3], ("north", "west", "up"), strict=True)):
                panel.plot(t, truth("p")[:, i], color=colour, ls=dashes, label=str(flight.log.path.name))
                panel.set_ylabel(f"{name} [m]")
            panels[4].plot(t, tilt_deg(truth("q")), color=colour, ls=dashes)
            panels[5].plot(t, np.abs(truth("f")).max(axis=1), color=colour, ls=dashes, lw=1.0)
        t, truth = first.samples("vehicle_truth", margin_s=0.0)
        apart = np.linalg.norm(truth("p") - at_times(second.log["vehicle_truth"], "p", t + second.start_s), axis=1)
        panels[3].plot(t, apart * 1e3, color=colours.ink)
        for panel, label in zip(panels[3:], ("apart [mm]", "tilt [°]", "largest thrust [N]"), strict=True):
            panel.set_ylabel(label)
        legend(panels[0])
        panels[-1].set_xlabel("time since the plan's start, or arming [s]")
        figure.savefig(path, dpi=130, facecolor="white", metadata=_unstamped(path))

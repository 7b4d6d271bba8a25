"""Time-lines of a flip: path, angle, rate and rotor thrusts, planned and flown; and the vehicle drawn at instants.

Why: Figs 2, 3, 4, 8 and 9 show the same two flights in these panels.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll.body_axes import body_up
from halfroll.drawing import Palette, draw_thrust_limits, legend
from halfroll.paper.flights import START_M, Flights, turned_deg
from halfroll.planner.plan import Plan
from halfroll.streamed import Flown

Array = NDArray[np.float64]

_SAMPLES = 2001
_AFTER_S = 0.4  # drawn beyond the plan's end


def planned_turn_deg(plan: Plan, t: Array) -> Array:
    """(N,) the plan's thrust axis in the x-z plane, unwrapped."""
    n = plan.outputs(t).thrust_axis
    return np.asarray(np.degrees(np.unwrap(np.arctan2(n[:, 0], n[:, 2]))))


def draw_flip(figure: Any, colours: Palette, flights: Flights) -> None:
    """Four panels: path with the thrust axis, angle, rate, rotor thrusts of the first flight."""
    plan, shown = flights.plan, flights.first
    until = shown.t <= plan.T + _AFTER_S
    t = np.linspace(0.0, plan.T, _SAMPLES)
    path, angle, rate, thrust = _panels(figure, wide=bool(np.ptp(plan.trajectory.at(t)[:, 0]) > 2.0))
    draw_path(path, colours, plan, flights)
    angle.plot(t, planned_turn_deg(plan, t), color=colours.planned, ls=(0, (4, 3)), zorder=3, label="planned")
    angle.set_ylabel("angle [°]")
    about_y = np.degrees(plan.outputs(t).w_WD_D[:, 1])
    rate.plot(t, about_y, color=colours.planned, ls=(0, (4, 3)), zorder=3, label="planned")
    rate.set_ylabel("rate [°/s]")
    for k, flown in enumerate(flights.flown):
        faint = {"alpha": 1.0 if k == 0 else 0.3, "label": "flown" if k == 0 else None}
        angle.plot(flown.t[until], turned_deg(flown)[until], color=colours.flown, **faint)
        rate.plot(flown.t[until], np.degrees(flown.w_WB_B[until, 1]), color=colours.flown, **faint)
    draw_rotors(thrust, colours, plan, shown.t[until], shown.rotors[until])
    for axes in (angle, rate, thrust):
        axes.set_xlim(0.0, plan.T + _AFTER_S)
        for event in plan.sigma_events:
            axes.axvline(event, color=colours.faint, lw=1.0, zorder=0)
    legend(angle)
    thrust.set_xlabel("time [s]; vertical lines: sigma changes")


def _panels(figure: Any, wide: bool) -> list[Any]:
    """The path beside the time-lines, or above them where it is long."""
    if wide:
        return list(figure.subplots(4, 1, height_ratios=(1.1, 1.0, 1.0, 1.0)))
    space = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.1))
    return [figure.add_subplot(space[:, 0]), *(figure.add_subplot(space[row, 1]) for row in range(3))]


def draw_path(axes: Any, colours: Palette, plan: Plan, flights: Flights) -> None:
    """x-z, with ticks along the body's z of the first flight."""
    t = np.linspace(0.0, plan.T, _SAMPLES)
    planned = plan.trajectory.at(t)
    shown = flights.first
    axes.plot(planned[:, 0], planned[:, 2] - START_M, color=colours.planned, ls=(0, (4, 3)), zorder=3, label="planned")
    for k, flown in enumerate(flights.flown):
        until = flown.t <= plan.T
        name = "flown" if k == 0 else None
        axes.plot(flown.p_WB[until, 0], flown.p_WB[until, 2] - START_M, color=colours.flown, lw=0.8, label=name)
    ticks = np.searchsorted(shown.t, np.linspace(0.0, plan.T, 32))
    size = 0.06 * float(np.ptp(planned[:, 0])) + 0.03
    up = body_up(shown.q_WB[ticks])
    for p, n in zip(shown.p_WB[ticks], up, strict=True):
        x, z = p[0], p[2] - START_M
        axes.plot([x, x + size * n[0]], [z, z + size * n[2]], color=colours.alert, lw=0.9)
    axes.plot([], [], color=colours.alert, lw=0.9, label="body z")
    axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
    axes.margins(0.08)
    legend(axes)


def draw_rotors(axes: Any, colours: Palette, plan: Plan, t: Array, rotors: Array | None) -> None:
    """Rotors 1 to 4; flown ones over the plan's, or the plan's alone."""
    rotor = plan.vehicle.rotor
    line_colours = (colours.flown, *colours.axes)
    if rotors is None:
        rotors = plan.outputs(t).rotors
    for k, colour in enumerate(line_colours):
        axes.plot(t, rotors[:, k], color=colour, lw=1.1, label=f"rotor {k + 1}")
    draw_thrust_limits(axes, rotor.thrust_min_N, rotor.thrust_max_N, colours)
    axes.set_ylabel("rotor thrust [N]")


def draw_snapshots(axes: Any, colours: Palette, flown: Flown, instants: Array, arm: float) -> None:
    """The vehicle from the side at these times, its z axis marked, over its path between them. arm: as drawn [m]"""
    between = (flown.t >= instants[0]) & (flown.t <= instants[-1])
    axes.plot(flown.p_WB[between, 0], flown.p_WB[between, 2] - START_M, color=colours.faint, lw=1.5, zorder=0)
    for number, k in enumerate(np.searchsorted(flown.t, instants), start=1):
        n = flown.up_axis[k, [0, 2]]
        forward = np.array([n[1], -n[0]])
        at = flown.p_WB[k, [0, 2]] - [0.0, START_M]
        for side in (-1.0, 1.0):
            hub = at + side * arm * forward
            axes.plot(*np.stack([at, hub]).T, color=colours.ink, lw=2.2, solid_capstyle="round")
            blade = hub + 0.16 * arm * n + 0.5 * arm * np.array([[-1.0], [1.0]]) * forward
            axes.plot(*blade.T, color=colours.flown, lw=1.4)
            axes.plot(*np.stack([hub, hub + 0.16 * arm * n]).T, color=colours.ink, lw=1.0)
        for side in (-0.3, 0.3):  # legs, so that the underside shows
            foot = at + 1.6 * side * arm * forward - 0.45 * arm * n
            axes.plot(*np.stack([at + side * arm * forward, foot]).T, color=colours.ink, lw=1.0)
        axes.annotate("", at + 1.1 * arm * n, at, arrowprops={"arrowstyle": "-|>", "color": colours.alert, "lw": 1.4})
        label = at + 1.4 * arm * n
        axes.plot(*label, alpha=0.0)  # makes room
        axes.text(*label, str(number), ha="center", va="center", fontsize=9, color=colours.alert)
    axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
    axes.margins(0.06)


def draw_attitude_line(figure_axes: Any, colours: Palette, flights: Flights, instants: Array) -> None:
    """Angle of the thrust axis over time, the instants numbered."""
    plan, flown = flights.plan, flights.first
    until = flown.t <= plan.T + _AFTER_S
    t = np.linspace(0.0, plan.T, _SAMPLES)
    turned = turned_deg(flown)
    figure_axes.plot(t, planned_turn_deg(plan, t), color=colours.planned, ls=(0, (4, 3)), zorder=3, label="planned")
    figure_axes.plot(flown.t[until], turned[until], color=colours.flown, label="flown")
    for number, k in enumerate(np.searchsorted(flown.t, instants), start=1):
        figure_axes.plot(flown.t[k], turned[k], "o", color=colours.alert, ms=4, zorder=4)
        figure_axes.annotate(
            str(number), (flown.t[k], turned[k]), (4, 4), textcoords="offset points", fontsize=9, color=colours.alert
        )
    figure_axes.set(xlabel="time [s]", ylabel="thrust axis from up [°]", xlim=(0.0, plan.T + _AFTER_S))
    legend(figure_axes)

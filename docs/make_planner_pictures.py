"""Draw the pictures of docs/planner.md with the planner itself: python docs/make_planner_pictures.py [FOLDER]"""

from __future__ import annotations

import re
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from halfroll.missions.mission import Waypoint
from halfroll.planner.limits import Limits
from halfroll.planner.near_optimal import limits_of, plan_near_optimal
from halfroll.planner.plan import Plan, plan_course
from halfroll.planner.segments import node, rest, solve
from halfroll.vehicle import load_vehicle

PICTURES = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("pictures")
INK, PAPER, FAST, BEST, LIMIT = "#1d2433", "#8a94a6", "#0d9488", "#2563eb", "#dc2626"
VEHICLE = load_vehicle("mit-fp")
ZIGZAG = [(0, 0, 1), (2, 1, 2), (4, -1, 1), (6, 1, 2.5), (8, -1, 1), (10, 0, 1.5)]
COURSE = [Waypoint(tuple(map(float, point))) for point in ZIGZAG]


def save(figure: Figure, name: str) -> None:
    figure.savefig(PICTURES / f"planner_{name}.png", dpi=110)


def new(width: float = 9.0, height: float = 3.2) -> Figure:
    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def finish(axes: Axes, x: str, y: str, legend: bool = True) -> None:
    axes.set(xlabel=x, ylabel=y)
    axes.grid(color="#e6e9f0")
    axes.spines[["top", "right"]].set_visible(False)
    if legend:
        axes.legend(frameon=False, fontsize=8)


def draw_closed_form() -> None:
    """The same nodes and times, joined C8 and C4: the 5th derivative jumps, and the path hardly differs."""
    heights = [0.0, 1.0, 0.2, 0.8, 0.0]
    nodes = [(rest if k in (0, 4) else node)([float(k), 0.0, z, 0.0]) for k, z in enumerate(heights)]
    figure = new()
    path, fifth = figure.subplots(1, 2)
    for continuity, colour, name in ((8, BEST, "C8: the paper's"), (4, LIMIT, "C4: least snap")):
        made = solve(np.array(nodes), np.ones(4), continuity)
        t = np.linspace(0.0, 4.0, 2000, endpoint=False)
        path.plot(t, made.at(t)[:, 2], color=colour, label=name)
        fifth.plot(t, made.at(t, 5)[:, 2] / 1e3, color=colour)
    path.plot(range(5), heights, "o", color=INK, markersize=4)
    finish(path, "time [s]", "height [m]")
    finish(fifth, "time [s]", "5th derivative [10³ m/s⁵]", legend=False)
    save(figure, "closed_form")


def draw_pieces(paper: Plan, best: Plan) -> None:
    """One piece a leg, and nine with virtual knots."""
    figure = new(9.0, 3.4)
    axes = figure.subplots()
    for plan, colour, name in ((paper, PAPER, "paper"), (best, BEST, "best")):
        columns, knots = plan.sample(500.0), plan.trajectory.at(plan.trajectory.times)
        axes.plot(columns["x_m"], columns["z_m"], color=colour, label=f"{name}: {plan.T:.2f} s")
        axes.plot(knots[:, 0], knots[:, 2], ".", color=colour, markersize=5)
    axes.plot([p[0] for p in ZIGZAG], [p[2] for p in ZIGZAG], "o", color=INK, markersize=5, label="waypoints")
    finish(axes, "north [m]", "up [m]")
    save(figure, "pieces")


def draw_unknowns() -> None:
    """Twice the time, with the derivatives of the knot kept, and with its unknowns kept."""
    nodes = np.array([rest([0, 0, 0, 0]), node([1.2, 0, 0.8, 0]), rest([2, 0, 0, 0])])
    T = np.array([0.6, 0.6])
    path = solve(nodes, T)
    inner = path.derivatives(path.times[1], 5)[0]
    later = 2.0 * T
    figure = new()
    axes = figure.subplots()
    grown = np.sqrt(later.prod() / T.prod()) ** np.arange(5.0)[:, None]
    kept, scaled = (solve(np.array([nodes[0], values, nodes[2]]), later) for values in (inner, inner / grown))
    for made, colour, style, name in (
        (path, PAPER, "-", "0.6 s a piece"),
        (kept, LIMIT, "-", "1.2 s, same derivatives"),
        (scaled, BEST, ":", "1.2 s, same unknowns"),
    ):
        there = made.at(np.linspace(0.0, made.times[-1], 800))
        axes.plot(there[:, 0], there[:, 2], color=colour, label=name, linestyle=style)
    axes.plot(nodes[:, 0, 0], nodes[:, 0, 2], "o", color=INK, markersize=4)
    finish(axes, "north [m]", "up [m]")
    save(figure, "unknowns")


def draw_forces(plans: dict[str, Plan]) -> None:
    """What each mode leaves of the rotors."""
    figure = new(9.0, 4.6)
    panels = figure.subplots(3, 1, sharex=True)
    for axes, (name, plan) in zip(panels, plans.items(), strict=True):
        columns = plan.sample(1000.0)
        for i, colour in enumerate((BEST, FAST, "#d97706", "#7c3aed"), start=1):
            axes.plot(columns["t_s"], columns[f"f{i}_N"], color=colour, linewidth=0.9, label=f"rotor {i}")
        for limit in (VEHICLE.rotor.thrust_min_N, VEHICLE.rotor.thrust_max_N):
            axes.axhline(limit, color=LIMIT, linewidth=0.7)
        finish(axes, "", f"{name} [N]", legend=False)
    panels[0].legend(frameon=False, fontsize=8, ncols=4)
    panels[-1].set_xlabel("time [s]")
    save(figure, "forces")


def draw_search(totals: list[float]) -> None:
    """The best flight known so far: each level of the ladder goes on where the last one ended."""
    figure = new(9.0, 2.8)
    axes = figure.subplots()
    axes.plot(totals, color=BEST)
    finish(axes, "solver step", "time of flight [s]", legend=False)
    save(figure, "search")


def draw_between_samples(best: Plan) -> None:
    """The highest thrust of a proven plan, around the limit."""
    t = np.arange(0.0, best.T, 1e-4)
    thrust = best.outputs(t).rotors.max(axis=1)
    limit = VEHICLE.rotor.thrust_max_N
    figure = new()
    whole, close = figure.subplots(1, 2)
    whole.plot(t, thrust, color=BEST, linewidth=0.9)
    whole.axhline(limit, color=LIMIT, linewidth=0.8)
    finish(whole, "time [s]", "highest rotor thrust [N]", legend=False)
    close.plot(t, 1e3 * (thrust - limit), color=BEST, linewidth=0.9)
    close.axhline(0.0, color=LIMIT, linewidth=0.8)
    close.set(xlim=(1.0, 1.6), ylim=(-20.0, 5.0))
    knots = best.trajectory.times
    samples = np.concatenate([a + (b - a) * np.arange(24) / 24 for a, b in pairwise(knots)])
    close.plot(samples, np.full(len(samples), 2.5), "|", color=INK, markersize=4)
    finish(close, "time [s]", "above the limit [mN]", legend=False)
    save(figure, "proof")


def main() -> None:
    totals: list[float] = []

    def told(words: str) -> None:
        totals.append(float(re.findall(r"([\d.]+) s", words)[-1]))

    paper = plan_course(COURSE, VEHICLE, Limits.of(VEHICLE, "rotors", 0.0))
    fast = plan_near_optimal(COURSE, VEHICLE, limits_of(VEHICLE, "rotors", 0.0), "fast")
    best = plan_near_optimal(COURSE, VEHICLE, limits_of(VEHICLE, "rotors", 0.0), "best", told)
    draw_closed_form()
    draw_pieces(paper, best)
    draw_unknowns()
    draw_forces({"paper": paper, "fast": fast, "best": best})
    draw_search(totals)
    draw_between_samples(best)


if __name__ == "__main__":
    main()

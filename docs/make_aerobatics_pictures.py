"""The gallery of docs/aerobatics.md, made by the planner itself: python docs/make_aerobatics_pictures.py [FOLDER]"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from halfroll.manoeuvres.library import (
    Backflip,
    FigureEight,
    Flip,
    HalfRoll,
    InvertedLeg,
    Manoeuvre,
    PowerLoop,
    SplitS,
    Window,
)
from halfroll.missions.mission import PlanOptions, Waypoint
from halfroll.planner.near_optimal import plan_in_mode
from halfroll.planner.plan import Plan
from halfroll.vehicle import load_vehicle

VP = load_vehicle("mit-vp")
START = Waypoint((0.0, 0.0, 6.0))
# Each with the horizontal axis it is seen along: 0 north, 1 west; None from above.
GALLERY: list[tuple[Manoeuvre, int | None]] = [
    (HalfRoll(at=0, kind="half_roll"), 1),
    (Flip(at=0, kind="flip", axis="pitch"), 0),
    (Backflip(at=0, kind="backflip"), 0),
    (InvertedLeg(at=0, kind="inverted_leg"), 0),
    (SplitS(at=0, kind="split_s"), 1),
    (PowerLoop(at=0, kind="power_loop"), 0),
    (Window(at=0, kind="window", roll_deg=60.0), 1),
    (FigureEight(at=0, kind="figure_eight"), None),
]
ARROWS = 25
_ARROW_M = 0.12  # of the picture's width


def draw(plan: Plan, name: str, seen: int | None, folder: Path) -> None:
    """The path, with the body's z in equal steps of time; below, tilt and rotor thrusts."""
    t = np.linspace(0.0, plan.T, 1001)
    out, position = plan.outputs(t), plan.at(t).position
    across, up = (0, 1) if seen is None else (seen, 2)
    fig, (path, time) = plt.subplots(2, 1, figsize=(6.0, 6.5), height_ratios=(3, 2), layout="constrained")
    path.plot(position[:, across], position[:, up], color="tab:gray", lw=1.0)
    few = np.linspace(0, 1000, ARROWS).astype(int)
    size = _ARROW_M * max(np.ptp(position[:, across]), np.ptp(position[:, up]))
    path.quiver(
        position[few, across], position[few, up], size * out.thrust_axis[few, across], size * out.thrust_axis[few, up],
        np.where(out.thrust[few] < 0.0, 1.0, 0.0), cmap="coolwarm", clim=(0.0, 1.0), angles="xy", scale_units="xy",
        scale=1.0, width=0.006,
    )  # fmt: skip
    axes = ("north [m]", "west [m]", "up [m]")
    path.set(title=f"{name.replace('_', ' ')}: {plan.T:.2f} s", xlabel=axes[across], ylabel=axes[up], aspect="equal")
    path.margins(0.15)
    time.plot(t, out.rotors, lw=0.8)
    time.set(xlabel="t [s]", ylabel="rotors [N]", ylim=(-3.2, 3.2))
    tilt = time.twinx()
    tilt.plot(t, np.degrees(np.arccos(np.clip(out.thrust_axis[:, 2], -1.0, 1.0))), color="black", ls="--")
    tilt.set(ylabel="tilt of the thrust axis [deg]", ylim=(0.0, 190.0))
    fig.savefig(folder / f"manoeuvre_{name}.png", dpi=90)
    plt.close(fig)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for manoeuvre, seen in GALLERY:
        plan = plan_in_mode((START, *manoeuvre.waypoints(START)), VP, PlanOptions())
        draw(plan, manoeuvre.kind, seen, folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures")

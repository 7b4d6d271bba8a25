"""Pictures of docs/planner.md about limits, made by the planner itself: python docs/make_limit_pictures.py [FOLDER]"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from halfroll.missions.mission import Fence, PlanOptions, Rules, Waypoint, Yaw
from halfroll.planner.corridor import walls
from halfroll.planner.limits import Limits
from halfroll.planner.near_optimal import plan_in_mode, plan_near_optimal
from halfroll.planner.plan import Plan
from halfroll.vehicle import load_vehicle

FP, VP = load_vehicle("mit-fp"), load_vehicle("mit-vp")
SQUARE = [(0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1), (0, 0, 1)]
FIELD = Fence(True, ((-1, -2), (11, -2), (11, 1.905), (-1, 1.905)), "field")
POND = Fence(False, ((4.5, 0.6), (5.5, 0.6), (5.5, 3), (4.5, 3)), "pond")
ROUND = [(0, 0, 1), (2.5, 1.9, 1), (5, 0.2, 1), (7.5, 1.9, 1), (10, 0, 1)]


def points(positions: list[tuple[float, float, float]]) -> list[Waypoint]:
    return [Waypoint(position, item=i) for i, position in enumerate(positions)]


def commands(plan: Plan) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, thrusts (n, 4) of fixed-pitch rotors, and the commands they need."""
    t = np.linspace(0.0, plan.T, 4000)
    thrust = plan.outputs(t).rotors
    speed = np.sqrt(thrust)
    return t, thrust, np.maximum(speed + plan.vehicle.rotor.lag_s * np.gradient(speed, t, axis=0), 0.0) ** 2


def rotor_rate(axes: list[Axes]) -> None:
    limits = Limits.of(FP)
    for at, now, title in zip(
        axes,
        (replace(limits, drive=None), limits),
        ("thrust limits alone", "and what the motors can follow"),
        strict=True,
    ):
        plan = plan_near_optimal(points(SQUARE), FP, now, "fast")
        t, thrust, command = commands(plan)
        at.plot(t, command[:, 0], color="tab:red", lw=0.8, label="command that this needs")
        at.plot(t, thrust[:, 0], color="tab:blue", label="thrust of rotor 1")
        at.axhspan(limits.rotor_min, limits.rotor_max, color="tab:green", alpha=0.12)
        at.set(title=f"{title}: {plan.T:.2f} s", xlabel="t [s]", ylim=(-0.5, 6))
    axes[0].set_ylabel("[N]")
    axes[0].legend(loc="upper right")


def fence(at: Axes) -> None:
    free = plan_in_mode(points(ROUND), VP, PlanOptions("fast"))
    fenced = plan_in_mode(points(ROUND), VP, PlanOptions("fast"), Rules((FIELD, POND)))
    at.add_patch(Polygon(FIELD.corners, fill=False, color="tab:green", lw=2))
    at.add_patch(Polygon(POND.corners, color="tab:red", alpha=0.4))
    for x, y, offset in walls(ROUND[1], ROUND[2], [FIELD, POND]):
        foot, along = offset * np.array([x, y]), np.array([-y, x])
        at.plot(*np.array([foot - 20 * along, foot + 20 * along]).T, color="gray", ls=":", lw=1)
    for plan, colour, name in ((free, "tab:orange", "no fence"), (fenced, "tab:blue", "inside the fence")):
        path = plan.trajectory.at(np.linspace(0, plan.T, 2000))
        at.plot(path[:, 0], path[:, 1], color=colour, label=f"{name}: {plan.T:.2f} s")
    at.plot(*np.array(ROUND)[:, :2].T, "k.")
    at.set(xlim=(-1.5, 11.5), ylim=(-2.5, 3.2), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    at.set_title("dotted: the walls of the leg from the second to the third point")
    at.legend(loc="lower left")


def nose(axes: list[Axes]) -> None:
    for at, yaw in zip(axes, (Yaw("free"), Yaw("path"), Yaw("point", (2.0, 2.0))), strict=True):
        plan = plan_in_mode(points(SQUARE), VP, PlanOptions("fast", yaw=yaw))
        path = plan.trajectory.at(np.linspace(0, plan.T, 2000))
        at.plot(path[:, 0], path[:, 1], color="tab:blue")
        here = plan.trajectory.at(np.linspace(0, plan.T, 28))
        at.quiver(here[:, 0], here[:, 1], np.cos(here[:, 3]), np.sin(here[:, 3]), color="tab:red", width=0.006)
        at.set(aspect="equal", title=f"yaw {yaw.rule}: {plan.T:.2f} s", xlabel="x [m]")


def arrival(at: Axes) -> None:
    course = points(SQUARE)
    for time_s, colour in ((None, "tab:orange"), (3.0, "tab:blue")):
        plan = plan_in_mode([*course[:2], replace(course[2], time_s=time_s), *course[3:]], VP, PlanOptions("fast"))
        t = np.linspace(0, plan.T, 2000)
        at.plot(t, np.linalg.norm(plan.trajectory.at(t, 1)[:, :3], axis=1), color=colour)
        at.plot(plan.times_s[2], 0, "o", color=colour, label=f"third point at {plan.times_s[2]:.2f} s")
    at.set(xlabel="t [s]", ylabel="speed [m/s]")
    at.legend()


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    pictures = {
        "limit_rotor_rate": (2, rotor_rate),
        "limit_fence": (1, fence),
        "limit_yaw": (3, nose),
        "limit_times": (1, arrival),
    }
    for name, (columns, draw) in pictures.items():
        figure, axes = plt.subplots(1, columns, figsize=(9, 3.4), layout="constrained", sharey=columns > 1)
        draw(axes)
        figure.savefig(folder / f"{name}.png", dpi=80)
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures")

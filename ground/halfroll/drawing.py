"""What all pictures share: colours, style, a few panels; and the picture of a plan.

Why: matplotlib is met here and in report.py alone, and only when something is drawn. It knows columns of numbers, no
plan and no log, so whatever has numbers can draw itself.
"""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfroll.body_axes import body_up

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Palette:
    ink: str
    faint: str
    flown: str
    planned: str
    alert: str
    x: str
    y: str
    z: str

    @property
    def axes(self) -> tuple[str, str, str]:
        return self.x, self.y, self.z


ON_PAPER = Palette("#1d2433", "#d5dae3", "#2563eb", "#8a94a6", "#dc2626", "#0d9488", "#d97706", "#7c3aed")
# Stand-ins that a page replaces by its own colours, so one figure suits a dark and a light page.
ON_PAGE = Palette(*(f"#0a0b0{i}" for i in range(8)))  # no other colour of a figure looks like these


def style(colours: Palette) -> Any:
    return {
        "svg.fonttype": "none",
        "svg.hashsalt": "halfroll",
        "font.size": 9.5,
        "font.family": "sans-serif",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.edgecolor": colours.faint,
        "axes.labelcolor": colours.ink,
        "grid.color": colours.faint,
        "grid.linewidth": 0.6,
        "text.color": colours.ink,
        "xtick.color": colours.ink,
        "ytick.color": colours.ink,
        "xtick.major.size": 0,
        "ytick.major.size": 0,
        "legend.frameon": False,
        "legend.handlelength": 1.4,
        "lines.linewidth": 1.5,
        "figure.facecolor": "none",
        "axes.facecolor": "none",
    }


def save_figure(path: Path, size: tuple[float, float], draw: Callable[[Figure, Palette], None]) -> None:
    """A picture of this size [inch] on white, drawn by `draw`."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(style(ON_PAPER)):
        figure = Figure(figsize=size, layout="constrained", facecolor="white")
        draw(figure, ON_PAPER)
        figure.savefig(path, dpi=90, facecolor="white", metadata={"Software": None})


def draw_thrust_limits(axes: Axes, low: float, high: float, colours: Palette) -> None:
    axes.axhline(high, color=colours.alert, lw=1.0, ls=(0, (1, 1.5)), label="limit")
    axes.axhline(low, color=colours.alert, lw=1.0, ls=(0, (1, 1.5)))
    axes.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))


def legend(axes: Axes) -> None:
    """Above the panel, where it hides nothing."""
    count = len(axes.get_legend_handles_labels()[0])
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), borderaxespad=0.0, ncols=count, columnspacing=1.2)


def tilt_deg(q: FloatArray) -> FloatArray:
    return np.asarray(np.degrees(np.arccos(np.clip(body_up(q)[:, 2], -1.0, 1.0))), dtype=np.float64)


def angle_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """(N,) angle [rad] from attitude a to b; q and -q are one attitude."""
    a = a / np.linalg.norm(a, axis=1, keepdims=True)
    return np.asarray(2 * np.arccos(np.clip(np.abs(np.sum(a * b, axis=1)), 0.0, 1.0)), dtype=np.float64)


def plan_figure(columns: Mapping[str, Any], points: FloatArray, thrust_N: tuple[float, float], title: str) -> Figure:
    """A plan before it is flown: path, speed, tilt and rotor thrusts.

    columns: samples as of Plan.sample; points (n, 3): waypoints in W; thrust_N: least and largest of a rotor.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    colours, t = ON_PAPER, columns["t_s"]
    with rc_context(style(colours)):
        figure = Figure(figsize=(11, 5.6), layout="constrained", facecolor="white")
        space = figure.add_gridspec(3, 2, width_ratios=(1.2, 1.0))
        path: Any = figure.add_subplot(space[:, 0], projection="3d")
        path.plot(columns["x_m"], columns["y_m"], columns["z_m"], color=colours.planned)
        path.scatter(*points.T, color=colours.ink, s=14)
        path.set(xlabel="north [m]", ylabel="west [m]", zlabel="up [m]", aspect="equal")
        speed, tilt, thrusts = (figure.add_subplot(space[row, 1]) for row in range(3))
        speed.plot(t, np.linalg.norm([columns[name] for name in ("vx_m_s", "vy_m_s", "vz_m_s")], axis=0))
        tilt.plot(t, tilt_deg(np.stack([columns[name] for name in ("q_w", "q_x", "q_y", "q_z")], axis=1)))
        for i in (1, 2, 3, 4):
            thrusts.plot(t, columns[f"f{i}_N"], linewidth=1.0)
        draw_thrust_limits(thrusts, *thrust_N, colours)
        for axes, label in ((speed, "speed [m/s]"), (tilt, "tilt [°]"), (thrusts, "rotor thrust [N]")):
            axes.set(ylabel=label, xlim=(t[0], t[-1]))
        thrusts.set_xlabel("time [s]")
        figure.suptitle(title)
    return figure


def inline_picture(figure: Figure) -> str:
    """An <img> that needs no file beside it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=80, metadata={"Software": None})
    return f'<img alt="" style="max-width:100%" src="data:image/png;base64,{b64encode(buffer.getvalue()).decode()}">'

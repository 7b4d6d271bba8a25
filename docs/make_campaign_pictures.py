"""Pictures and tables of docs/campaigns.md, flown anew: python docs/make_campaign_pictures.py [FOLDER]

Each cell of a table is a campaign of its own: one vehicle, one margin, one level of what is wrong.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

from halfroll.campaign.engines import Threads
from halfroll.campaign.prepared import Prepared, prepare
from halfroll.campaign.space import make_space
from halfroll.campaign.statistics import interval

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "campaigns.md"
RUNS = 60
VEHICLES = {"mit-vp": "variable pitch", "mit-fp": "fixed pitch"}
MARGINS = (0.1, 0.2, 0.3)


@dataclass(frozen=True)
class Wrong:
    """Something that is not as planned, and how much of it."""

    name: str
    key: str
    levels: tuple[float, ...]
    unit: str
    shown: float = 1.0  # of a level, in `unit`
    times: bool = False

    def label(self, level: float) -> str:
        return f"{self.shown * (level - 1.0 if self.times else level):+g} {self.unit}".replace("+0 ", "0 ")


WRONGS = (
    Wrong("mass", "vehicle.mass_kg", (0.8, 0.9, 1.0, 1.1, 1.2, 1.3), "%", 100.0, times=True),
    Wrong("delay of the link, each way", "link.delay_s", (0.0, 0.01, 0.02, 0.04, 0.06), "ms", 1000.0),
    Wrong("head wind", "scenario.wind.mean_m_s.0", (0.0, -2.0, -4.0, -6.0, -8.0), "m/s"),
)


@dataclass(frozen=True)
class Cell:
    succeeded: int
    runs: int
    miss_m: float  # 95 % miss their waypoints by less

    def __str__(self) -> str:
        low, high = interval(self.succeeded, self.runs)
        return f"{self.succeeded}/{self.runs} ({100 * low:.0f}–{100 * high:.0f} %), {100 * self.miss_m:.0f} cm"


def prepared(vehicle: str, margin: float, wrong: Wrong, seed: int = 1) -> Prepared:
    space = {
        "name": f"{vehicle}, margin {margin:.0%}, {wrong.name}",
        "mission": "course_d.toml",
        "vehicle": vehicle,
        "scenario": "nominal",
        "sampling": "grid",
        "seed": seed,
        "plan": {"mode": "fast", "margin": margin},
        "vary": {wrong.key: {"choice": list(wrong.levels), "times": wrong.times}},
    }
    return prepare(make_space(space, ROOT / "examples"))


def flown(chosen: Prepared, levels: int, runs: int) -> list[Cell]:
    """A cell for each level."""
    rows = sorted(Threads().fly_runs(chosen, range(levels * runs)), key=lambda row: int(row["run"]))
    cells = []
    for i in range(levels):
        mine = rows[i::levels]
        miss = np.array([row["waypoint_miss_max_m"] for row in mine])
        cells.append(
            Cell(sum(row["succeeded"] for row in mine), runs, float(np.quantile(np.nan_to_num(miss, nan=99.0), 0.95)))
        )
    return cells


def table(wrong: Wrong, found: dict[tuple[str, float], list[Cell]], times: dict[tuple[str, float], float]) -> str:
    lines = [f"| {wrong.name} | " + " | ".join(wrong.label(level) for level in wrong.levels) + " |"]
    lines.append("|---" * (len(wrong.levels) + 1) + "|")
    for (vehicle, margin), cells in found.items():
        head = f"`{vehicle}`, margin {margin:.0%}, T {times[vehicle, margin]:.2f} s"
        lines.append(f"| {head} | " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def draw(ax: plt.Axes, wrong: Wrong, found: dict[tuple[str, float], list[Cell]]) -> None:
    colours = {"mit-vp": "#2563eb", "mit-fp": "#dc2626"}
    for (vehicle, margin), cells in found.items():
        rate = np.array([cell.succeeded / cell.runs for cell in cells])
        bounds = np.array([interval(cell.succeeded, cell.runs) for cell in cells])
        x = [wrong.shown * (level - 1.0 if wrong.times else level) for level in wrong.levels]
        style = {0.1: "-", 0.2: "--", 0.3: ":"}[margin]
        ax.errorbar(
            x, rate, np.abs(bounds - rate[:, None]).T, color=colours[vehicle], ls=style, marker="o", ms=3, capsize=2,
            lw=1.3, label=f"{VEHICLES[vehicle]}, margin {margin:.0%}",
        )  # fmt: skip
    ax.set(xlabel=f"{wrong.name} [{wrong.unit}]", ylim=(-0.03, 1.03))
    ax.grid(alpha=0.3)


def put(page: str, name: str, text: str) -> str:
    """Between the marks of that name."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    return re.sub(f"{begin}.*?{end}", lambda _: f"{begin}\n{text}\n{end}", page, flags=re.DOTALL)


def main() -> None:
    pictures = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures"
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), sharey=True, layout="constrained")
    page = PAGE.read_text()
    for ax, wrong in zip(axes, WRONGS, strict=True):
        found, times = {}, {}
        for vehicle in VEHICLES:
            for margin in MARGINS:
                chosen = prepared(vehicle, margin, wrong)
                times[vehicle, margin] = chosen.planned.plan.T
                found[vehicle, margin] = flown(chosen, len(wrong.levels), RUNS)
        draw(ax, wrong, found)
        page = put(page, wrong.name, table(wrong, found, times))
    axes[0].set_ylabel("success")
    axes[-1].legend(fontsize=8)
    figure.savefig(pictures / "robustness.png", dpi=110)
    if pictures == ROOT / "docs" / "pictures":
        PAGE.write_text(page)


if __name__ == "__main__":
    main()

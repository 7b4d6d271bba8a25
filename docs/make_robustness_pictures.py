"""Picture and tables of docs/robustness.md: python docs/make_robustness_pictures.py [--fly] [FOLDER]

They are drawn from docs/robustness.json, which --fly makes anew (about five minutes of two cores) with the page's
tables. A cell is a campaign of its own: one contender, one margin, one level of one thing that is wrong.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from halfroll.campaign.engines import Threads
from halfroll.campaign.prepared import Prepared, prepare
from halfroll.campaign.space import Space, make_space
from halfroll.campaign.statistics import interval, kind_of
from halfroll.vehicle import load_vehicle

DOCS = Path(__file__).parent
FLOWN, PAGE = DOCS / "robustness.json", DOCS / "robustness.md"
RUNS = 100  # of a cell


@dataclass(frozen=True)
class Contender:
    """A vehicle, and for whose rotors its plan is made."""

    name: str
    vehicle: str
    planned_for: str
    colour: str  # Okabe and Ito's, told apart by everyone; the marker says it again
    marker: str

    @property
    def integral(self) -> dict[str, float]:
        """Integral action as quick, measured by the proportional one, in all: 3 s horizontally, 1.5 s vertically."""
        params = load_vehicle(self.vehicle).params
        return {"params.POS_KI_XY": params.get("POS_KP_XY", 12.0) / 3.0, "params.POS_KI_Z": 8.0}


CONTENDERS = (
    Contender("variable pitch", "mit-vp", "mit-vp", "#0072B2", "o"),
    Contender("variable pitch, fixed pitch's plan", "mit-vp", "mit-fp", "#009E73", "s"),
    Contender("fixed pitch", "mit-fp", "mit-fp", "#D55E00", "^"),
)


@dataclass(frozen=True)
class Wrong:
    """Something that neither plan nor autopilot knows, and how much of it."""

    name: str
    key: str
    levels: tuple[float, ...]  # as a person reads them
    unit: str
    scale: float = 1.0  # of a level, to SI

    def setting(self, level: float, vehicle: str) -> float:
        if self.key == "vehicle.mass_kg":
            return load_vehicle(vehicle).mass_kg * (1.0 + self.scale * level)
        if self.key == "vehicle.rotor.delay_s":
            return load_vehicle(vehicle).rotor.delay_s + self.scale * level
        return self.scale * level


WRONGS = (
    Wrong("mass error", "vehicle.mass_kg", (-20, -10, 0, 10, 20, 30), "%", 0.01),
    Wrong("delay of the link, each way", "link.delay_s", (0, 10, 20, 40, 60), "ms", 0.001),
    Wrong("more delay of the rotors", "vehicle.rotor.delay_s", (0, 5, 10, 20, 30), "ms", 0.001),
    Wrong("wind against the course", "scenario.wind.mean_m_s.0", (0, 2, 4, 6, 8), "m/s", -1.0),
)
MARGIN = 0.2  # of WRONGS
MARGINS = (0.0, 0.05, 0.1, 0.15, 0.2)
HEAVIER = Wrong("mass error", "vehicle.mass_kg", (0, 5, 10, 15, 20), "%", 0.01)


@dataclass(frozen=True)
class Cell:
    contender: Contender
    margin: float
    wrong: Wrong
    level: float

    @property
    def name(self) -> str:
        return (
            f"{self.contender.name}, margin {100 * self.margin:g} %, {self.wrong.name} {self.level:g} {self.wrong.unit}"
        )


def cells() -> Iterator[Cell]:
    for wrong in WRONGS:
        for contender in CONTENDERS:
            yield from (Cell(contender, MARGIN, wrong, level) for level in wrong.levels)
    for contender in (CONTENDERS[0], CONTENDERS[2]):
        for margin in MARGINS:
            for level in HEAVIER.levels:
                cell = Cell(contender, margin, HEAVIER, level)
                if margin != MARGIN or level not in WRONGS[0].levels:
                    yield cell


def space_of(vehicle: str, margin: float, settings: dict[str, float]) -> Space:
    """All that the world can do, inertia off by up to a tenth, each rotor's thrust by up to a twentieth."""
    varied = {f"scenario.fault.{rotor}.share": {"uniform": [0.95, 1.05]} for rotor in range(4)}
    return make_space(
        {
            "name": "robustness",
            "mission": "course_d.toml",
            "vehicle": vehicle,
            "scenario": "campaign_air.toml",
            "sampling": "random",
            "seed": 1,
            "plan": {"mode": "fast", "margin": margin},
            "set": {"scenario.wind.mean_m_s.0": 0.0, **settings},
            "vary": {"vehicle.inertia_kg_m2": {"uniform": [0.9, 1.1], "times": True}, **varied},
        },
        DOCS.parent / "examples",
    )


@lru_cache(None)
def planned(vehicle: str, margin: float) -> Prepared:
    return prepare(space_of(vehicle, margin, {}))


def prepared(cell: Cell) -> Prepared:
    who = cell.contender
    settings = {**who.integral, cell.wrong.key: cell.wrong.setting(cell.level, who.vehicle)}
    own, other = planned(who.vehicle, cell.margin), planned(who.planned_for, cell.margin)
    return replace(own, space=space_of(who.vehicle, cell.margin, settings), planned=other.planned)


def flown(cell: Cell) -> dict[str, Any]:
    chosen = prepared(cell)
    rows = sorted(Threads().fly_runs(chosen, range(RUNS)), key=lambda row: int(row["run"]))
    return {
        "T_s": round(chosen.planned.plan.T, 3),
        "failed": [row["run"] for row in rows if not row["succeeded"]],
        "reasons": dict(Counter(kind_of(row["why"]) for row in rows if not row["succeeded"]).most_common()),
    }


def told(found: dict[str, Any], cell: Cell) -> str:
    good = RUNS - len(found[cell.name]["failed"])
    low, high = interval(good, RUNS)
    return f"{good} ({100 * low:.0f}–{100 * high:.0f})"


def tables(found: dict[str, Any]) -> dict[str, str]:
    """By name, as they stand in the page."""
    made = {}
    for wrong in WRONGS:
        lines = [_head(f"{wrong.name} [{wrong.unit}]", wrong.levels)]
        for who in CONTENDERS:
            row = [Cell(who, MARGIN, wrong, level) for level in wrong.levels]
            lines.append(_line(f"{who.name}, {found[row[0].name]['T_s']:.2f} s", [told(found, cell) for cell in row]))
        made[wrong.name] = "\n".join(lines)
    lines = [_head("margin, T, and mass error [%]", HEAVIER.levels)]
    for who in (CONTENDERS[0], CONTENDERS[2]):
        for margin in MARGINS:
            row = [Cell(who, margin, HEAVIER, level) for level in HEAVIER.levels]
            head = f"{who.name}, {100 * margin:g} %, {found[row[0].name]['T_s']:.2f} s"
            lines.append(_line(head, [told(found, cell) for cell in row]))
    made["what margin buys"] = "\n".join(lines)
    return made


def _head(first: str, levels: tuple[float, ...]) -> str:
    return _line(first, [f"{level:g}" for level in levels]) + "\n" + "|---" * (len(levels) + 1) + "|"


def _line(first: str, rest: list[str]) -> str:
    return "| " + " | ".join([first, *rest]) + " |"


def draw_wrong(ax: Axes, wrong: Wrong, found: dict[str, Any]) -> None:
    for who in CONTENDERS:
        row = [found[Cell(who, MARGIN, wrong, level).name] for level in wrong.levels]
        _points(ax, wrong.levels, row, color=who.colour, marker=who.marker, label=who.name)
    ax.set(xlabel=f"{wrong.name} [{wrong.unit}]", ylim=(-0.03, 1.03))
    ax.grid(alpha=0.3)


def draw_margins(ax: Axes, who: Contender, found: dict[str, Any]) -> None:
    for margin, line in zip(MARGINS, (":", (0, (1, 3)), "-.", "--", "-"), strict=True):
        row = [found[Cell(who, margin, HEAVIER, level).name] for level in HEAVIER.levels]
        label = f"margin {100 * margin:g} %, {row[0]['T_s']:.2f} s"
        _points(ax, HEAVIER.levels, row, color=who.colour, marker=who.marker, ls=line, label=label)
    ax.set(xlabel=f"{HEAVIER.name} [%]", ylim=(-0.03, 1.03), title=who.name)
    ax.grid(alpha=0.3)
    ax.legend(fontsize=7)


def _points(ax: Axes, levels: tuple[float, ...], row: list[dict[str, Any]], **style: Any) -> None:
    good = np.array([RUNS - len(cell["failed"]) for cell in row])
    bounds = np.array([interval(int(count), RUNS) for count in good])
    error = np.abs(bounds - good[:, None] / RUNS).T
    ax.errorbar(levels, good / RUNS, error, ms=4, capsize=2, lw=1.3, **style)


def draw(found: dict[str, Any], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(1, len(WRONGS), figsize=(14, 3.6), sharey=True, layout="constrained")
    for ax, wrong in zip(axes, WRONGS, strict=True):
        draw_wrong(ax, wrong, found)
    axes[0].set_ylabel("success")
    axes[0].legend(fontsize=7, loc="lower left")
    figure.savefig(folder / "robustness.png", dpi=80)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True, layout="constrained")
    for ax, who in zip(axes, (CONTENDERS[0], CONTENDERS[2]), strict=True):
        draw_margins(ax, who, found)
    axes[0].set_ylabel("success")
    figure.savefig(folder / "robustness_margin.png", dpi=80)


def with_tables(page: str, found: dict[str, Any]) -> str:
    for name, text in tables(found).items():
        begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
        page = re.sub(f"{begin}.*?{end}", lambda _, b=begin, t=text, e=end: f"{b}\n{t}\n{e}", page, flags=re.DOTALL)
    return page


def main(words: list[str]) -> None:
    if "--fly" in words:
        words.remove("--fly")
        found = {cell.name: flown(cell) for cell in cells()}
        lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(cell)}" for name, cell in found.items())
        FLOWN.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
        PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8"), found), encoding="utf-8")
    draw(json.loads(FLOWN.read_text(encoding="utf-8")), Path(words[0]) if words else DOCS / "pictures")


if __name__ == "__main__":
    main(sys.argv[1:])

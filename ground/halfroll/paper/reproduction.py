"""The paper's parts by name, made again one after another: claims, pictures, and a page that shows both.

Why: the one list of what there is; the command, the tests and the docs read it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from pathlib import Path

from halfroll.drawing import save_figure
from halfroll.errors import InputError
from halfroll.paper.claims import Claim, shown
from halfroll.paper.part import Part

PARTS = {
    "fig1": "fig1_frames",
    "fig2": "fig2_free_fall_flip",
    "fig3": "fig3_backflip",
    "fig4": "fig4_rotor_forces",
    "fig5": "fig5_one_metre_up",
    "fig6": "fig6_overshoot",
    "fig7": "fig7_attitude_step",
    "fig8": "fig8_flip_snapshots",
    "fig9": "fig9_backflip_snapshots",
    "t1": "t1_rates",
    "t2": "t2_thrust_range",
    "t3": "t3_braking",
    "t4": "t4_thrust_rise",
    "t5": "t5_shortest_roll",
}

Progress = Callable[[str, "float | None"], None]


def chosen(names: Sequence[str]) -> list[str]:
    """The names as they are in PARTS, in the paper's order; all where none is given. Raises InputError."""
    wanted = [name.lower() for name in names]
    for name, lowered in zip(names, wanted, strict=True):
        if lowered not in PARTS:
            raise InputError(f"{name!r} is no part of the paper; there are fig1 to fig9 and t1 to t5")
    return [name for name in PARTS if not wanted or name in wanted]


def part(name: str, seeds: int) -> Part:
    """Made again; flights that parts share are flown once."""
    made: Part = import_module(f"halfroll.paper.{PARTS[name]}").reproduce(seeds)
    return made


def reproduce(
    names: Iterable[str], folder: Path, seeds: int, progress: Progress = lambda phase, fraction: None
) -> list[Claim]:
    """Every claim of these parts; their pictures and a page, README.md, are written into the folder.

    progress(phase, fraction or None) is called before each part. Raises OSError if the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts: dict[str, Part] = {}
    for name in names:
        progress(f"{name}: {PARTS[name].partition('_')[2].replace('_', ' ')}", None)
        parts[name] = part(name, seeds)
        draw = parts[name].draw
        if draw is not None:
            save_figure(folder / f"{name}.png", parts[name].size, draw)
    (folder / "README.md").write_text(_page(parts, seeds), encoding="utf-8")
    return [claim for made in parts.values() for claim in made.claims]


def _page(parts: dict[str, Part], seeds: int) -> str:
    """Markdown: each part with its picture and its claims."""
    claims = [claim for made in parts.values() for claim in made.claims]
    lines = [
        "# The paper, reproduced",
        "",
        f"Written by `halfroll paper`: {sum(claim.holds for claim in claims)} of {len(claims)} claims hold. What is "
        f"flown is flown {seeds} times in scenario `nominal`, with sensor noise, late motion capture, drag, the "
        "estimator, 100 references a second over MAVLink and the firmware at 1 kHz; the worst flight counts.",
    ]
    for name, made in parts.items():
        lines += ["", f"## {made.title}", ""]
        if made.draw is not None:
            lines += [f"![{made.title}]({name}.png)", "", f"*{made.caption}*", ""]
        lines += ["| | claim | paper | here | tolerance | holds |", "|---|---|---|---|---|---|"]
        for claim in made.claims:
            what = f"{claim.what} ({claim.note})" if claim.note else claim.what
            cells = (claim.id, what, shown(claim.paper), f"{shown(claim.got)} {claim.unit}", claim.tolerance)
            lines.append(f"| {' | '.join(cell.strip() for cell in cells)} | {'yes' if claim.holds else '**no**'} |")
    return "\n".join(lines) + "\n"

"""Figures over a replay: position error and rotor commands of the whole flight, and words, at the player's time.

Why: a replay has no Python behind it, so its figures are drawn by the page itself, from a few numbers a frame.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib import resources
from string import Template
from typing import Any

from halfroll.viewer import colours
from halfroll.viewer.moments import Moment, Setting
from halfroll.viewer.panels import ROTORS

_LIGHT, _DARK = ("#1c2333", "rgba(255,255,255,0.8)"), ("#e8ebf2", "rgba(27,30,38,0.8)")


def with_figures(page: str, setting: Setting, moments: Sequence[Moment], dark: bool) -> str:
    """The page of a player whose recording begins with the first of the moments, and figures over it."""
    ink, paper = _DARK if dark else _LIGHT
    fragment = resources.files("halfroll.viewer").joinpath("replay_figures.html").read_text(encoding="utf-8")
    flight = json.dumps(_flight(setting, moments), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    figures = Template(fragment).substitute(ink=ink, paper=paper, flight=flight)
    end = page.rindex("</body>")
    return page[:end] + figures + page[end:]


def _flight(setting: Setting, moments: Sequence[Moment]) -> dict[str, Any]:
    panels = []
    errors = [None if each.error_m is None else round(1e3 * each.error_m, 1) for each in moments]
    if any(errors):
        panels.append({"title": "position error, mm", "digits": 0, "limits": [], "lines": [{"name": "", "y": errors}]})
    if any(each.rotor_N is not None for each in moments):
        forces = [(None,) * 4 if each.rotor_N is None else each.rotor_N.round(2).tolist() for each in moments]
        lines = [{"name": name, "y": column} for name, column in zip(ROTORS, zip(*forces, strict=True), strict=True)]
        panels.append({"title": "rotor command, N", "digits": 1, "limits": list(setting.thrust_N), "lines": lines})
    return {
        "t": [round(each.t_s, 3) for each in moments],
        "words": [words_of(each) for each in moments],
        "colours": colours.SERIES,
        "limit": colours.LIMIT,
        "panels": panels,
    }


def words_of(moment: Moment) -> str:
    words = [f"{moment.t_s:.1f} s", moment.mode, f"{moment.speed:.1f} m/s"]
    if moment.error_m is not None:
        words.append(f"{1e3 * moment.error_m:.0f} mm off")
    return " · ".join(word for word in words if word)

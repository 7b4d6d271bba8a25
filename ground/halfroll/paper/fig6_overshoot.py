"""Fig 6: the same climb by variable pitch, and with the pitch locked.

Why: motors that must change their speed cannot stop where blades that change their pitch do.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from halfroll.drawing import Palette, legend
from halfroll.paper import paths
from halfroll.paper.claims import above, below, between
from halfroll.paper.flights import START_M, Flights, stretched_climbs
from halfroll.paper.part import Part

_NO_LEAD = {"params.ACT_LEAD": 0.0}


def reproduce(seeds: int) -> Part:
    vp, vp_late = stretched_climbs("mit-vp", seeds), stretched_climbs("mit-vp", seeds, _NO_LEAD)
    fp = stretched_climbs("mit-fp", seeds, _NO_LEAD)
    coasting = stretched_climbs("mit-fp", seeds, {**_NO_LEAD, "rotor.lag_down_s": 0.14})
    overshoots = {
        name: _overshoots(flights) for name, flights in (("vp", vp), ("late", vp_late), ("fp", fp), ("coast", coasting))
    }
    ratio = np.median(overshoots["fp"]) / max(max(overshoots["vp"]), 0.1)
    path = f"path of Fig 5 stretched to {paths.CLIMB_S:g} s"
    worst = f"{path}; worst of {seeds} flights"
    both = f"{path}; motors 0.12 s, no lead, as the paper; median of {seeds} flights"
    claims = (
        below("6a", "variable pitch overshoots", max(overshoots["vp"]), 2.0, "%", paper=1.0, note=worst),
        below("6a.position", "and leaves the plan by", vp.worst_position, 0.02, "m", note=worst),
        below(
            "6a.no-lead",
            "variable pitch overshoots without actuator lead",
            max(overshoots["late"]),
            8.0,
            "%",
            paper=1.0,
            note=worst,
        ),
        between(
            "6b",
            "pitch locked, the same references: overshoots",
            np.median(overshoots["fp"]),
            45.0,
            70.0,
            "%",
            paper=60.0,
            note=both,
        ),
        between(
            "6b.coasting",
            "the same, motors that slow down in 0.14 s",
            np.median(overshoots["coast"]),
            45.0,
            70.0,
            "%",
            paper=60.0,
        ),
        above(
            "6c",
            "fixed over variable pitch",
            float(ratio),
            5.0,
            paper=60.0,
            note="variable pitch counted as 0.1 % at least",
        ),
    )
    return Part(
        "Fig 6: overshoot",
        claims,
        "The same references flown by both vehicles, with sensor noise.",
        lambda figure, colours: _draw(figure, colours, vp, vp_late, fp),
        (11.0, 4.8),
    )


def _overshoots(flights: Flights) -> list[float]:
    """[%] of the one metre, each flight."""
    return flights.each(lambda flown: 100.0 * float(flown.p_WB[:, 2].max() - START_M - paths.CLIMB_HEIGHTS_M[-1]))


def _draw(figure: Any, colours: Palette, vp: Flights, vp_late: Flights, fp: Flights) -> None:
    height, thrust = figure.subplots(1, 2)
    plan = vp.plan
    t = np.linspace(0.0, plan.T + 2.0, 1001)
    height.plot(
        t, plan.trajectory.at(t)[:, 2] - START_M, color=colours.planned, ls=(0, (4, 3)), zorder=3, label="planned"
    )
    for flights, colour, name in (
        (vp, colours.flown, "variable pitch"),
        (vp_late, colours.x, "variable pitch, no lead"),
        (fp, colours.y, "fixed pitch"),
    ):
        flown = flights.first
        height.plot(flown.t, flown.p_WB[:, 2] - START_M, color=colour, label=name)
        thrust.plot(flown.t, flown.rotors.mean(axis=1), color=colour, lw=1.0)
    height.axhline(1.0, color=colours.faint, lw=1.0, zorder=0)
    height.set(xlabel="time [s]", ylabel="height [m]", xlim=(0.0, plan.T + 1.2))
    thrust.set(xlabel="time [s]", ylabel="mean rotor thrust [N]", xlim=(0.0, plan.T + 1.2))
    legend(height)

"""Fig 4: the rotor thrusts of the backflip, anticipated and flown.

Why: the planner is only as good as its picture of the rotors; flown thrusts are the same, noisier.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from halfroll.drawing import Palette, legend
from halfroll.paper import paths
from halfroll.paper.claims import above, between, near
from halfroll.paper.flights import Flights, backflips
from halfroll.paper.part import Part
from halfroll.paper.time_lines import draw_rotors
from halfroll.streamed import Flown
from halfroll.vehicle import load_vehicle


def reproduce(seeds: int) -> Part:
    flights = backflips("mit-vp", seeds)
    plan, heavy = flights.plan, paths.backflip(load_vehicle("paper-plan"))
    anticipated = [min(plan.rotor_min), max(plan.rotor_max)]
    flown = [min(f.rotors.min() for f in flights.flown), max(f.rotors.max() for f in flights.flown)]

    def likeness(one: Flown) -> float:
        during = one.t <= plan.T
        return float(np.corrcoef(one.rotors[during].ravel(), plan.outputs(one.t[during]).rotors.ravel())[0, 1])

    claims = (
        near("4a", "anticipated: least and largest rotor thrust", anticipated, [-1.13, 2.59], "N", off=0.05),
        near(
            "4a.mass",
            "anticipated at 0.665 kg: the largest is the limit",
            max(heavy.rotor_max),
            3.0,
            "N",
            off=0.05,
            paper=3.0,
            note="vehicle paper-plan: one mass explains this and Fig 5",
        ),
        between("4b", "flown: least and largest", flown, -3.0, 3.0, "N", paper=[-3.0, 3.0]),
        above("4b.likeness", "flown: correlation with the anticipated", min(flights.each(likeness)), 0.8),
    )
    return Part(
        "Fig 4: rotor thrusts of the backflip",
        claims,
        "Above: anticipated by the planner. Below: flown with sensor noise.",
        lambda figure, colours: _draw(figure, colours, flights),
    )


def _draw(figure: Any, colours: Palette, flights: Flights) -> None:
    above_axes, below_axes = figure.subplots(2, 1, sharex=True)
    plan, flown = flights.plan, flights.first
    draw_rotors(above_axes, colours, plan, np.linspace(0.0, plan.T, 2001), None)
    until = flown.t <= plan.T + 0.3
    draw_rotors(below_axes, colours, plan, flown.t[until], flown.rotors[until])
    above_axes.set_ylabel("anticipated [N]")
    below_axes.set(ylabel="flown [N]", xlabel="time [s]", xlim=(0.0, plan.T + 0.3))
    legend(above_axes)

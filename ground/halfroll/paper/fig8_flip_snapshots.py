"""Fig 8: the free-fall flip at instants.

Why: the paper shows photographs of hardware; ours show the simulated vehicle on the flight of Fig 2, with its attitude
over time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from halfroll.drawing import Palette
from halfroll.paper.claims import between, near
from halfroll.paper.flights import Flights, free_fall_flips, turned_deg
from halfroll.paper.part import Part
from halfroll.paper.time_lines import draw_attitude_line, draw_snapshots
from halfroll.streamed import Flown

_ANGLES_DEG = np.array([2.0, 16.0, 33.0, 70.0, 110.0, 147.0, 164.0, 178.0])  # at which it is drawn
_DRAWN = 0.25  # of its size, for the flip is hardly wider than the vehicle


def reproduce(seeds: int) -> Part:
    flights = free_fall_flips("mit-vp", seeds)

    def angle_at_apex(flown: Flown) -> float:
        return float(turned_deg(flown)[flown.p_WB[:, 2].argmax()])

    apex = flights.extremes(angle_at_apex)
    claims = (
        between("8", "thrust axis when the flown path is highest", apex, 80.0, 100.0, "deg", paper=90.0),
        near("8.inverted", "ends inverted", flights.ends_deg, 180.0, "deg", off=1.0, paper=180.0),
    )
    return Part(
        "Fig 8: the free-fall flip at instants",
        claims,
        f"Eight instants of the flown flip, the vehicle at {_DRAWN:g} of its size; arrows are the body's z.",
        lambda figure, colours: _draw(figure, colours, flights),
        (11.0, 4.8),
    )


def _draw(figure: Any, colours: Palette, flights: Flights) -> None:
    pictures, line = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    flown = flights.first
    turned = turned_deg(flown)
    instants = flown.t[[int(np.argmax(turned >= angle)) for angle in _ANGLES_DEG]]
    draw_snapshots(pictures, colours, flown, instants, _DRAWN * flights.plan.vehicle.arm_m)
    draw_attitude_line(line, colours, flights, instants)

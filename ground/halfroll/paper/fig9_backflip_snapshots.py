"""Fig 9: the translating backflip at instants.

Why: as Fig 8, for the flight of Fig 3.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from halfroll.drawing import Palette
from halfroll.paper import paths
from halfroll.paper.claims import near
from halfroll.paper.flights import Flights, backflips
from halfroll.paper.part import Part
from halfroll.paper.time_lines import draw_attitude_line, draw_snapshots

_INSTANTS_S = np.array([0.0, 0.40, 0.62, 0.78, 0.90, 1.00, 1.08, 1.16, 1.27, 1.42, 1.66, 2.11])


def reproduce(seeds: int) -> Part:
    flights = backflips("mit-vp", seeds)
    moved = flights.extremes(lambda flown: float(flown.p_WB[-1, 0] - flown.p_WB[0, 0]))
    claims = (
        near("9", "moves forward", moved, paths.BACKFLIP_X_M[-1], "m", off=0.02, paper=4.19),
        near("9.turn", "turns once, backwards", flights.ends_deg, -360.0, "deg", off=1.0, paper=-360.0),
    )
    return Part(
        "Fig 9: the backflip at instants",
        claims,
        "Twelve instants of the flown backflip; arrows are the body's z.",
        lambda figure, colours: _draw(figure, colours, flights),
        (11.0, 6.0),
    )


def _draw(figure: Any, colours: Palette, flights: Flights) -> None:
    pictures, line = figure.subplots(2, 1, height_ratios=(1.0, 1.0))
    draw_snapshots(pictures, colours, flights.first, _INSTANTS_S, flights.plan.vehicle.arm_m)
    draw_attitude_line(line, colours, flights, _INSTANTS_S)

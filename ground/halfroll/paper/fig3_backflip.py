"""Fig 3: a whole turn backwards while translating 4.19 m, hover to hover.

Why: the force never vanishes; two nodes of given acceleration in free fall lay the thrust axis on its side, and one
controller flies all of it.
"""

from __future__ import annotations

import numpy as np

from halfroll.paper import paths
from halfroll.paper.claims import Claim, below, between, near
from halfroll.paper.flights import Flights, backflips
from halfroll.paper.part import Part
from halfroll.paper.time_lines import draw_flip, planned_turn_deg
from halfroll.vehicle import Vehicle, load_vehicle

_SAMPLES = 20001


def reproduce(seeds: int) -> Part:
    flights = backflips("mit-vp", seeds)
    return Part(
        "Fig 3: translating backflip",
        (*_planned(load_vehicle("mit-vp")), *_flown(flights, backflips("paper-faithful", seeds))),
        "Planned, and flown with sensor noise; faint lines are more seeds.",
        lambda figure, colours: draw_flip(figure, colours, flights),
    )


def _planned(vehicle: Vehicle) -> tuple[Claim, ...]:
    plan = paths.backflip(vehicle)
    t = np.linspace(0.0, plan.T, _SAMPLES)
    outputs = plan.outputs(t)
    nodes = np.interp([*paths.BACKFLIP_TIMES_S[2:4], plan.T], t, planned_turn_deg(plan, t))
    rate = np.degrees(np.linalg.norm(outputs.w_WD_D, axis=1))
    height = plan.trajectory.at(t)[:, 2].max()
    force = [outputs.force_size.min(), outputs.force_size.max()]
    turned = [-90.0, -270.0, -360.0]
    return (
        near("3a", "thrust axis at the two nodes and the end", nodes, turned, "deg", off=0.5, paper=turned),
        near(
            "3a.sigma",
            "sigma changes sign at these nodes",
            plan.sigma_events,
            paths.BACKFLIP_TIMES_S[2:4],
            "s",
            off=1e-3,
        ),
        near("3b", "largest rate", rate.max(), 1106.7, "deg/s", share=0.01),
        near("3b.when", "when", t[rate.argmax()], 1.112, "s", share=0.01),
        near("3b.apex", "greatest height", height, 0.546, "m", share=0.01),
        near("3b.force", "least and largest force: never near zero", force, [2.16, 9.67], "N", share=0.01),
    )


def _flown(flights: Flights, rough: Flights) -> tuple[Claim, ...]:
    of = f"worst of {len(flights.flown)} flights"
    return (
        below("3c", "flown: distance from the plan", flights.worst_position, 0.03, "m", note=of),
        below("3c.attitude", "flown: attitude from the plan's", flights.worst_attitude_deg, 10.0, "deg", note=of),
        near("3c.end", "flown: a whole turn", flights.ends_deg, -360.0, "deg", off=1.0, paper=-360.0),
        below("3c.return", "flown: from the plan's end, hovering", flights.worst_return, 0.15, "m", note=of),
        between("3c.rate", "flown: largest rate", flights.peak_rates_deg, 1000.0, 1130.0, "deg/s"),
        near(
            "3c.faithful-end",
            "a whole turn by the paper's control law alone",
            rough.ends_deg,
            -360.0,
            "deg",
            off=1.0,
            paper=-360.0,
        ),
        below(
            "3c.faithful", "its distance from the plan", rough.worst_position, 0.08, "m", note="vehicle paper-faithful"
        ),
    )

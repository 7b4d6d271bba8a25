"""Fig 2: half a turn through free fall, 0.4 m forward, from hover to hover upside down.

Why: the force is zero at the apex, where every formula of the attitude is singular.
"""

from __future__ import annotations

import numpy as np

from halfroll.paper import paths
from halfroll.paper.claims import Claim, above, below, between, near
from halfroll.paper.flights import Flights, free_fall_flips
from halfroll.paper.part import Part
from halfroll.paper.time_lines import draw_flip, planned_turn_deg
from halfroll.planner.limits import margins
from halfroll.vehicle import Vehicle, load_vehicle

_SAMPLES = 40001


def reproduce(seeds: int) -> Part:
    flights = free_fall_flips("mit-vp", seeds)
    rough = free_fall_flips("paper-faithful", seeds)
    return Part(
        "Fig 2: free-fall flip",
        (*_planned(load_vehicle("mit-vp")), *_flown(flights, rough)),
        "Planned, and flown with sensor noise; faint lines are more seeds.",
        lambda figure, colours: draw_flip(figure, colours, flights),
    )


def _planned(vehicle: Vehicle) -> tuple[Claim, ...]:
    plan = paths.free_fall_flip(vehicle)
    t = np.linspace(0.0, plan.T, _SAMPLES)
    outputs = plan.outputs(t)
    held = outputs.force_size < _hold_force(vehicle)
    rate = np.degrees(np.linalg.norm(outputs.w_WD_D, axis=1))
    (event,) = plan.sigma_events
    shortest, longest = _feasible_durations(vehicle)
    return (
        near("2a", "height of the apex", plan.trajectory.at(plan.T / 2.0)[0, 2], 0.270, "m", off=0.002, paper=0.270),
        near("2b", "largest rate commanded, at the apex", rate.max(), 956.0, "deg/s", share=0.01, paper=956.0),
        near(
            "2b.hold",
            "the same where a force below 0.1 N is not followed",
            rate[~held].max(),
            944.7,
            "deg/s",
            share=0.01,
        ),
        near(
            "2c", "thrust axis at the end: inverted", planned_turn_deg(plan, t)[-1], 180.0, "deg", off=1.0, paper=180.0
        ),
        near("2c.sigma", "sigma changes sign half way", event, plan.T / 2.0, "s", off=1e-3, paper=plan.T / 2.0),
        near(
            "2c.hold",
            "time below 0.1 N: the corner of the paper's curves",
            held.mean() * plan.T * 1e3,
            13.3,
            "ms",
            off=0.5,
        ),
        near(
            "2c.rotors",
            "least and largest rotor thrust",
            [outputs.rotors.min(), outputs.rotors.max()],
            [-2.26, 2.26],
            "N",
            off=0.02,
        ),
        near(
            "2c.durations",
            "shortest and longest flip of this width that the rotors can fly",
            [shortest, longest],
            [0.560, 1.329],
            "s",
            off=0.01,
            note="longer is not always easier: the force is given at the apex",
        ),
    )


def _flown(flights: Flights, rough: Flights) -> tuple[Claim, ...]:
    of = f"worst of {len(flights.flown)} flights"
    return (
        below("2d", "flown: distance from the plan", flights.worst_position, 0.02, "m", note=of),
        below("2d.attitude", "flown: attitude from the plan's", flights.worst_attitude_deg, 12.0, "deg", note=of),
        near("2d.end", "flown: thrust axis at the end", flights.ends_deg, 180.0, "deg", off=1.0, paper=180.0),
        between("2d.rate", "flown: largest rate", flights.peak_rates_deg, 880.0, 980.0, "deg/s", paper=956.0),
        above(
            "2d.faithful",
            "the paper's control law alone (vehicle paper-faithful) leaves the plan by",
            rough.worst_position,
            0.1,
            "m",
            note="what fade, leads and the sign window are for; it ends inverted all the same",
        ),
        near("2d.faithful-end", "its thrust axis at the end", rough.ends_deg, 180.0, "deg", off=1.0, paper=180.0),
    )


def _hold_force(vehicle: Vehicle) -> float:
    return vehicle.params.get("HOLD_FORCE", 0.1)


def _feasible_durations(vehicle: Vehicle) -> tuple[float, float]:
    """Where the largest rotor thrust crosses its limit, on both sides of Fig 2's duration."""

    def fits(duration: float) -> bool:
        plan = paths.free_fall_flip(vehicle, duration=duration)
        return margins(plan.trajectory, vehicle, paths.rotor_limits(vehicle), flips=plan.flips).checked

    def edge(inside: float, outside: float) -> float:
        while abs(outside - inside) > 1e-3:
            middle = (inside + outside) / 2.0
            inside, outside = (middle, outside) if fits(middle) else (inside, middle)
        return inside

    return edge(paths.FLIP_S, 0.3), edge(paths.FLIP_S, 2.0)

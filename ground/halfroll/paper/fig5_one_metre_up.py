"""Fig 5: the shortest climb of one metre, with rotors that push both ways and with ordinary ones.

Why: it is the paper's time optimiser at work (Eqs 25-27), with the only times that can be compared. They are not
optima of a vehicle that hovers as Fig 4a does: two other optimisers and 40 random starts agree with ours. One larger
mass explains both, and Fig 4a's peak.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from halfroll.drawing import Palette
from halfroll.paper import paths
from halfroll.paper.claims import below, near
from halfroll.paper.flights import shortest_climb
from halfroll.paper.part import Part
from halfroll.planner.plan import Plan
from halfroll.vehicle import GRAVITY, Vehicle, load_vehicle

_PAPER_S = (0.7826, 0.9544)  # variable, fixed pitch
_SINGLE = (0.0, 1.0)


def reproduce(seeds: int) -> Part:
    light, heavy = load_vehicle("mit-vp").mass_kg, load_vehicle("paper-plan").mass_kg
    vp, fp = (shortest_climb(name, light) for name in ("mit-vp", "mit-fp"))
    heavy_vp, heavy_fp = (shortest_climb(name, heavy) for name in ("mit-vp", "mit-fp"))
    singles = [shortest_climb(name, light, _SINGLE).T for name in ("mit-vp", "mit-fp")]
    bangs = [_bang_bang_s(load_vehicle(name)) for name in ("mit-vp", "mit-fp")]
    tops, lows = [max(vp.rotor_max), max(fp.rotor_max)], [min(vp.rotor_min), min(fp.rotor_min)]
    times = [vp.T, fp.T]
    heavy_times = [heavy_vp.T, heavy_fp.T]
    claims = (
        near(
            "5a",
            "shortest time, variable and fixed pitch, 0.571 kg",
            times,
            [0.6666, 0.8952],
            "s",
            share=0.005,
            paper=_PAPER_S,
            note="the paper's times belong to another mass: 5a.mass",
        ),
        near(
            "5a.mass",
            "the same at 0.665 kg (vehicle paper-plan)",
            heavy_times,
            _PAPER_S,
            "s",
            share=0.02,
            paper=_PAPER_S,
        ),
        near(
            "5a.mass-optimum",
            "the same, against the optimum of another optimiser",
            heavy_times,
            [0.777, 0.968],
            "s",
            share=0.005,
        ),
        below("5a.order", "variable over fixed pitch", vp.T / fp.T, 1.0, paper=_PAPER_S[0] / _PAPER_S[1]),
        near("5b", "both reach the same upper limit", tops, [3.0, 3.0], "N", off=0.02, paper=[3.0, 3.0]),
        near("5b.low", "variable pitch pulls down, fixed pitch stays at its least", lows, [-2.57, 0.15], "N", off=0.02),
        near(
            "5b.nodes-vp",
            "variable pitch passes its nodes at",
            vp.trajectory.times[1:],
            [0.2993, 0.5199, 0.6666],
            "s",
            share=0.005,
        ),
        near(
            "5b.nodes-fp",
            "fixed pitch passes its nodes at",
            fp.trajectory.times[1:],
            [0.3230, 0.6419, 0.8952],
            "s",
            share=0.005,
        ),
        near("5c.single", "a single polynomial, variable and fixed pitch", singles, [0.9145, 1.0344], "s", off=1e-4),
        near("5c", "thrust either full or least, variable and fixed pitch", bangs, [0.4933, 0.6378], "s", off=1e-4),
    )
    return Part(
        "Fig 5: one metre up, as fast as the rotors allow",
        claims,
        "Variable and fixed pitch at 0.571 kg (full lines) and at 0.665 kg (dashed). Vertical lines: the times in the "
        "paper's figure.",
        lambda figure, colours: _draw(figure, colours, [(vp, fp), (heavy_vp, heavy_fp)]),
        (11.0, 4.8),
    )


def _bang_bang_s(vehicle: Vehicle) -> float:
    """Up at full thrust, then braking at the least: no path of one metre is shorter."""
    up = 4.0 * vehicle.rotor.thrust_max_N / vehicle.mass_kg - GRAVITY
    down = GRAVITY - 4.0 * vehicle.rotor.thrust_min_N / vehicle.mass_kg
    return math.sqrt(2.0 * paths.CLIMB_HEIGHTS_M[-1] * (1.0 / up + 1.0 / down))


def _draw(figure: Any, colours: Palette, pairs: list[tuple[Plan, Plan]]) -> None:
    height, thrust = figure.subplots(1, 2)
    for pair, dashes in zip(pairs, ((0, ()), (0, (4, 3))), strict=True):
        for plan, colour, name in zip(pair, (colours.flown, colours.y), ("variable", "fixed"), strict=True):
            t = np.linspace(0.0, plan.T, 1001)
            label = f"{name} pitch, {plan.vehicle.mass_kg:g} kg: {plan.T:.3f} s"
            height.plot(t, plan.trajectory.at(t)[:, 2], color=colour, ls=dashes, label=label)
            thrust.plot(t, plan.outputs(t).rotors[:, 0], color=colour, ls=dashes)
            height.plot(plan.trajectory.times, plan.trajectory.at(plan.trajectory.times)[:, 2], "o", color=colour, ms=4)
    for end, colour in zip(_PAPER_S, (colours.flown, colours.y), strict=True):
        height.axvline(end, color=colour, lw=0.9, ls=(0, (1, 2)))
    rotor = pairs[0][0].vehicle.rotor
    for level in (rotor.thrust_min_N, pairs[0][1].vehicle.rotor.thrust_min_N, rotor.thrust_max_N):
        thrust.axhline(level, color=colours.alert, lw=1.0, ls=(0, (1, 1.5)))
    height.set(xlabel="time [s]", ylabel="height [m]", xlim=(0.0, 1.0))
    thrust.set(xlabel="time [s]", ylabel="each rotor [N]", xlim=(0.0, 1.0))
    height.legend(loc="lower right")

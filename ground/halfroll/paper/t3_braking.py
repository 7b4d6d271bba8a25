"""T3: rotors that pull down brake a climb harder than gravity does.

Why: it is what Fig 5 gains its time from.
"""

from __future__ import annotations

from halfroll.paper.claims import above, near
from halfroll.paper.part import Part
from halfroll.vehicle import GRAVITY, Vehicle, load_vehicle


def reproduce(seeds: int) -> Part:
    vp, fp = load_vehicle("mit-vp"), load_vehicle("mit-fp")
    down = [_down(vp), _down(fp)]
    up = 4.0 * vp.rotor.thrust_max_N / vp.mass_kg - GRAVITY
    claims = (
        near("T3", "largest acceleration down, variable and fixed pitch", down, [30.8, 8.76], "m/s^2", off=0.1),
        above(
            "T3.gravity", "variable pitch brakes harder than gravity: down over g", down[0] / GRAVITY, 1.0, paper=1.0
        ),
        near("T3.up", "largest acceleration up", up, 11.2, "m/s^2", off=0.1),
    )
    return Part("T3: braking", claims)


def _down(vehicle: Vehicle) -> float:
    return GRAVITY - 4.0 * vehicle.rotor.thrust_min_N / vehicle.mass_kg

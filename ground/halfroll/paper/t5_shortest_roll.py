"""T5: the shortest half turn that the torque about roll allows.

Why: a bound under Fig 7: full torque half way, full torque back.
"""

from __future__ import annotations

import math

from halfroll.paper.claims import near
from halfroll.paper.part import Part
from halfroll.vehicle import Vehicle, load_vehicle


def reproduce(seeds: int) -> Part:
    vehicles = load_vehicle("mit-vp"), load_vehicle("mit-fp")
    times = [2.0 * math.sqrt(math.pi * vehicle.inertia_kg_m2[0] / _torque(vehicle)) for vehicle in vehicles]
    torques = [_torque(vehicle) for vehicle in vehicles]
    claims = (
        near("T5", "half a turn, variable and fixed pitch", times, [0.209, 0.303], "s", off=1e-3),
        near("T5.torque", "largest torque about roll", torques, [1.05, 0.499], "N m", off=1e-3),
    )
    return Part("T5: the shortest half turn", claims)


def _torque(vehicle: Vehicle) -> float:
    """[N m] two rotors against each other."""
    return (vehicle.rotor.thrust_max_N - vehicle.rotor.thrust_min_N) * vehicle.arm_m

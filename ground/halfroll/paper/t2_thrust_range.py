"""T2: thrust of either sign more than doubles what a rotor can do.

Why: it is the reason for variable pitch, and the numbers of the vehicle that all figures stand on.
"""

from __future__ import annotations

from halfroll.paper.claims import above, near
from halfroll.paper.part import Part
from halfroll.vehicle import Vehicle, load_vehicle


def reproduce(seeds: int) -> Part:
    vp, fp = load_vehicle("mit-vp"), load_vehicle("mit-fp")
    limits = [vp.rotor.thrust_min_N, vp.rotor.thrust_max_N, fp.rotor.thrust_min_N]
    claims = (
        above("T2", "range of a rotor, variable over fixed pitch", _range_N(vp) / _range_N(fp), 2.0, paper=2.0),
        near(
            "T2.limits",
            "least and largest thrust, least with fixed pitch",
            limits,
            [-3.0, 3.0, 0.15],
            "N",
            off=0.0,
            paper=[-3.0, 3.0, 0.15],
        ),
        near("T2.weight", "all four rotors over the weight", 4.0 * vp.rotor.thrust_max_N / vp.weight, 2.14, off=0.01),
    )
    return Part("T2: range of thrust", claims)


def _range_N(vehicle: Vehicle) -> float:
    return vehicle.rotor.thrust_max_N - vehicle.rotor.thrust_min_N

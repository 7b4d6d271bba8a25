"""The paper's flights: each plan flown a few times, one seed a flight, with sensor noise, late motion capture, the
estimator, references at 100 Hz through MAVLink bytes and the firmware at 1 kHz (streamed.py, scenario nominal).

Why: figures share flights, and every flown claim is judged by its worst flight.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from halfroll.drawing import angle_between
from halfroll.paper import paths
from halfroll.planner.plan import Plan
from halfroll.scenario import load_scenario
from halfroll.station.references import path_of
from halfroll.streamed import Flown, StreamedFlight
from halfroll.vehicle import Vehicle, load_vehicle

Array = NDArray[np.float64]

START_M = 3.0  # above the ground
HOVER_S = 2.0  # flown on after the plan
_END_S = 0.3  # the last of it is where the flight ended


@dataclass(frozen=True)
class Flights:
    """One plan, flown once a seed."""

    plan: Plan
    flown: tuple[Flown, ...]

    @property
    def first(self) -> Flown:
        return self.flown[0]

    def worst(self, measure: Callable[[Flown], float]) -> float:
        return max(measure(flown) for flown in self.flown)

    def extremes(self, measure: Callable[[Flown], float]) -> tuple[float, float]:
        found = self.each(measure)
        return min(found), max(found)

    def each(self, measure: Callable[[Flown], float]) -> list[float]:
        return [measure(flown) for flown in self.flown]

    @cached_property
    def worst_position(self) -> float:
        """[m] from the plan, at any time."""
        return self.worst(lambda flown: float(position_error(self.plan, flown).max()))

    @cached_property
    def worst_attitude_deg(self) -> float:
        return self.worst(lambda flown: float(attitude_error_deg(self.plan, flown).max()))

    @cached_property
    def worst_return(self) -> float:
        """[m] from the plan's end, in the last moments."""
        return self.worst(lambda flown: float(position_error(self.plan, flown)[_last(flown)].max()))

    @cached_property
    def ends_deg(self) -> tuple[float, float]:
        """Least and largest angle of the thrust axis, in the last moments."""
        return self.extremes(lambda flown: float(turned_deg(flown)[_last(flown)].mean()))

    @cached_property
    def peak_rates_deg(self) -> tuple[float, float]:
        """[deg/s], least and largest of the flights."""
        return self.extremes(lambda flown: float(np.degrees(np.linalg.norm(flown.w_WB_B, axis=1).max())))


def _last(flown: Flown) -> slice:
    return slice(int(np.searchsorted(flown.t, flown.t[-1] - _END_S)), None)


def position_error(plan: Plan, flown: Flown) -> Array:
    """(N,) [m]"""
    return np.asarray(np.linalg.norm(flown.p_WB - plan.trajectory.at(flown.t)[:, :3], axis=1))


def attitude_error_deg(plan: Plan, flown: Flown) -> Array:
    """(N,) between the vehicle and the plan, position feedback included."""
    return np.asarray(np.degrees(angle_between(flown.q_WB, plan.outputs(np.minimum(flown.t, plan.T)).q_WD)))


def turned_deg(flown: Flown) -> Array:
    """(N,) the thrust axis in the x-z plane, unwrapped: 0 is upright, 90 forward."""
    n = flown.up_axis
    return np.asarray(np.degrees(np.unwrap(np.arctan2(n[:, 0], n[:, 2]))))


def fly(plan: Plan, seeds: int, scenario: str = "nominal", flown_by: Vehicle | None = None) -> Flights:
    """flown_by: default the vehicle that it was planned for."""
    path, start = path_of(plan), plan.waypoints[0]
    flown = []
    for seed in range(seeds):
        flight = StreamedFlight(flown_by or plan.vehicle, load_scenario(scenario), seed)
        flight.take_off(START_M)
        flight.settle(start.position, start.yaw)
        flown.append(flight.follow(path, plan.T + HOVER_S))
    return Flights(plan, tuple(flown))


@cache
def free_fall_flips(vehicle: str, seeds: int) -> Flights:
    return fly(paths.free_fall_flip(load_vehicle(vehicle), START_M), seeds)


@cache
def backflips(vehicle: str, seeds: int) -> Flights:
    return fly(paths.backflip(load_vehicle(vehicle), START_M), seeds)


def stretched_climbs(vehicle: str, seeds: int, changes: Mapping[str, float] | None = None) -> Flights:
    """Fig 6: the shortest climb of variable pitch, stretched, flown by any vehicle."""
    planned_for = load_vehicle("mit-vp")
    shortest = shortest_climb("mit-vp", planned_for.mass_kg)
    plan = paths.climb(planned_for, (shortest.trajectory.times * paths.CLIMB_S / shortest.T).tolist(), START_M)
    return fly(plan, seeds, flown_by=load_vehicle(vehicle, dict(changes or {})))


@cache
def shortest_climb(vehicle: str, mass_kg: float, heights: tuple[float, ...] = paths.CLIMB_HEIGHTS_M) -> Plan:
    return paths.shortest_climb(load_vehicle(vehicle, {"mass_kg": mass_kg}), heights)

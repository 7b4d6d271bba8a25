"""Course D flown many times: the zigzag of six points, in nominal noise and in wind with a weak rotor."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from streamed import StreamedFlight

from halfroll.missions.mission import Waypoint
from halfroll.planner.limits import Limits
from halfroll.planner.near_optimal import plan_near_optimal
from halfroll.planner.plan import Plan, plan_course
from halfroll.station.references import path_of
from halfroll.vehicle import load_vehicle

POINTS = ((0.0, 0.0, 1.0), (2.0, 1.0, 2.0), (4.0, -1.0, 1.0), (6.0, 1.0, 2.5), (8.0, -1.0, 1.0), (10.0, 0.0, 1.5))
MARGIN = 0.1
# Dryden wind, 3 m/s mean (intensities and lengths as in scenario windy), and rotor 2 at 85 % from the start.
WINDY_AND_WEAK = ("fault.0.kind=weak-rotor", "fault.0.rotor=2", "fault.0.at_s=0", "fault.0.share=0.85")


@dataclass(frozen=True)
class Flown:
    complete: bool  # at the end it hovers within half a metre of the last waypoint, right side up
    miss_m: float  # the farthest that any waypoint was missed by when it was due
    worst_m: float  # distance from the plan


@lru_cache
def plan(vehicle: str, mode: str, margin: float = MARGIN) -> Plan:
    waypoints = [Waypoint(position=p) for p in POINTS]
    known = load_vehicle(vehicle)
    limits = Limits.of(known, "mission", margin)
    return (
        plan_course(waypoints, known, limits)
        if mode == "paper"
        else plan_near_optimal(waypoints, known, limits, "fast")
    )


def fly(vehicle: str, mode: str, scenario: str, settings: tuple[str, ...], seed: int, margin: float) -> Flown:
    made = plan(vehicle, mode, margin)
    flight = StreamedFlight(vehicle, scenario, settings, seed)
    flight.take_off(1.0)
    t, positions = flight.follow(path_of(made), made.T + 0.5)
    planned = made.trajectory.at(np.clip(t, 0.0, made.T))[:, :3]
    worst = float(np.linalg.norm(positions - planned, axis=1).max())
    at = np.stack([np.interp(made.times_s, t, column) for column in positions.T], axis=1)
    miss = float(np.linalg.norm(at - np.array(POINTS), axis=1).max())
    upright = 1.0 - 2.0 * float(flight.world.q_WB[1] ** 2 + flight.world.q_WB[2] ** 2) > 0.7
    held = flight.autopilot.mode == "Offboard" and flight.autopilot.armed
    arrived = float(np.linalg.norm(positions[-1] - np.array(POINTS[-1]))) < 0.5
    return Flown(held and upright and arrived and not flight.world.crashed, miss, worst)


def _fly(case: tuple[str, str, str, tuple[str, ...], int, float]) -> Flown:
    return fly(*case)


def campaign(
    vehicle: str, mode: str, scenario: str, settings: tuple[str, ...], seeds: int, margin: float = MARGIN
) -> list[Flown]:
    """One flight a seed, in two processes."""
    cases = [(vehicle, mode, scenario, settings, seed, margin) for seed in range(seeds)]
    plan(vehicle, mode, margin)  # once, before the processes part
    with ProcessPoolExecutor(2) as pool:
        return list(pool.map(_fly, cases, chunksize=5))


def summary(name: str, flown: list[Flown]) -> str:
    miss = np.array([f.miss_m for f in flown])
    return (
        f"{name}: {sum(f.complete for f in flown)} of {len(flown)} complete, waypoint miss median "
        f"{np.median(miss):.3f}, 95 % {np.quantile(miss, 0.95):.3f}, worst {miss.max():.3f} m; "
        f"never farther from the plan than {max(f.worst_m for f in flown):.3f} m"
    )

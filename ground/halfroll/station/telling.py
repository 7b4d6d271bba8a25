"""Tells whoever watches what the station flies. Why: at a viewer's rate and not at that of the stream, and the stream
never waits for it.
"""

from __future__ import annotations

import math

import numpy as np

from halfroll.planner.plan import Plan
from halfroll.station.station import State, Station
from halfroll.wire.told import ToldPlan, ToldReference, packed
from halfroll.wire.transport import Clock, Transport, wall_s

EVERY_S, PLAN_EVERY_S = 0.02, 1.0  # wall clock
_PATH_POINTS = 400


class Teller:
    """Call `tell` as often as you like."""

    def __init__(self, transport: Transport, clock: Clock = wall_s) -> None:
        self._transport, self._clock = transport, clock
        self._told_s = self._plan_told_s = -math.inf
        self._plan: Plan | None = None
        self._datagram = b""

    def tell(self, station: Station) -> None:
        now_s = self._clock()
        if now_s - self._told_s < EVERY_S:
            return
        self._told_s = now_s
        plan = station.planned.plan if station.planned else None
        if plan is not None and (plan is not self._plan or now_s - self._plan_told_s >= PLAN_EVERY_S):
            if plan is not self._plan:
                self._plan, self._datagram = plan, packed(told_plan(plan))
            self._plan_told_s = now_s
            self._transport.send(self._datagram)
        following = station.following
        if station.state is State.FLYING and following is not None and following.sent is not None:
            self._transport.send(packed(ToldReference(*following.sent)))


def told_plan(plan: Plan) -> ToldPlan:
    path = np.asarray(plan.at(np.linspace(0.0, plan.T, _PATH_POINTS)).position, dtype=np.float64)
    gates = tuple(
        (np.array(point.position), None if point.q_WB is None else np.array(point.q_WB)) for point in plan.waypoints
    )
    rotor = plan.vehicle.rotor
    return ToldPlan(
        plan.vehicle.name, plan.T, path, gates, (rotor.thrust_min_N, rotor.thrust_max_N), plan.vehicle.arm_m
    )

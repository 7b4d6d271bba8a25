"""What the station tells whoever watches: its plan, and where the vehicle should be now."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

import halfroll as hr
from halfroll.station.station import State
from halfroll.station.telling import EVERY_S, PLAN_EVERY_S, Teller
from halfroll.wire.told import ToldPlan, ToldReference, unpacked
from halfroll.wire.transport import MemoryTransport

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0], dtype=np.float32)


def station_with(plan: object, sent: object) -> SimpleNamespace:
    planned = None if plan is None else SimpleNamespace(plan=plan)
    state = State.FLYING if sent else State.READY
    return SimpleNamespace(planned=planned, state=state, following=SimpleNamespace(sent=sent) if sent else None)


def test_the_plan_is_told_when_it_is_new_and_again_for_who_comes_later_the_reference_each_time():
    ours, theirs = MemoryTransport.pair()
    now_s = 0.0
    teller = Teller(ours, clock=lambda: now_s)
    plan = hr.plan("tests/system/missions/box.plan")
    heard = []
    for tick in range(round(2.5 * PLAN_EVERY_S / EVERY_S)):
        now_s = 1.01 * EVERY_S * tick
        teller.tell(station_with(plan, (10_000 * tick, np.array([0.1, 0.2, 0.3]), UPRIGHT)))
        teller.tell(station_with(plan, (10_000 * tick, np.zeros(3), UPRIGHT)))  # at once again: nothing is said
        heard += [unpacked(datagram) for datagram in theirs.receive()]
    plans = [told for told in heard if isinstance(told, ToldPlan)]
    references = [told for told in heard if isinstance(told, ToldReference)]
    assert len(plans) == 3
    assert plans[0].path[0].tolist() == np.round(plan.waypoints[0].position, 4).tolist()
    assert len(plans[0].gates) == len(plan.waypoints)
    assert [told.t_us for told in references] == [10_000 * tick for tick in range(len(references))]
    assert references[0].p.tolist() == [0.1, 0.2, 0.3]


def test_a_station_that_streams_nothing_tells_no_reference():
    ours, theirs = MemoryTransport.pair()
    Teller(ours, clock=lambda: 0.0).tell(station_with(None, None))
    assert theirs.receive() == []

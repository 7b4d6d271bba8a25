"""The worker process that plans: what comes out of it, and that it ends."""

from __future__ import annotations

import math
import os
import signal
from dataclasses import replace

import pytest

from halfroll.errors import MissionError, PlanError
from halfroll.missions.geodesy import DEFAULT_ORIGIN
from halfroll.missions.mission import MissionItem
from halfroll.station import planning
from halfroll.station.planning import NothingToPlan, Planned, PlanningProcess, PlanRequest, outcome_of, plan_mission
from halfroll.vehicle import load_vehicle
from halfroll.wire.transport import MemoryTransport

NAN = math.nan
TAKEOFF = MissionItem(22, 3, (0.0, 0.0, 0.0, NAN), 473977420, 85455940, 2.0)
NORTH = MissionItem(16, 3, (0.0, 0.0, 0.0, NAN), 473977600, 85455940, 2.0)
LAND = MissionItem(21, 3, (0.0, 0.0, 0.0, NAN), 473977600, 85455940, 0.0)
REQUEST = PlanRequest((TAKEOFF, NORTH, LAND), DEFAULT_ORIGIN, DEFAULT_ORIGIN, 2.5, 0.0, load_vehicle("mit-vp"))


def planned_by(planner, request):
    planner.submit(request)
    while (outcome := planner.poll()) is None:
        MemoryTransport.pair()[0].receive(0.01)
    return outcome


def test_the_worker_plans_what_would_be_planned_here_and_says_how_far_it_is():
    with PlanningProcess() as planner:
        there, here = planned_by(planner, REQUEST), plan_mission(REQUEST)
        assert isinstance(there, Planned)
        assert isinstance(here, Planned)
        assert there.plan.times_s == pytest.approx(here.plan.times_s, rel=1e-9)
        assert there.path.duration == pytest.approx(there.plan.T, abs=1e-3)
        assert planner.progress()


def test_what_cannot_be_planned_comes_back_as_the_error_with_its_item():
    below = replace(NORTH, z=-50.0)
    with PlanningProcess() as planner:
        error = planned_by(planner, replace(REQUEST, items=(TAKEOFF, below, LAND)))
        assert isinstance(error, MissionError)
        assert error.item == 1
        assert isinstance(planned_by(planner, REQUEST), Planned)  # the next one is planned all the same


def test_a_mission_without_a_second_point_needs_no_plan():
    assert isinstance(plan_mission(replace(REQUEST, items=(TAKEOFF, replace(LAND, x=TAKEOFF.x)))), NothingToPlan)


def test_the_rest_of_a_mission_is_planned_from_where_it_hovers():
    rest = plan_mission(replace(REQUEST, from_item=1, start=(0.5, 0.0, 2.2)))
    assert isinstance(rest, Planned)
    assert rest.plan.waypoints[0].position == (0.5, 0.0, 2.2)
    assert [waypoint.item for waypoint in rest.plan.waypoints] == [None, 1]


def test_closing_ends_the_worker_in_the_middle_of_a_plan():
    planner = PlanningProcess()
    planner.submit(REQUEST)
    worker = planner._worker
    planner.close()
    assert worker.exitcode == -signal.SIGKILL
    with pytest.raises(ProcessLookupError):
        os.kill(worker.pid, 0)


def test_a_newer_request_does_not_wait_for_the_one_before():
    with PlanningProcess() as planner:
        planner.submit(REQUEST)
        first = planner._worker
        planner.submit(replace(REQUEST, items=(TAKEOFF, replace(NORTH, z=-50.0), LAND)))
        assert first.exitcode == -signal.SIGKILL
        while (outcome := planner.poll()) is None:
            MemoryTransport.pair()[0].receive(0.01)
        assert isinstance(outcome, MissionError)


@pytest.mark.parametrize("raised", [MemoryError(), ValueError("odd")])
def test_whatever_the_planner_raises_comes_back_as_a_sentence(monkeypatch, raised):
    def fail(*_):
        raise raised

    monkeypatch.setattr(planning, "plan_mission", fail)
    outcome = outcome_of(REQUEST)
    assert isinstance(outcome, PlanError)
    assert outcome.exit_code == 1


def test_a_hold_of_more_than_an_hour_is_refused_by_its_item():
    with pytest.raises(PlanError, match=r"item 1: its hold of 4000 s is too long, at most 3600 s") as caught:
        plan_mission(replace(REQUEST, items=(TAKEOFF, replace(NORTH, params=(4000.0, 0.0, 0.0, NAN)), LAND)))
    assert caught.value.item == 1

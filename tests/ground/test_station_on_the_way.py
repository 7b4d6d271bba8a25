"""The station in the middle of a mission: pauses, items chosen by others, another mission."""

from __future__ import annotations

import numpy as np
import pytest
from fake_autopilot import HOLD, MISSION, OFFBOARD
from station_scene import Scene, flying_scene, go_on, pause, texts_of

from halfroll.station.following import Stage
from halfroll.station.station import State


def test_the_station_does_not_take_over_in_the_middle_of_a_mission():
    scene = Scene()
    scene.fly(until=lambda: scene.station.state is State.READY)
    scene.world.armed, scene.world.mission_state, scene.world.seq = True, 3, 2
    scene.world.set_mode(MISSION)
    scene.fly(1.0)
    assert scene.world.setpoints() == []


def test_it_takes_over_when_word_that_the_takeoff_is_reached_was_lost():
    scene = Scene()
    scene.world.lost = lambda frame: frame.get_type() == "MISSION_ITEM_REACHED"
    scene.start()
    scene.fly(1.0)
    assert scene.world.mode == OFFBOARD
    assert "approach" in scene.kinds()


def test_far_from_the_plan_s_start_a_takeoff_that_was_reached_unheard_is_too_long_ago():
    scene = Scene()
    scene.world.lost = lambda frame: frame.get_type() == "MISSION_ITEM_REACHED"
    scene.fly(until=lambda: scene.station.state is State.READY)
    scene.world.armed, scene.world.mission_state = True, 3
    scene.world.set_mode(MISSION)
    scene.world.position = np.array([1.5, 0.0, -2.0])
    scene.fly(0.1)
    scene.world.reach(0)
    scene.fly(1.0)
    assert scene.world.mode == MISSION


def test_the_item_after_the_takeoff_is_nobody_s_choice_when_it_is_heard_late():
    scene = Scene()
    scene.world.lost = lambda frame: frame.get_type() == "MISSION_CURRENT" and scene.world.mode == MISSION
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.stage is Stage.FLYING)
    scene.world.tell_mission()
    scene.fly(0.2)
    assert scene.station.following.stage is Stage.FLYING


@pytest.mark.parametrize(("round_trip_s", "mode"), [(0.04, OFFBOARD), (0.06, MISSION)])
def test_over_a_link_that_is_too_slow_the_autopilot_flies_by_itself_and_it_is_said(round_trip_s, mode):
    scene = Scene(lockstep=False)
    scene.fly(until=lambda: scene.station.state is State.READY)
    scene.link.round_trips_s.extend([round_trip_s, 0.3] * 8)
    scene.start()
    scene.fly(0.3)
    assert scene.world.mode == mode
    assert ("Mission: link too slow for the plan, 60 ms" in texts_of(scene)) == (mode == MISSION)


def test_another_mission_stored_in_flight_ends_the_streaming_and_is_planned():
    scene = Scene()
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.stage is Stage.FLYING)
    scene.world.items = scene.world.items[:3]
    scene.world.tell_mission()
    scene.fly(until=lambda: len(scene.planner.requests) == 2)
    assert scene.station.following.done
    assert len(scene.planner.requests[1].items) == 3


def test_a_paused_mission_is_planned_from_where_it_hovers_and_goes_on_with_it():
    scene = Scene()
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.stage is Stage.FLYING)
    scene.fly(0.6)
    scene.world.velocity = np.zeros(3)
    scene.world.mission_state = 4
    scene.world.set_mode(HOLD)
    scene.world.tell_mission()
    scene.fly(until=lambda: len(scene.planner.requests) == 2 and scene.station.state is State.READY)
    rest = scene.planner.requests[1]
    assert rest.from_item == 2
    assert rest.start == pytest.approx(tuple(scene.world.position * [1, -1, -1]), abs=1e-3)
    scene.world.mission_state = 3
    scene.world.set_mode(MISSION)
    scene.fly(0.1)
    assert scene.world.mode == OFFBOARD


def test_an_item_chosen_while_paused_is_planned_for_and_flown_to():
    scene = flying_scene()
    pause(scene)
    scene.fly(until=lambda: len(scene.planner.requests) == 2 and scene.station.state is State.READY)
    scene.world.seq = 3
    scene.world.tell_mission()
    scene.fly(until=lambda: len(scene.planner.requests) == 3 and scene.station.state is State.READY)
    assert scene.planner.requests[2].from_item == 3
    go_on(scene)
    scene.fly(0.1)
    assert scene.world.mode == OFFBOARD


@pytest.mark.parametrize("chosen", [0, 3])
def test_an_item_chosen_while_the_plan_is_flown_is_left_to_the_autopilot(chosen):
    scene = flying_scene()
    scene.fly(0.6)
    scene.world.seq = chosen
    scene.world.tell_mission()
    scene.fly(0.5)
    assert scene.world.mode == MISSION
    assert scene.world.seq == chosen
    assert scene.station.following.done
    assert texts_of(scene)[-1] == f"Mission: plan left, item {chosen} was chosen"


def test_a_rest_that_is_planned_too_late_does_not_fly_back():
    scene = flying_scene(lockstep=False)
    scene.planner.patience = 10**9
    pause(scene)
    scene.fly(until=lambda: len(scene.planner.requests) == 2)
    go_on(scene)
    scene.world.position = np.array([1.5, 0.0, -2.0])
    scene.planner.patience = 1
    scene.fly(0.5)
    assert scene.world.mode == MISSION
    assert texts_of(scene).count("Mission: plan is late: pause and continue") == 1

"""Who flies when: the station against an autopilot that writes down what it heard."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from fake_autopilot import HOLD, LAND, MISSION, OFFBOARD
from station_scene import ITEMS, LEG, PerfectFlight, Scene, T, flying_scene, texts_of

from halfroll.errors import PlanError
from halfroll.station.following import Stage
from halfroll.station.station import State
from halfroll.wire import messages as wire


def test_a_stored_mission_is_downloaded_and_planned_and_everybody_is_told():
    scene = Scene()
    scene.fly(until=lambda: scene.station.state is State.READY)
    (request,) = scene.planner.requests
    assert request.items == ITEMS
    assert (request.home, request.origin, request.takeoff_altitude) == (request.origin, request.home, 2.5)
    texts = [frame.text for _, frame in scene.world.heard if frame.get_type() == "STATUSTEXT"]
    assert texts == ["Mission: planning", "Mission: plan ready, 1.00 s"]


def test_the_echo_is_withheld_while_anything_is_open_or_a_plan_is_made():
    scene = Scene()
    scene.planner.patience = 10**9
    scene.fly(until=lambda: scene.station.state is State.PLANNING)
    standing = scene.world.t_ms
    for _ in range(500):
        scene.world.tick()
        scene.turn()
    assert scene.world.t_ms == standing
    scene.planner.patience = 1
    scene.fly(1.0)
    assert scene.world.t_ms > standing


def test_heartbeats_go_out_by_the_wall_clock_while_time_stands():
    scene = Scene()
    scene.planner.patience = 10**9
    scene.fly(until=lambda: scene.station.state is State.PLANNING)
    before = scene.world.names_heard().count("HEARTBEAT")
    for _ in range(12):
        scene.wall_s += 0.25
        scene.turn()
    assert scene.world.names_heard().count("HEARTBEAT") == before + 3


def test_after_a_question_time_is_asked_before_time_goes_on():
    scene = Scene()
    scene.fly(until=lambda: scene.station.state is State.READY)
    kinds = [(f.get_type(), getattr(f, "tc1", None)) for _, f in scene.world.heard]
    last_question = max(i for i, (kind, _) in enumerate(kinds) if kind in ("PARAM_REQUEST_READ", "MISSION_REQUEST_INT"))
    times = [tc1 for kind, tc1 in kinds[last_question:] if kind == "TIMESYNC"]
    assert times[0] == 0  # the fence
    assert times[1] != 0  # the echo


def test_a_lost_echo_is_sent_again_when_it_is_asked_for_again():
    scene = Scene()
    scene.fly(0.05)
    echoes = scene.world.names_heard().count("TIMESYNC")
    scene.world.ask_time()
    scene.turn()
    assert scene.world.names_heard().count("TIMESYNC") == echoes + 1


def test_the_takeover_goes_in_the_agreed_order():
    scene = Scene()
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.done)
    heard = [(t, f) for t, f in scene.world.heard if f.get_type() in ("COMMAND_LONG", "SET_ATTITUDE_TARGET")]
    (at_takeover, first), (_, second) = heard[:2]
    assert (first.get_type(), first.command, first.param2) == ("COMMAND_LONG", 176, 6.0)
    assert second.get_type() == "SET_ATTITUDE_TARGET"
    record = scene.station.following.record
    assert record.plan_start_s >= at_takeover * 1e-3 + 0.5  # it settles before the plan's clock starts
    assert [c[:2] for c in scene.world.commands() if c[0] == 224] == [(224, 1.0), (224, 2.0), (224, 3.0)]
    assert scene.world.commands()[-1] == (176, 1.0, 4.0, 4.0)
    assert scene.world.mode == MISSION
    assert scene.station.state is State.READY
    assert record.plan_end_s - record.plan_start_s == pytest.approx(T)


def test_items_are_reported_when_the_plan_passes_them():
    scene = Scene()
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.done)
    start_ms = scene.station.following.record.plan_start_s * 1e3
    when = {f.param1: t for t, f in scene.world.heard if f.get_type() == "COMMAND_LONG" and f.command == 224}
    assert [when[seq] - start_ms for seq in (1, 2, 3)] == pytest.approx([0.0, 1e3 * LEG, 1e3 * T])


def test_every_telemetry_tick_brings_exactly_one_reference_with_its_stamp():
    scene = Scene()
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.done)
    stamps = [frame.time_boot_ms for frame in scene.world.setpoints()]
    assert stamps == list(range(stamps[0], stamps[-1] + 1, 10))
    assert scene.station.following.record.rate_hz(by_wall_clock=False) == pytest.approx(100.0)
    assert all(frame.thrust == pytest.approx(5.6 / 12.0) for frame in scene.world.setpoints())


@pytest.mark.parametrize("lockstep", [True, False])
@pytest.mark.parametrize("mode", [HOLD, LAND, MISSION])
def test_a_mode_that_a_user_commands_ends_the_streaming_at_once(mode, lockstep):
    scene = Scene(lockstep)
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.stage is Stage.FLYING)
    scene.fly(0.2)
    scene.world.set_mode(mode)
    sent = len(scene.world.setpoints())
    scene.fly(1.0)
    assert len(scene.world.setpoints()) <= sent + 1  # one tick may be on its way
    assert scene.world.mode == mode
    assert "released" in scene.kinds()


def test_nothing_is_streamed_where_offboard_is_refused():
    scene = Scene()
    scene.world.refuse[176] = wire.TEMPORARILY_REJECTED
    scene.start()
    scene.fly(1.0)
    assert len(scene.world.setpoints()) <= 2
    assert scene.station.state is State.READY


def test_a_start_that_is_not_reached_is_given_back_to_the_autopilot():
    scene = Scene()
    scene.station._make_references = lambda *_: PerfectFlight(SimpleNamespace())  # moves another world
    scene.start()
    scene.world.position = np.array([0.2, 0.0, -2.0])
    scene.fly(until=lambda: scene.station.following is not None)
    scene.fly(until=lambda: scene.station.following.done)
    assert scene.world.mode == MISSION
    assert scene.station.following.record.plan_start_s is None
    assert "did not settle" in scene.events[-1].text


def test_a_plan_that_is_ready_too_late_leaves_the_flight_to_the_autopilot_and_says_how_to_get_it():
    scene = Scene(lockstep=False)
    scene.planner.patience = 10**9
    scene.fly(until=lambda: scene.station.state is State.PLANNING)
    scene.world.armed, scene.world.mission_state = True, 3
    scene.world.set_mode(MISSION)
    scene.fly(0.1)
    scene.world.reach(0)
    scene.fly(0.5)
    scene.planner.patience = 1
    scene.fly(0.5)
    assert scene.world.setpoints() == []
    texts = [frame.text for _, frame in scene.world.heard if frame.get_type() == "STATUSTEXT"]
    assert texts[-1] == "Mission: plan is late: pause and continue"


def test_a_home_that_moves_is_planned_for_again():
    scene = Scene()
    scene.fly(until=lambda: scene.station.state is State.READY)
    scene.world.home = np.array([0.04, 0.0, 0.0])
    scene.fly(1.1)
    assert len(scene.planner.requests) == 1
    scene.world.home = np.array([0.1, 0.0, 0.0])
    scene.fly(1.1)
    assert len(scene.planner.requests) == 2


def test_a_vehicle_far_from_its_plan_is_given_back():
    scene = flying_scene()
    scene.station.following._references.world = SimpleNamespace()  # it moves no longer
    scene.world.position = np.array([0.0, 1.2, -2.0])
    scene.fly(0.08)
    assert scene.world.mode == OFFBOARD  # as yet
    scene.fly(0.2)
    assert scene.world.mode == MISSION
    assert "from the plan" in texts_of(scene)[-1]


def test_another_vehicle_than_the_one_that_is_planned_for_is_not_taken_over():
    scene = Scene()
    scene.world.params["ATT_WN"] = 10.0
    scene.fly(until=lambda: scene.station.outcome is not None)
    assert texts_of(scene) == ["Mission: no plan, ATT_WN is 10, mit-vp has 16"]
    scene.world.armed, scene.world.mission_state = True, 3
    scene.world.set_mode(MISSION)
    scene.world.reach(0)
    scene.fly(1.0)
    assert scene.world.setpoints() == []
    assert scene.planner.requests == []
    scene.world.send("param_value", b"ATT_WN", 16.0, 9, 45, 0)  # somebody sets it right
    scene.fly(0.5)
    assert len(scene.planner.requests) == 1


def test_another_takeoff_height_is_planned_for_again():
    scene = Scene()
    scene.fly(until=lambda: scene.station.state is State.READY)
    scene.world.send("param_value", b"MIS_TAKEOFF_ALT", 10.0, 9, 45, 0)
    scene.fly(0.5)
    assert [request.takeoff_altitude for request in scene.planner.requests] == [2.5, 10.0]


def test_a_mission_that_cannot_be_planned_is_left_to_the_autopilot_with_a_word():
    scene = Scene(outcome=PlanError("segment 1 needs 4 N of 3 N; move the waypoint", 2))
    scene.fly(until=lambda: scene.station.outcome is not None)
    texts = [frame.text for _, frame in scene.world.heard if frame.get_type() == "STATUSTEXT"]
    assert texts[-1] == "Mission: not planned, item 2"
    scene.world.armed, scene.world.mission_state = True, 3
    scene.world.set_mode(MISSION)
    scene.world.reach(0)
    scene.fly(1.0)
    assert scene.world.setpoints() == []

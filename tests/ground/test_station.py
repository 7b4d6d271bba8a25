"""Who flies when: the station and the pilot against an autopilot that writes down what it heard."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from fake_autopilot import HOLD, LAND, MISSION, OFFBOARD, FakeAutopilot

from halfroll import link as wire
from halfroll import segments
from halfroll.course import Course
from halfroll.crew import hear_all
from halfroll.errors import FlightError, MissionError, PlanError
from halfroll.following import Stage
from halfroll.link import Link
from halfroll.mission import Mission, MissionItem, Waypoint
from halfroll.pilot import Pilot
from halfroll.planning import Planned
from halfroll.record import Event
from halfroll.references import Path
from halfroll.station import State, Station
from halfroll.transport import MemoryTransport
from halfroll.vehicle import load_vehicle

NAN = math.nan
ITEMS = (
    MissionItem(22, 3, (0.0, 0.0, 0.0, NAN), 473977420, 85455940, 2.0),
    MissionItem(16, 3, (0.0, 0.0, 0.0, NAN), 473977510, 85455940, 2.0),
    MissionItem(16, 3, (0.0, 0.0, 0.0, NAN), 473977600, 85455940, 2.0),
    MissionItem(21, 3, (0.0, 0.0, 0.0, NAN), 473977600, 85455940, 0.0),
)
T, LEG = 1.0, 0.5


def planned_flight() -> Planned:
    """1 m north in two legs of half a second, 2 m above home."""
    points = [(0.0, 0.0, 2.0), (0.5, 0.0, 2.0), (1.0, 0.0, 2.0)]
    nodes = [segments.rest([*point, 0.0]) for point in points]
    pieces = segments.solve(nodes, [LEG, LEG])
    waypoints = tuple(Waypoint(point, item=item) for item, point in enumerate(points))
    t = np.arange(1001) * 1e-3
    path = Path(pieces.derivatives(t, 5), np.zeros((1001, 3)))
    plan = SimpleNamespace(T=T, times_s=(0.0, LEG, T), waypoints=waypoints)
    return Planned(Course(waypoints, first_item=0, last_item=2, hands_back_to=3), plan, path)


class SlowPlanner:
    """Its outcome is there when asked for the `patience`-th time."""

    def __init__(self, outcome=None, patience=3):
        self.outcome, self.patience, self.requests, self.asked = outcome or planned_flight(), patience, [], 0

    def submit(self, request):
        self.requests.append(request)
        self.asked = 0

    def poll(self):
        self.asked += 1
        return self.outcome if self.asked >= self.patience else None

    def progress(self):
        return None


class PerfectFlight:
    """In the place of the references: the vehicle is wherever the path is at the last tick."""

    def __init__(self, world):
        self.world = world

    def begin(self, here):
        pass

    def setpoint(self, path, start_us, here):
        point = path.at((here.t_us - start_us) * 1e-6 + 0.01)
        self.world.position = point[0, :3] * [1, -1, -1]
        self.world.velocity = point[1, :3] * [1, -1, -1]
        return SimpleNamespace(q_WD=np.array([1.0, 0, 0, 0]), w_WD_D=np.zeros(3), thrust=5.6)


class Scene:
    """Station, optional pilot and autopilot, connected without sockets or clocks."""

    def __init__(self, lockstep=True, outcome=None, items=ITEMS, pilot=False):
        ours, theirs = zip(*(MemoryTransport.pair() for _ in range(2)), strict=True)
        self.world = FakeAutopilot(list(theirs), lockstep=lockstep)
        self.link, gcs = Link(ours[0], wire.GROUND), Link(ours[1], wire.GCS, wire.GCS_SYSTEM)
        self.events: list[Event] = []
        self.planner, self.wall_s = SlowPlanner(outcome), 0.0
        self.station = Station(
            self.link,
            load_vehicle("mit-vp"),
            self.planner,
            report=self.events.append,
            clock=lambda: self.wall_s,
            make_references=lambda vehicle, params, delay: PerfectFlight(self.world),
        )
        station = self.station
        self.pilot = None
        if pilot:
            self.pilot = Pilot(
                gcs,
                Mission("four", items),
                may_start=lambda: station.outcome is not None,
                plan_error=lambda: station.plan_error,
                report=self.events.append,
                clock=lambda: 0.0,
            )
        else:
            self.world.mission_state = 2
            self.world.items = [stored(item) for item in items]
        self.links, self.hearers = [self.link, gcs], [station.hear, self.pilot.hear if self.pilot else lambda _: None]
        self.world.heartbeat()

    def turn(self):
        """One turn of the ground's loop."""
        while hear_all(self.links, self.hearers):
            self.world.listen()
        self.station.go_on()
        if self.pilot:
            self.pilot.go_on()
        self.station.answer_time(others_wait=bool(self.pilot and self.pilot.awaits_answer))
        self.world.listen()

    def fly(self, seconds=0.0, until=lambda: False):
        """Vehicle time goes on; in lockstep only when the ground lets it."""
        end_ms, turns = self.world.t_ms + 1000 * seconds, 0
        while not until() and (seconds == 0.0 or self.world.t_ms < end_ms):
            turns += 1
            assert turns < 20_000, "it never came to pass"
            self.world.tick()
            self.turn()
            self.turn()

    def start(self):
        """Armed in MISSION, with a plan, hovering over the takeoff point which it has just reached."""
        self.fly(until=lambda: self.station.state is State.READY)
        self.world.armed, self.world.mission_state = True, 3
        self.world.set_mode(MISSION)
        self.world.position = np.array([0.0, 0.0, -2.0])
        self.fly(0.1)
        self.world.reach(0)

    def kinds(self):
        return [event.kind for event in self.events]


def stored(item: MissionItem) -> SimpleNamespace:
    names = ("param1", "param2", "param3", "param4", "command", "frame", "x", "y", "z", "autocontinue")
    fields = (*item.params, item.command, item.frame, item.x, item.y, item.z, int(item.autocontinue))
    return SimpleNamespace(**dict(zip(names, fields, strict=True)))


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


def test_the_station_does_not_take_over_in_the_middle_of_a_mission():
    scene = Scene()
    scene.fly(until=lambda: scene.station.state is State.READY)
    scene.world.armed, scene.world.mission_state, scene.world.seq = True, 3, 2
    scene.world.set_mode(MISSION)
    scene.fly(1.0)
    assert scene.world.setpoints() == []


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


def test_another_mission_stored_in_flight_ends_the_streaming_and_is_planned():
    scene = Scene()
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.stage is Stage.FLYING)
    scene.world.items = scene.world.items[:3]
    scene.world.tell_mission()
    scene.fly(until=lambda: len(scene.planner.requests) == 2)
    assert scene.station.following.done
    assert len(scene.planner.requests[1].items) == 3


def test_a_home_that_moves_is_planned_for_again():
    scene = Scene()
    scene.fly(until=lambda: scene.station.state is State.READY)
    scene.world.home = np.array([0.04, 0.0, 0.0])
    scene.fly(1.1)
    assert len(scene.planner.requests) == 1
    scene.world.home = np.array([0.1, 0.0, 0.0])
    scene.fly(1.1)
    assert len(scene.planner.requests) == 2


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


def texts_of(scene):
    return [frame.text for _, frame in scene.world.heard if frame.get_type() == "STATUSTEXT"]


def flying_scene(lockstep=True):
    scene = Scene(lockstep)
    scene.start()
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.stage is Stage.FLYING)
    return scene


def pause(scene):
    scene.world.velocity = np.zeros(3)
    scene.world.mission_state = 4
    scene.world.set_mode(HOLD)
    scene.world.tell_mission()


def go_on(scene):
    scene.world.mission_state = 3
    scene.world.set_mode(MISSION)
    scene.world.tell_mission()


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


def test_the_pilot_flies_a_mission_through_the_door_of_any_ground_control_station():
    scene = Scene(pilot=True)
    scene.fly(until=lambda: scene.world.armed)
    scene.world.mission_state = 3
    scene.world.position = np.array([0.0, 0.0, -2.0])
    scene.fly(0.1)
    scene.world.reach(0)
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.done)
    scene.world.mission_state, scene.world.armed = 5, False
    scene.world.set_mode(HOLD)
    scene.fly(until=lambda: scene.pilot.done)
    numbers = [command[0] for command in scene.world.commands()]
    assert [n for n in numbers if n in (176, 400, 246)] == [176, 400, 176, 176, 246]  # start, arm, take over, back, off
    kinds = scene.kinds()
    told = ("uploaded", "planned", "armed", "approach", "flying", "handed-back", "landed")
    assert [kinds.index(kind) for kind in told] == sorted(kinds.index(kind) for kind in told)


def test_the_pilot_does_not_start_before_the_mission_is_planned():
    scene = Scene(pilot=True)
    scene.planner.patience = 10**9
    scene.fly(until=lambda: scene.station.state is State.PLANNING)
    for _ in range(300):
        scene.world.tick()
        scene.turn()
    assert 400 not in [command[0] for command in scene.world.commands()]


def test_an_item_that_the_autopilot_refuses_at_start_is_named():
    scene = Scene(pilot=True)
    scene.world.refuse[400] = wire.TEMPORARILY_REJECTED
    scene.fly(until=lambda: scene.station.outcome is not None)
    scene.world.send("statustext", 4, b"Arming denied: item 2 is below ground")
    with pytest.raises(MissionError, match="item 2 is below ground") as caught:
        scene.fly(30.0)
    assert (caught.value.item, caught.value.exit_code) == (2, 2)


def test_arming_is_tried_again_until_the_autopilot_is_ready():
    scene = Scene(pilot=True)
    scene.world.refuse[400] = wire.TEMPORARILY_REJECTED
    scene.fly(5.0)
    assert not scene.world.armed
    del scene.world.refuse[400]
    scene.fly(until=lambda: scene.world.armed)
    assert [command[0] for command in scene.world.commands()].count(400) > 5


def test_a_vehicle_that_will_not_arm_ends_the_flight_with_its_own_words():
    scene = Scene(pilot=True)
    scene.world.refuse[400] = wire.TEMPORARILY_REJECTED
    scene.fly(until=lambda: scene.station.outcome is not None)
    scene.world.send("statustext", 4, b"Arming denied: battery low")
    with pytest.raises(FlightError, match="battery low"):
        scene.fly(30.0)


def test_a_landing_before_the_mission_is_complete_is_a_failed_flight():
    scene = Scene(pilot=True)
    scene.fly(until=lambda: scene.world.armed)
    scene.fly(1.0)
    scene.world.armed = False
    scene.world.set_mode(HOLD)
    with pytest.raises(FlightError, match="before the mission was complete") as caught:
        scene.fly(3.0)
    assert caught.value.exit_code == 1


def test_a_vehicle_that_never_takes_off_ends_the_flight(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("halfroll.pilot.TAKEOFF_PATIENCE_S", 0.05)
    scene = Scene(pilot=True)
    with pytest.raises(FlightError, match="did not take off within"):
        scene.fly(30.0)

"""Station, pilot and an autopilot that writes down what it heard, without sockets or clocks: what their tests share."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
from fake_autopilot import HOLD, MISSION, FakeAutopilot

from halfroll.missions.mission import Mission, MissionItem, Waypoint
from halfroll.planner import segments
from halfroll.planner.course import Course
from halfroll.station.crew import hear_all
from halfroll.station.following import Stage
from halfroll.station.pilot import Pilot
from halfroll.station.planning import Planned
from halfroll.station.record import Event
from halfroll.station.references import Path
from halfroll.station.station import State, Station
from halfroll.vehicle import load_vehicle
from halfroll.wire import messages as wire
from halfroll.wire.link import Link
from halfroll.wire.transport import MemoryTransport

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

"""The ground station: plans every mission stored in the autopilot, and flies the plan by 100 references a second.

Why: this is the pipeline, and who flies when. The autopilot takes off; once the first planned item is reached in
MISSION the station streams, asks for OFFBOARD, settles at the plan's start, flies it, reports the items it passes and
hands back. Whatever a user commands ends the streaming at once. It never blocks, and asks a clock for heartbeats and
lost answers only: its time is the telemetry's.

    IDLE -> PLANNING -> READY -> FLYING (following.py: approach, flying, hand back) -> READY
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

from halfroll.errors import HalfrollError, VehicleError
from halfroll.missions.mission import DEFAULT_OPTIONS, NO_RULES, Mission, MissionItem, PlanOptions
from halfroll.station import references
from halfroll.station.following import START_SPEED, Following
from halfroll.station.planning import NothingToPlan, Outcome, Planned, Planner, PlanRequest
from halfroll.station.record import Event
from halfroll.station.references import References
from halfroll.vehicle import Vehicle
from halfroll.wire import conversations
from halfroll.wire import messages as wire
from halfroll.wire.barrier import Barrier
from halfroll.wire.conversations import Conversation, Talk
from halfroll.wire.link import Link
from halfroll.wire.messages import Message, MissionCurrent, Telemetry
from halfroll.wire.transport import Clock, wall_s

HEARTBEAT_S = 1.0
HOME_MOVED = 0.05  # [m] beyond this the plan is made again
PAUSED_MOVED = 0.5  # [m] beyond this the rest of a paused mission is planned again
LATE_MOVED = 1.0  # [m] beyond this a mission that went on is not taken back to where its rest was planned from
RESTARTED_US = 1_000_000  # time that goes back by more began anew
LONGEST_ROUND_TRIP_S = 0.05  # a reference that is older than this when it comes is not flown as of its stamp
LINK_DELAY_S = 0.002  # assumed of the wire in real time; none in lockstep
_GLOBAL_ORIGIN, _HOME_POSITION = 49, 242  # message ids
_TAKEOFF_ALTITUDE = "MIS_TAKEOFF_ALT"


class State(Enum):
    IDLE = "no plan"
    PLANNING = "planning"
    READY = "plan ready"
    FLYING = "streaming"


@dataclass(frozen=True)
class Facts:
    """What the autopilot was asked before planning."""

    mission_id: int
    items: tuple[MissionItem, ...]
    params: dict[str, float]


MakeReferences = Callable[[Vehicle, dict[str, float], float], References]


class Station:
    """Give it every message of its link (`hear`); when all that has come was heard, `go_on`, then `answer_time`.

    finer: a mission whose own waypoints and rules are planned when its items are what is stored; other_links: in
    lockstep, time waits for what is asked on these, too.
    """

    def __init__(
        self,
        link: Link,
        vehicle: Vehicle,
        planner: Planner,
        options: PlanOptions = DEFAULT_OPTIONS,
        finer: Mission | None = None,
        other_links: Sequence[Link] = (),
        report: Callable[[Event], None] = lambda _: None,
        clock: Clock = wall_s,
        make_references: MakeReferences = references.for_vehicle,
    ) -> None:
        self._link, self._vehicle, self._planner, self._options = link, vehicle, planner, options
        self._finer, self._report, self._clock, self._make_references = finer, report, clock, make_references
        self._barrier = Barrier((link, *other_links), clock)
        self._heartbeat_s = -math.inf
        # what the autopilot says of itself
        self._mode, self._armed = 0, False
        self._current: MissionCurrent | None = None
        self._home: wire.Home | None = None
        self._origin: wire.Origin | None = None
        self._here: Telemetry | None = None
        # one conversation at a time, the others wait in order
        self._talk: Talk[Any] | None = None
        self._then: Callable[[Any], None] = lambda _: None
        self._waiting: deque[tuple[Conversation[Any], Callable[[Any], None]]] = deque()
        # plan and flight
        self.state = State.IDLE
        self.outcome: Outcome | HalfrollError | None = None  # of the stored mission
        self.following: Following | None = None  # the latest
        self._facts: Facts | None = None
        self._request: PlanRequest | None = None
        self._planned_home = np.zeros(3)
        self._take_over_due, self._flown = False, False
        self._missed = False  # items are reached without a plan being flown
        self._late: PlanRequest | None = None  # said to be late
        self._other_vehicle: str | None = None  # why this is not the one that is planned for

    @property
    def lockstep(self) -> bool:
        return self._barrier.active

    @property
    def here(self) -> Telemetry | None:
        """Where the vehicle is, as last heard."""
        return self._here

    @property
    def planned(self) -> Planned | None:
        return self.outcome if isinstance(self.outcome, Planned) else None

    @property
    def plan_error(self) -> HalfrollError | None:
        return self.outcome if isinstance(self.outcome, HalfrollError) else None

    def hear(self, message: Message) -> None:
        self._barrier.hear(message)
        if self._talk:
            self._talk.hear(message)
            self._next_talk()
            self._settle_following()
        if isinstance(message, Telemetry):
            self._tick(message)
        elif isinstance(message, wire.Heartbeat):
            self._hear_mode(message.mode, message.armed)
        elif isinstance(message, MissionCurrent):
            self._hear_mission(message)
        elif isinstance(message, wire.ItemReached):
            self._hear_reached(message.seq)
        elif isinstance(message, wire.Home):
            self._hear_home(message)
        elif isinstance(message, wire.ParamValue):
            self._hear_param(message)
        elif isinstance(message, wire.Origin):
            self._origin = message

    def go_on(self) -> None:
        """Heartbeat, lost answers, the planner's outcome. Raises NoAnswer when the autopilot has stopped answering."""
        if self._clock() - self._heartbeat_s >= HEARTBEAT_S and self._link.vehicle_system is not None:
            self._heartbeat_s = self._clock()
            self._link.send(self._link.heartbeat())
        if self._talk:
            self._talk.go_on()
            self._next_talk()
        if self.state is State.PLANNING:
            self._hear_planner()

    def answer_time(self, others_wait: bool = False) -> None:
        """Lockstep: time goes on unless a question is open, here or elsewhere, or a plan is being made."""
        self._barrier.release(self._talk is not None or self.state is State.PLANNING or others_wait)

    def _converse(self, conversation: Conversation[Any], then: Callable[[Any], None] = lambda _: None) -> None:
        self._waiting.append((conversation, then))
        self._next_talk()

    def _next_talk(self) -> None:
        while self._talk is None or self._talk.done:
            if self._talk:
                talk, self._talk = self._talk, None
                self._then(talk.result)
            elif self._waiting:
                conversation, self._then = self._waiting.popleft()
                self._talk = Talk(self._link, conversation, self._clock)
            else:
                return

    # From a stored mission to a plan.

    def _hear_mission(self, current: MissionCurrent) -> None:
        before, self._current = self._current, current
        if self.following:
            self.following.hear_current(current.seq)
        if before is None or current.mission_id != before.mission_id:
            self._stop("the mission was changed")
            self.state, self.outcome, self._facts, self._request = State.IDLE, None, None, None
            self._other_vehicle = None
            if current.mission_id:
                self._tell("mission", f"{current.total} items are stored")
                self._converse(self._ask_facts(current.mission_id), self._hear_facts)
        elif self.planned and before.seq != current.seq and self._is_over_start(current.seq):
            self._hear_reached(self.planned.course.first_item)  # which was said once, and lost

    def _is_over_start(self, seq: int) -> bool:
        """The takeoff has given way to the first planned item, and it is still near the plan's start."""
        if not self.planned or self._is_rest or self._here is None or seq not in self._after_takeoff[1:]:
            return False
        start = self.planned.course.waypoints[0].position
        return bool(np.linalg.norm(self._here.p_WB - start) < LATE_MOVED)

    @property
    def _after_takeoff(self) -> range:
        """Items of which one is current when the takeoff was just reached: it, or what leads to the next place."""
        if not self.planned:
            return range(0)
        first, following = self.planned.course.first_item, self.planned.course.waypoints[1].item
        return range(first, 1 + max(first, following or 0))

    def _ask_facts(self, mission_id: int) -> Conversation[Facts]:
        _, items = yield from conversations.download(self._link)
        params = yield from conversations.read_params(self._link, (*references.PARAMETERS, _TAKEOFF_ALTITUDE))
        for known, message in ((self._origin, _GLOBAL_ORIGIN), (self._home, _HOME_POSITION)):
            if known is None:  # refused while the autopilot does not know it itself; it comes unasked later
                command = conversations.REQUEST_MESSAGE
                yield from conversations.command(self._link, command, float(message), what="a request for a message")
        return Facts(mission_id, items, params)

    def _hear_facts(self, facts: Facts) -> None:
        if self._current and facts.mission_id == self._current.mission_id:
            self._facts = facts
            self._identify()

    def _hear_param(self, changed: wire.ParamValue) -> None:
        facts = self._facts
        if facts and facts.params.get(changed.name, changed.value) != changed.value:
            self._facts = replace(facts, params={**facts.params, changed.name: changed.value})
            self._identify()
            if changed.name == _TAKEOFF_ALTITUDE:
                self._plan_again()

    def _identify(self) -> None:
        """References for another vehicle would crash this one: it is neither planned for nor taken over."""
        why = references.other_vehicle(self._vehicle, self._facts.params) if self._facts else None
        if why == self._other_vehicle or self.state is State.FLYING:
            return
        self._other_vehicle, self._take_over_due = why, False
        self.state, self._request, self.outcome = State.IDLE, None, None
        if why:
            advice = "start the ground station with the --vehicle or --set of the autopilot"
            self.outcome = VehicleError(f"the autopilot flies another vehicle: {why}; {advice}")
            self._say(f"no plan, {why}", severity=wire.WARNING)
            self._tell("plan-failed", str(self.outcome))

    def _hear_home(self, home: wire.Home) -> None:
        self._home = home
        if self._request is not None and np.linalg.norm(home.p_WB - self._planned_home) > HOME_MOVED:
            self._plan_again()

    def _plan_again(self) -> None:
        """What a plan of the whole mission was made from has changed."""
        if self._request is not None and not self._is_rest and self.state is not State.FLYING:
            self.state, self.outcome, self._request = State.IDLE, None, None

    def _plan(self, here: Telemetry, rest_from: int | None = None) -> None:
        """Asks for a plan if all it needs is known. rest_from: of what is left from that item on, from here."""
        if self._other_vehicle or not (self._facts and self._home and self._origin):
            return
        self._planned_home = self._home.p_WB
        known = self._finer if self._finer and self._finer.items == self._facts.items else None
        self._request = PlanRequest(
            items=self._facts.items,
            origin=self._origin.place,
            home=self._home.place,
            takeoff_altitude=self._facts.params[_TAKEOFF_ALTITUDE],
            start_yaw=references.heading(here.q_WB),
            vehicle=self._vehicle,
            options=self._options,
            waypoints=known.waypoints if known else None,
            rules=known.rules if known else NO_RULES,
            from_item=rest_from,
            start=None if rest_from is None else (float(here.p_WB[0]), float(here.p_WB[1]), float(here.p_WB[2])),
        )
        self._planner.submit(self._request)
        self.state, self.outcome = State.PLANNING, None
        self._say("planning", "planning")

    def _hear_planner(self) -> None:
        said = self._planner.progress()
        if said:
            self._tell("plan-progress", said)
        self.outcome = outcome = self._planner.poll()
        if outcome is None:
            return
        self.state = State.IDLE
        if isinstance(outcome, HalfrollError):
            self._say("not planned" + ("" if outcome.item is None else f", item {outcome.item}"), severity=wire.WARNING)
            self._tell("plan-failed", str(outcome), item=outcome.item)
        elif isinstance(outcome, NothingToPlan):
            self._say("nothing to plan, flown on board", "plan-failed")
        else:
            self.state = State.READY
            self._say(f"plan ready, {outcome.plan.T:.2f} s", "planned", planned=outcome)
            self._take_over_due = self._is_rest and self._mode == wire.MISSION
            if self._armed and not self._take_over_due and self._missed:
                self._say_late()

    # Who flies.

    @property
    def _is_rest(self) -> bool:
        """The plan is of what is left of a paused mission: it takes over when the mission goes on, wherever that is."""
        return self._request is not None and self._request.start is not None

    def _hear_mode(self, mode: int, armed: bool) -> None:
        before, self._mode, self._armed = self._mode, mode, armed
        if self.following:
            self.following.hear_mode(mode, armed)
            self._settle_following()
        if not armed:
            self._flown = self._take_over_due = self._missed = False
            self._late = None
            if self._is_rest:  # the next flight begins at the beginning
                self.state, self.outcome, self._request = State.IDLE, None, None
        elif (before, mode) == (wire.HOLD, wire.MISSION) and self._is_rest:
            self._take_over_due = self.state is State.READY

    def _hear_reached(self, seq: int) -> None:
        self._missed = self._mode == wire.MISSION and self.state is not State.FLYING and not self._flown
        if self._missed and self.planned and seq == self.planned.course.first_item:
            self._missed, self._take_over_due = False, True

    def _tick(self, here: Telemetry) -> None:
        """Every 10 ms of vehicle time, once."""
        if self._here and self._here.t_us - RESTARTED_US < here.t_us <= self._here.t_us:
            return
        self._here = here
        if self._request is None and self.state is State.IDLE:
            self._plan(here)
        self._replan_if_paused(here)
        if self._take_over_due and self.state is State.READY and self._mode == wire.MISSION and self._armed:
            self._take_over(here)
        if self.following and self.state is State.FLYING:
            self.following.tick(here)
            self._settle_following()

    def _replan_if_paused(self, here: Telemetry) -> None:
        """In HOLD and at rest with a mission half flown: plan what is left from here."""
        paused = self._mode == wire.HOLD and self._armed and self._current and self._current.state == wire.PAUSED
        if not (paused and self.state is not State.FLYING and np.linalg.norm(here.v_WB) < START_SPEED):
            return
        if self._current and not self._is_rest_from(here, PAUSED_MOVED):
            self._plan(here, rest_from=self._current.seq)

    def _is_rest_from(self, here: Telemetry, distance: float) -> bool:
        """The plan, made or being made, goes on from no farther than `distance` [m], with the current item."""
        start = self._request.start if self._request else None
        if start is None or not self._request or not self._current or self._request.from_item != self._current.seq:
            return False
        return bool(np.linalg.norm(here.p_WB - start) <= distance)

    def _say_late(self) -> None:
        if self._mode == wire.MISSION and self._late is not self._request:
            self._late = self._request
            self._say("plan is late: pause and continue", "late", wire.NOTICE)

    def _take_over(self, here: Telemetry) -> None:
        if not (self.planned and self._facts and self._current):
            return
        if self._is_rest and not self._is_rest_from(here, LATE_MOVED):  # it went on by itself meanwhile
            self._take_over_due = False
            self._say_late()
            return
        round_trip_s = min(self._link.round_trips_s, default=0.0)
        if round_trip_s > LONGEST_ROUND_TRIP_S and not self.lockstep:
            self._take_over_due = False
            self._say(f"link too slow for the plan, {1e3 * round_trip_s:.0f} ms", "late", wire.WARNING)
            return
        delay = 0.0 if self.lockstep else LINK_DELAY_S
        loop = self._make_references(self._vehicle, self._facts.params, delay)
        self.state, self._take_over_due, self._flown = State.FLYING, False, True
        thrust_reference = self._facts.params["VEH_T_REF"]
        seq = self._current.seq
        self.following = Following(
            self._link,
            self.planned,
            loop,
            thrust_reference,
            here,
            self._after_takeoff if seq in self._after_takeoff and not self._is_rest else range(seq, seq + 1),
            self._converse,
            self._report,
            self._clock,
        )

    def _settle_following(self) -> None:
        if self.state is State.FLYING and self.following and self.following.done:
            self.state = State.READY
            self._waiting.clear()
            if self.following.ended is None:
                self._mode = wire.MISSION  # as it was just granted; the heartbeat says so later

    def _stop(self, why: str) -> None:
        if self.following:
            self.following.end(why)
            self._settle_following()
        self._take_over_due = False

    # What people hear.

    def _say(
        self, text: str, kind: str | None = None, severity: int = wire.INFO, planned: Planned | None = None
    ) -> None:
        """To every ground station, through the autopilot."""
        self._link.send(self._link.status_text(f"Mission: {text}", severity))
        if kind:
            self._report(Event(kind, self._link.t_us * 1e-6, text, planned=planned))

    def _tell(self, kind: str, text: str, item: int | None = None) -> None:
        self._report(Event(kind, self._link.t_us * 1e-6, text, item=item))

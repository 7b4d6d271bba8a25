"""Following one plan, from taking over to handing back: a reference a tick, and what the autopilot is told on the way.

Why: who flies when is a matter of three stages, and each tick belongs to exactly one. The station decides when to begin
and when a user's word ends it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll.station import references
from halfroll.station.planning import Planned
from halfroll.station.record import Event, Record
from halfroll.station.references import References
from halfroll.wire import conversations
from halfroll.wire import messages as wire
from halfroll.wire.conversations import Conversation
from halfroll.wire.link import Link
from halfroll.wire.messages import Telemetry
from halfroll.wire.transport import Clock

START_DISTANCE, START_SPEED = 0.05, 0.1  # m, m/s: near enough to the plan's start for its clock to start
SETTLES_WITHIN_S = 10.0  # after the approach, or the autopilot flies the mission by itself
ERROR_LIMIT_M, ERROR_LIMIT_S = 1.0, 0.1  # farther from the plan for longer: this is not the flight that was planned
_PROGRESS_EVERY_S = 0.1

Array = NDArray[np.float64]
Converse = Callable[[Conversation[Any], Callable[[Any], None]], None]


class Stage(Enum):
    APPROACH = "going to the plan's start"
    FLYING = "flying the plan"
    HAND_BACK = "handing back"
    DONE = "the autopilot flies again"


class Following:
    """thrust_reference [N]: VEH_T_REF; converse: begins a conversation with the autopilot, after those that wait.

    current: the items of which the autopilot may be flying one as yet; which, may have been lost on the way.
    """

    def __init__(
        self,
        link: Link,
        planned: Planned,
        loop: References,
        thrust_reference: float,
        here: Telemetry,
        current: Sequence[int],
        converse: Converse,
        report: Callable[[Event], None],
        clock: Clock,
    ) -> None:
        self._link, self.planned, self._references, self._thrust_reference = link, planned, loop, thrust_reference
        self._converse, self._report, self._clock = converse, report, clock
        self.record = Record(planned)
        self.stage = Stage.APPROACH
        self.owns = False  # OFFBOARD was granted, and not given back
        self.ended: str | None = None  # why it ended early
        self._start = planned.plan.waypoints[0]
        self._path, self._path_start_us = references.approach(here, self._start.position, self._start.yaw), here.t_us
        self._due, self._told_s = 0, -_PROGRESS_EVERY_S
        self._items = list(current)  # what may be current, in order: those reported from here are added
        self._sent: tuple[int, NDArray[np.float32]] | None = None  # the last one's vehicle time and attitude
        self._near_us = here.t_us  # when it was last within ERROR_LIMIT_M of the plan
        self._tell("approach", "taking over from the autopilot")
        loop.begin(here)
        converse(conversations.set_mode(link, wire.OFFBOARD), self._hear_offboard)

    @property
    def done(self) -> bool:
        return self.stage is Stage.DONE

    @property
    def sent(self) -> tuple[int, Array, NDArray[np.float32]] | None:
        """Of the last reference: vehicle time [us], position (3,) and attitude (4,)."""
        if self._sent is None:
            return None
        t_us, q_WD = self._sent
        return t_us, self._path.at((t_us - self._path_start_us) * 1e-6)[0, :3], q_WD

    def tick(self, here: Telemetry) -> None:
        """Every 10 ms of vehicle time: exactly one reference."""
        if self.stage is Stage.APPROACH and self.owns and self._has_settled(here):
            self.stage, self._path, self._path_start_us = Stage.FLYING, self.planned.path, here.t_us
            self.record.plan_start_s = here.t_us * 1e-6
            self._tell("flying", f"flying the plan, {self.planned.plan.T:.2f} s", 0.0)
        elif self.stage is Stage.APPROACH and self._elapsed(here) > self._path.duration + SETTLES_WITHIN_S:
            self._give_up(f"it did not settle at the plan's start within {SETTLES_WITHIN_S:.0f} s")
        if self.stage is Stage.FLYING:
            self._follow(here, self._elapsed(here))
        setpoint = self._references.setpoint(self._path, self._path_start_us, here)
        thrust_fraction = setpoint.thrust / self._thrust_reference
        self._link.send(self._link.attitude_target(here.t_us, setpoint.q_WD, setpoint.w_WD_D, thrust_fraction))
        self._sent = here.t_us, setpoint.q_WD
        self.record.sent_s.append(here.t_us * 1e-6)
        self.record.sent_wall_s.append(self._clock())

    def hear_mode(self, mode: int, armed: bool) -> None:
        """A user's mode command ends the streaming at once."""
        own = (wire.OFFBOARD, wire.MISSION) if self.stage is Stage.HAND_BACK else (wire.OFFBOARD,)
        if self.owns and not (armed and mode in own):
            self.end(f"{wire.MODE_NAMES.get(mode, mode)} was commanded" if armed else "it was disarmed")

    def hear_current(self, seq: int) -> None:
        """An item that was not reported from here is a user's choice: the autopilot flies there by itself."""
        if not self.owns:  # as yet the autopilot moves on by itself
            self._items = [seq]
        elif seq in self._items:
            self._items = self._items[self._items.index(seq) :]
        elif self.stage in (Stage.APPROACH, Stage.FLYING):
            self._give_up(f"item {seq} was chosen")

    def end(self, why: str) -> None:
        if not self.done:
            self.stage, self.owns, self.ended = Stage.DONE, False, why
            self._tell("released", f"stopped streaming: {why}")

    def _hear_offboard(self, result: int) -> None:
        if result == wire.ACCEPTED:
            self.owns = True
        else:
            self.end(f"OFFBOARD was refused (result {result})")

    def _elapsed(self, here: Telemetry) -> float:
        """[s] since the path began"""
        return (here.t_us - self._path_start_us) * 1e-6

    def _has_settled(self, here: Telemetry) -> bool:
        arrived = self._elapsed(here) >= self._path.duration
        distance, speed = np.linalg.norm(here.p_WB - self._start.position), np.linalg.norm(here.v_WB)
        return bool(arrived and distance < START_DISTANCE and speed < START_SPEED)

    def _follow(self, here: Telemetry, t: float) -> None:
        """Reports what is passed; at the end hands back. t: of the plan."""
        plan, course = self.planned.plan, self.planned.course
        error = float(np.linalg.norm(self._path.at(t)[0, :3] - here.p_WB))
        self.record.error_m.append(error)
        if error < ERROR_LIMIT_M or self._near_us < self._path_start_us:
            self._near_us = here.t_us
        elif here.t_us - self._near_us > 1e6 * ERROR_LIMIT_S:
            self._give_up(f"{error:.1f} m from the plan", wire.WARNING)
            return
        while self._due < len(plan.times_s) - 1 and t >= plan.times_s[self._due]:
            passed = plan.waypoints[self._due].item
            if passed is not None:
                self._tell("item", f"item {passed} passed", t / plan.T, passed)
            self._due += 1
            self._report_progress(plan.waypoints[self._due].item)
        if t - self._told_s >= _PROGRESS_EVERY_S:
            self._told_s = t
            self._tell("progress", "flying the plan", min(t / plan.T, 1.0), plan.waypoints[self._due].item)
        if t >= plan.T:
            self.record.plan_end_s = here.t_us * 1e-6
            self._report_progress(course.hands_back_to)
            self._give_back()

    def _give_up(self, why: str, severity: int = wire.INFO) -> None:
        """Hands back before the plan's end; the autopilot goes on with the mission by itself."""
        self.ended = why
        self._link.send(self._link.status_text(f"Mission: plan left, {why}", severity))
        self._tell("left", f"leaves the plan: {why}")
        self._give_back()

    def _give_back(self) -> None:
        self.stage = Stage.HAND_BACK
        self._converse(conversations.set_mode(self._link, wire.MISSION), self._hear_handed_back)

    def _report_progress(self, seq: int | None) -> None:
        """Everything before item seq has been passed."""
        if seq is not None:
            self._converse(self._ask_to_move_on(seq), lambda _: None)

    def _ask_to_move_on(self, seq: int) -> Conversation[None]:
        if self.ended is None:  # else a user has chosen another item
            self._items.append(seq)
            number = conversations.SET_MISSION_CURRENT
            yield from conversations.command(self._link, number, float(seq), what="a progress report")

    def _hear_handed_back(self, result: int) -> None:
        if result != wire.ACCEPTED:
            self.end(f"handing back was refused (result {result})")
        elif not self.done:
            self.stage, self.owns = Stage.DONE, False
            self._tell("handed-back", f"{self.ended or 'the plan is flown'}, the autopilot goes on: {self.record}", 1.0)

    def _tell(self, kind: str, text: str, fraction: float | None = None, item: int | None = None) -> None:
        self._report(Event(kind, self._link.t_us * 1e-6, text, fraction, item))

"""The pilot: what a person at a ground control station does, as `halfroll fly` does it for them.

Why: a flight is flown through the same door that QGroundControl uses. It uploads, reads back, arms, starts and watches;
everything it waits for is a message or vehicle time, so the same seed flies the same flight.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from halfroll.errors import FlightError, HalfrollError, LinkError, MissionError
from halfroll.missions.mission import Mission
from halfroll.station.record import Event
from halfroll.wire import conversations
from halfroll.wire import messages as wire
from halfroll.wire.conversations import Conversation, Talk, Wait
from halfroll.wire.link import Link
from halfroll.wire.messages import Message
from halfroll.wire.transport import Clock, wall_s

HEARTBEAT_S = 1.0
ARM_RETRY_S, ARM_PATIENCE_S = 0.5, 20.0  # vehicle time: the estimator may still be settling
TAKEOFF_PATIENCE_S, FLIGHT_PATIENCE_S = 300.0, 7200.0  # vehicle time, from arming
SHUT_DOWN = 2.0
_RUN_PREARM_CHECKS = 401
_NAMES_AN_ITEM = re.compile(r"item (\d+)")


class Pilot:
    """Give it every message of its link (`hear`), and a moment now and then (`go_on`).

    may_start: the mission is planned, or cannot be; plan_error: why not.
    """

    def __init__(
        self,
        link: Link,
        mission: Mission,
        may_start: Callable[[], bool],
        plan_error: Callable[[], HalfrollError | None],
        report: Callable[[Event], None] = lambda _: None,
        clock: Clock = wall_s,
    ) -> None:
        self._link, self._mission, self._may_start, self._plan_error = link, mission, may_start, plan_error
        self._report, self._clock = report, clock
        self._heartbeat_s = -math.inf
        self.armed: bool | None = None
        self.mode = 0
        self.rotors: tuple[float, ...] | None = None  # (4,) signed shares of the largest thrust, if they are sent
        self._current: wire.MissionCurrent | None = None
        self.texts: list[str] = []
        self._talk: Talk[None] = Talk(link, self._flight(), clock)

    @property
    def awaits_answer(self) -> bool:
        return self._talk.awaits_answer

    @property
    def done(self) -> bool:
        return self._talk.done

    @property
    def item(self) -> int | None:
        """Being flown, as last heard."""
        return self._current.seq if self._current else None

    def hear(self, message: Message) -> None:
        if isinstance(message, wire.Heartbeat):
            self.armed, self.mode = message.armed, message.mode
        elif isinstance(message, wire.RotorThrusts):
            self.rotors = tuple(message.fractions.tolist())
        elif isinstance(message, wire.MissionCurrent):
            self._current = message
        elif isinstance(message, wire.StatusText):
            self.texts.append(message.text)
            self._tell("text", message.text)
        self._talk.hear(message)

    def go_on(self) -> None:
        """Heartbeat and lost answers. Raises what ended the flight."""
        if self._clock() - self._heartbeat_s >= HEARTBEAT_S and self._link.vehicle_system is not None:
            self._heartbeat_s = self._clock()
            self._link.send(self._link.heartbeat())
        self._talk.go_on()

    def _flight(self) -> Conversation[None]:
        yield Wait(lambda m: isinstance(m, wire.Heartbeat))
        yield from self._store()
        yield Wait(lambda _: self._may_start())
        yield from self._start()
        yield from self._watch()
        yield from self._command(conversations.SHUTDOWN, SHUT_DOWN, what="a shutdown")

    def _store(self) -> Conversation[None]:
        items = self._mission.items
        self._tell("upload", f"uploading {len(items)} items")
        yield from conversations.upload(self._link, items)
        _, stored = yield from conversations.download(self._link)
        seq = conversations.differing_item(items, stored)
        if seq is not None:
            raise LinkError(f"mission item {seq} is not stored as it was sent; is another program uploading?")
        self._tell("uploaded", f"{len(items)} items stored as sent")

    def _start(self) -> Conversation[None]:
        result = yield from conversations.set_mode(self._link, wire.MISSION)
        if result != wire.ACCEPTED:
            raise self._refusal("the mission was not started")
        error = self._plan_error()
        if error:  # the autopilot's own reason is the better one
            yield from self._command(_RUN_PREARM_CHECKS, what="the arming checks")
            raise self._item_refused("the mission cannot be started") or error
        tried_until_us = self._link.t_us + 1e6 * ARM_PATIENCE_S
        while (yield from self._command(conversations.ARM_DISARM, 1.0, what="arming")) != wire.ACCEPTED:
            refused = self._item_refused("the mission cannot be started")
            if refused or self._link.t_us > tried_until_us:
                raise refused or self._refusal("the vehicle was not armed")
            again_us = self._link.t_us + 1e6 * ARM_RETRY_S
            yield Wait(self._time_reaches(again_us))
        self._tell("armed", "armed, taking off")

    def _watch(self) -> Conversation[None]:
        """Until it has landed and disarmed itself."""
        yield Wait(lambda _: bool(self.armed))
        first, began_us = self.item, self._link.t_us
        yield Wait(lambda _: not self.armed or self.item != first or self._is_overdue(began_us, TAKEOFF_PATIENCE_S))
        if self.armed and self.item == first:
            raise self._overdue("did not take off", TAKEOFF_PATIENCE_S)
        yield Wait(lambda _: not self.armed or self._is_overdue(began_us, FLIGHT_PATIENCE_S))
        if self.armed:
            raise self._overdue("did not land", FLIGHT_PATIENCE_S)
        yield Wait(lambda m: isinstance(m, wire.MissionCurrent))
        if self._current is None or self._current.state != wire.COMPLETE:
            at = self._current.seq if self._current else 0
            said = f"; it said: {self.texts[-1]}" if self.texts else ""
            raise FlightError(f"the vehicle landed before the mission was complete, at item {at}{said}", at)
        self._tell("landed", "landed and disarmed, mission complete")

    def _is_overdue(self, began_us: float, patience_s: float) -> bool:
        return self._link.t_us > began_us + 1e6 * patience_s

    def _overdue(self, what: str, patience_s: float) -> FlightError:
        said = f"; it said: {self.texts[-1]}" if self.texts else ""
        return FlightError(
            f"the vehicle {what} within {patience_s:.0f} s of arming, at item {self.item}{said}", self.item
        )

    def _time_reaches(self, t_us: float) -> Callable[[Message | None], bool]:
        return lambda _: self._link.t_us >= t_us

    def _command(self, number: int, *params: float, what: str) -> Conversation[int]:
        return conversations.command(self._link, number, *params, what=what)

    def _item_refused(self, what: str) -> MissionError | None:
        """What the autopilot said of the item it named last, as an error about it."""
        about = [(int(named[1]), text) for text in self.texts if (named := _NAMES_AN_ITEM.search(text))]
        refusals = [(item, text) for item, text in about if "not planned" not in text and "not flown" not in text]
        if not refusals:
            return None
        item = refusals[-1][0]
        said = "; ".join(dict.fromkeys(text for named, text in refusals if named == item))
        return MissionError(f"{what}; the autopilot says: {said}", item)

    def _refusal(self, what: str) -> HalfrollError:
        said = f"; the autopilot says: {self.texts[-1]}" if self.texts else ""
        return self._item_refused(what) or FlightError(what + said)

    def _tell(self, kind: str, text: str, **more: Any) -> None:
        self._report(Event(kind, self._link.t_us * 1e-6, text, **more))

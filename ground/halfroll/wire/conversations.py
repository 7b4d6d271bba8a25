"""Conversations: what takes more than one message, written as one reads it, top to bottom.

Why: mission transfer, commands and parameters all are "send, wait for the answer, send again if it was lost". Each is a
generator that yields what it waits for; a Talk carries it through a link without ever blocking, so one loop can stream
references while any number of them go on. Only the repetition of lost messages looks at the wall clock.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from halfroll.errors import LinkError, MissionError
from halfroll.missions.mission import MissionItem
from halfroll.missions.mission_items import command_name
from halfroll.wire.link import Link
from halfroll.wire.messages import (
    ACCEPTED,
    AUTOPILOT,
    CommandAck,
    ItemRequest,
    ItemSent,
    Message,
    MissionAck,
    MissionCount,
    ParamError,
    ParamValue,
)
from halfroll.wire.transport import Clock, wall_s

RESEND_AFTER_S = 0.5
TRIES = 12
TRANSFERS = 3  # begun before giving up

SET_MODE, ARM_DISARM, SET_MISSION_CURRENT, REQUEST_MESSAGE, SHUTDOWN = 176, 400, 224, 512, 246

_MISSION_RESULTS = {
    1: "an error of its storage",
    2: "its coordinate frame",
    3: "its command, which is not supported",
    4: "the number of items",
    5: "an invalid value",
    6: "parameter 1",
    7: "parameter 2",
    8: "parameter 3",
    9: "parameter 4",
    10: "its latitude (x)",
    11: "its longitude (y)",
    12: "its altitude (z)",
    13: "its sequence number",
    14: "the vehicle's state (it is flying a mission)",
    15: "a timeout",
}

T = TypeVar("T")


class NoAnswer(LinkError):
    """A question was asked often enough; thrown into the conversation that asked it."""


@dataclass(frozen=True)
class Ask:
    """Send `frame`, again while nothing that `answered_by` accepts has come. `what` completes "did not answer ..."."""

    frame: Any
    answered_by: Callable[[Message], bool]
    what: str
    tries: int = TRIES


@dataclass(frozen=True)
class Wait:
    """Wait without limit until `until` accepts a message, or accepts None, which it is asked now and then."""

    until: Callable[[Message | None], bool]


Conversation = Generator[Ask | Wait, Any, T]


class Talk(Generic[T]):
    """Carries one conversation: give it every message that comes, and a moment now and then."""

    def __init__(self, link: Link, conversation: Conversation[T], clock: Clock = wall_s) -> None:
        self._link, self._conversation, self._clock = link, conversation, clock
        self._step: Ask | Wait | None = None
        self._tries, self._sent_s = 0, 0.0
        self.result: T | None = None
        self.done = False
        self._go_on(None)

    @property
    def awaits_answer(self) -> bool:
        """Something was asked and not yet answered: in lockstep, time must not go on."""
        return isinstance(self._step, Ask)

    def hear(self, message: Message) -> None:
        step = self._step
        if isinstance(step, Ask) and step.answered_by(message):
            if self._tries == 1:  # else nobody knows which of them was answered
                self._link.round_trips_s.append(self._clock() - self._sent_s)
            self._go_on(message)
        elif isinstance(step, Wait) and step.until(message):
            self._go_on(message)

    def go_on(self) -> None:
        """For what does not come as a message: repeats a question that seems lost, and raises NoAnswer in the end."""
        step = self._step
        if isinstance(step, Wait) and step.until(None):
            self._go_on(None)
        if not isinstance(step, Ask) or self._clock() - self._sent_s <= RESEND_AFTER_S:
            return
        if self._tries < step.tries:
            self._ask(step)
            return
        self._go_on(
            NoAnswer(
                f"the autopilot did not answer {step.what} ({self._tries} tries in "
                f"{self._tries * RESEND_AFTER_S:.0f} s); is it still running, and is nothing else talking on this port?"
            )
        )

    def _go_on(self, heard: Message | NoAnswer | None) -> None:
        talk = self._conversation
        try:
            self._step = talk.throw(heard) if isinstance(heard, NoAnswer) else talk.send(heard)
        except StopIteration as stop:
            self._step, self.result, self.done = None, stop.value, True
            return
        if isinstance(self._step, Ask):
            self._tries = 0
            self._ask(self._step)

    def _ask(self, ask: Ask) -> None:
        self._link.send(ask.frame)
        self._link.questions += 1
        self._tries, self._sent_s = self._tries + 1, self._clock()


def command(link: Link, number: int, *params: float, what: str, component: int = AUTOPILOT) -> Conversation[int]:
    """The MAV_RESULT of a command."""
    frame = link.command(number, *params, component=component)
    ack = yield Ask(frame, lambda m: isinstance(m, CommandAck) and m.command == number, what)
    return int(ack.result)


def set_mode(link: Link, mode: int) -> Conversation[int]:
    main, sub = mode >> 16 & 0xFF, mode >> 24
    return command(link, SET_MODE, 1.0, float(main), float(sub), what="a mode change")


def read_param(link: Link, name: str) -> Conversation[float]:
    """Raises LinkError if the autopilot has no such parameter."""
    return _param(Ask(link.param_read(name), _about(name), f"for parameter {name}"), name)


def write_param(link: Link, name: str, value: float) -> Conversation[float]:
    """The value that was stored. Raises LinkError when it is refused."""
    return _param(Ask(link.param_set(name, value), _about(name), f"to setting parameter {name}"), name)


def _about(name: str) -> Callable[[Message], bool]:
    return lambda m: isinstance(m, ParamValue | ParamError) and m.name == name


def _param(ask: Ask, name: str) -> Conversation[float]:
    answer = yield ask
    if isinstance(answer, ParamError):
        raise LinkError(f"the autopilot refused parameter {name} (error {answer.code}); is it a halfroll autopilot?")
    return float(answer.value)


def read_params(link: Link, names: Iterable[str]) -> Conversation[dict[str, float]]:
    values = {}
    for name in names:
        values[name] = yield from read_param(link, name)
    return values


def upload(link: Link, items: Sequence[MissionItem]) -> Conversation[int]:
    """Store `items` in the autopilot; their mission_id. Raises MissionError naming the item it refused, and why."""
    for _ in range(TRANSFERS - 1):
        try:
            return (yield from _upload_once(link, items))
        except NoAnswer:  # the last answer is sent once only; when it is lost, all begins again
            continue
    return (yield from _upload_once(link, items))


def _upload_once(link: Link, items: Sequence[MissionItem]) -> Conversation[int]:
    def asks_or_ends(message: Message) -> bool:
        return (isinstance(message, ItemRequest) and message.seq < len(items)) or isinstance(message, MissionAck)

    asked = 0
    answer = yield Ask(link.mission_count(len(items)), asks_or_ends, "a mission upload")
    while isinstance(answer, ItemRequest):
        asked = answer.seq
        answer = yield Ask(link.mission_item(asked, items[asked]), asks_or_ends, f"mission item {asked}", TRIES // 2)
    if answer.result != ACCEPTED:
        reason = _MISSION_RESULTS.get(answer.result, f"result {answer.result}")
        which = f"mission item {asked} ({command_name(items[asked].command)})"
        raise MissionError(f"{which} was refused by the autopilot because of {reason}; change it", asked)
    return int(answer.mission_id)


def download(link: Link) -> Conversation[tuple[int, tuple[MissionItem, ...]]]:
    """The mission_id and the items that the autopilot has stored; read twice if it changed meanwhile."""
    for _ in range(TRANSFERS):
        count = yield _count_request(link)
        items = []
        for seq in range(count.count):
            sent = yield Ask(link.mission_item_request(seq), _item_or_end(seq), f"a request for mission item {seq}")
            if isinstance(sent, MissionAck):
                break
            items.append(sent.item)
        again = yield _count_request(link)
        if len(items) == count.count and again == count:
            link.send(link.mission_ack())
            return count.mission_id, tuple(items)
    raise LinkError("the stored mission changed again and again while it was read; is another program uploading?")


def _count_request(link: Link) -> Ask:
    return Ask(link.mission_list_request(), lambda m: isinstance(m, MissionCount), "a mission download")


def _item_or_end(seq: int) -> Callable[[Message], bool]:
    return lambda m: (isinstance(m, ItemSent) and m.seq == seq) or (isinstance(m, MissionAck) and m.result != ACCEPTED)


def differing_item(sent: Sequence[MissionItem], stored: Sequence[MissionItem]) -> int | None:
    """The first item that is not stored as it was sent, in every bit; None if all are."""
    for seq, (a, b) in enumerate(zip(sent, stored, strict=False)):
        if a != b:
            return seq
    return None if len(sent) == len(stored) else min(len(sent), len(stored))

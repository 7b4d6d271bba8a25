"""The lockstep barrier: the vehicle's time stands from its request until its stamp goes back.

Why: flights are equal in every bit only if what is sent before time goes on does not depend on how fast anybody's
machine is. So the stamp is withheld while a question of ours is open, and after any question one more is asked, about
the time: its answer comes behind everything that the earlier ones set off.
"""

from __future__ import annotations

from collections.abc import Sequence

from halfroll.wire.conversations import Ask, Conversation, Talk
from halfroll.wire.link import Link
from halfroll.wire.messages import Message, TimeReply, TimeRequest
from halfroll.wire.transport import Clock, wall_s


class Barrier:
    """`active` once a request was seen. Feed it every message of the first link, which carries the requests; time waits
    for what is asked on any of them."""

    def __init__(self, links: Sequence[Link], clock: Clock = wall_s) -> None:
        self._links, self._link, self._clock = links, links[0], clock
        self._standing: TimeRequest | None = None
        self._released: TimeRequest | None = None
        self._fence: Talk[None] | None = None
        self._fenced_questions = 0  # asked up to the last fence
        self.active = False

    def hear(self, message: Message) -> None:
        if self._fence:
            self._fence.hear(message)
        if isinstance(message, TimeRequest):
            self.active = True
            if message == self._released:
                self._link.send(self._link.time_reply(message))  # our reply was lost
            else:
                self._standing = message

    def release(self, waiting: bool) -> None:
        """Call it whenever all that has come was heard. waiting: somebody awaits an answer, or is planning."""
        if waiting or self._standing is None:
            return
        if self._fence:
            self._fence.go_on()
            if not self._fence.done:
                return
            self._fence = None
        if sum(link.questions for link in self._links) > self._fenced_questions:
            self._fence = Talk(self._link, self._ask_time(self._standing.stamp + 1), self._clock)
            self._fenced_questions = sum(link.questions for link in self._links)
            return
        self._released, self._standing = self._standing, None
        self._link.send(self._link.time_reply(self._released))

    def _ask_time(self, stamp: int) -> Conversation[None]:
        frame = self._link.time_request(stamp)
        yield Ask(frame, lambda m: isinstance(m, TimeReply) and m.stamp == stamp, "a time request")

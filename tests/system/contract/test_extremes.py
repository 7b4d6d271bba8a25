"""NaN, infinity, denormal and huge numbers in every field of every message: in hover, OFFBOARD, a mission and a flip.

What is not refused aloud is in the tables here, and nowhere else.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable

import pytest

from system.contract.aircraft import ACCEPTED, OFFBOARD, A, Aircraft, B
from system.contract.extremes import Case, Outcome, after, cases

# Fields that mean nothing where they are: the flight and the answers are those of the message without the extreme.
PASSED_OVER = {
    r"\d+ (confirmation|current|autocontinue|frame)": "counted by the sender, or of items; a frame without a place",
    r"(20|21|246|410|510|511|512|520) (param\d|x|y|z)": "commands that need no place and few parameters",
    r"(179|192|300) param\d": "home's heading; speed, radius and yaw of a reposition; last item",
    r"115 param2|178 param3": "speed of turning; throttle",
    r"MISSION_ITEM\w* \w+": "as item_rows of docs/mavlink.md say; nothing that is stored acts before it is flown",
    r"MISSION_(ACK|COUNT|CLEAR_ALL|REQUEST\w*|SET_CURRENT|WRITE\w*) (type|opaque_id|mission_type)": "other lists",
    r"HEARTBEAT \w+": "who speaks; only the type of a ground control station counts",
    r"(PING|TIMESYNC|FILE_TRANSFER_PROTOCOL|STATUSTEXT|SETUP_SIGNING) \w+": "answered or passed on, not looked at",
    r"\w+ (time_boot_ms|time_usec|usec)": "no vehicle time: dated by arrival",
    r"\w+ (covariance|pose_covariance|velocity_covariance)": "unknown: parameters stand in",
    r"ODOMETRY (child_frame_id|estimator_type|quality|vx|vy|vz|rollspeed|pitchspeed|yawspeed)": "poses alone are used",
    r"\w+ reset_counter": "counts round",
    r"PARAM_\w+ (param_type|param_index)": "the value is a float; a name goes before an index",
    r"SET_MODE base_mode": "only whether custom_mode is meant",
}
NOT_GIVEN = r"\d+ (param\d|z)"  # NaN there
TAKEN = {  # a number like any other; and what it does then
    ("178 param2", "huge"): "flown at most at MPC_XY_VEL_MAX",
    ("31010 param3", "minus huge"): "no least height besides FLIP_MIN_ALT",
    ("31010 param4", "huge"): "as long as it takes",
    ("192 param7", "NaN"): "no height given: this one is kept",
    ("192 z", "NaN"): "no height given: this one is kept",
}
UNANSWERED = {  # the flight is as without the message, and there is nobody to tell
    r"MISSION_ITEM\w* (seq|mission_type)": "not the item that was asked for: that is asked for again",
    r"TIMESYNC tc1": "the answer to a question that nobody asked",
}


def listed(table: dict[str, str], what: str) -> bool:
    return any(re.fullmatch(pattern, what) for pattern in table)


class Judge:
    """Of cases in one situation."""

    def __init__(self, aircraft: Aircraft, link: int) -> None:
        self.aircraft, self.link = aircraft, link
        self.silent = self.hears("", None)
        self.plain: dict[tuple[str, int | None], Outcome] = {}

    def hears(self, message: str, fields: object) -> Outcome:
        return after(self.aircraft, message, fields, self.link)  # type: ignore[arg-type]

    def verdict(self, case: Case) -> str:
        key = (case.message, case.command)
        if key not in self.plain:
            self.plain[key] = self.hears(case.message, case.plain)
        plain, got = self.plain[key], self.hears(case.message, case.fields)
        assert got.aircraft.autopilot.broken_invariant is None, case.name
        if got.refused and got.flies_as(self.silent):
            return "refused"
        if case.value == "denormal" and got.same_as(self.hears(case.message, case.zero)):
            return "as zero"
        given = not (case.value == "NaN" and re.fullmatch(NOT_GIVEN, case.what))
        if got.same_as(plain) and (not given or case.value == "denormal" or listed(PASSED_OVER, case.what)):
            return "passed over"
        if got.flies_as(self.silent) and listed(UNANSWERED, case.what):
            return "passed over"
        if (case.what, case.value) in TAKEN:
            return "taken"
        return f"flies {'on' if got.flies_as(self.silent) else 'otherwise'}, says {got.answers}: {case.name}"


@pytest.fixture
def flying(request: pytest.FixtureRequest, hovering: Aircraft) -> tuple[str, Aircraft, int]:
    situation: str = request.param
    if situation == "offboard":
        client = hovering.client(A)
        assert client.set_mode(OFFBOARD) == ACCEPTED
        hovering.stream(client, 0.3)
    elif situation == "mission":
        return situation, request.getfixturevalue("on_mission"), B
    elif situation == "flip":
        assert hovering.client().command(31010, 1, 1, 6.0, 9.0) == ACCEPTED
        hovering.fly(0.45)
        assert hovering.world.q_WB[1] > 0.5
    return situation, hovering, A if situation == "offboard" else B


def judged(aircraft: Aircraft, link: int, chosen: Callable[[int], bool]) -> Counter[str]:
    judge, verdicts = Judge(aircraft, link), Counter[str]()
    for number, case in enumerate(cases(aircraft)):
        if chosen(number):
            verdicts[judge.verdict(case)] += 1
    wrong = [verdict for verdict in verdicts if verdict not in ("refused", "as zero", "passed over", "taken")]
    assert not wrong, "\n".join(wrong[:20])
    return verdicts


SITUATIONS = pytest.mark.parametrize("flying", ["hover", "offboard", "mission", "flip"], indirect=True)


@SITUATIONS
def test_an_extreme_value_is_refused_aloud_or_means_nothing(flying: tuple[str, Aircraft, int]) -> None:
    _, aircraft, link = flying
    verdicts = judged(aircraft, link, lambda number: number % 17 == 0)
    assert verdicts["refused"] > 50


@pytest.mark.long
@pytest.mark.reliability(
    "Extreme values", "situations (hover, OFFBOARD, mission, flip) in which no extreme value had an effect of its own"
)
@SITUATIONS
def test_so_is_every_one_of_thousands(
    flying: tuple[str, Aircraft, int], record_property: Callable[[str, object], None]
) -> None:
    _, aircraft, link = flying
    verdicts = judged(aircraft, link, lambda _: True)
    record_property("outcomes", dict(verdicts))
    assert verdicts.total() > 3000


def test_the_value_at_which_each_takes_effect_is_not_called_extreme(hovering: Aircraft) -> None:
    """What this file relies on: a plain message does act, and is told from silence."""
    judge = Judge(hovering, B)
    lands = next(case for case in cases(hovering) if case.command == 21)
    assert not judge.hears(lands.message, lands.plain).flies_as(judge.silent)

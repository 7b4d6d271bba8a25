"""The ground station is killed at any moment of a mission, in the middle of a turn-over, too, and started again.

Why: it knows nothing of what was before, and has only what the autopilot has stored. Here its end is what the vehicle
sees of it, silence from one millisecond to the next, so that each moment can be met again; processes are killed in
test_process_faults.py.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import pytest

from halfroll.errors import HalfrollError
from halfroll.station.following import Stage
from halfroll.station.station import State
from system.links.faulty_link import Faults
from system.links.linked_flight import Errand, LinkedFlight
from system.processes import EXAMPLES, MISSIONS

SECTION = "Ground station killed"
MOMENTS = 50
GOOD = Faults(delay_ms=2)
PAUSE_CONTINUE = 193
SETTLES_S = 6.0
DOWN_S = (0.5, 4.0)  # until it is started again
PLAN_SEEN_S = 2.0  # the user continues when the plan has stood so long
LONGEST_S = 200.0
FILES = (EXAMPLES / "first_flight.plan", MISSIONS / "flips.toml", EXAMPLES / "aerobatics.toml", MISSIONS / "box.plan")


@dataclass(frozen=True)
class Killed:
    """What became of one flight."""

    where: str
    turning: bool  # a manoeuvre that turns over was under way
    safe: bool  # no crash, and where it could not go on by itself it hovered upright
    ended: str
    texts: tuple[str, ...]
    broken: tuple[str, ...]


@cache
def errand(n: int) -> Errand:
    return Errand.of(FILES[n % len(FILES)])


@cache
def undisturbed(n: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """When the flight n of these files is armed and when it has landed; when its plan begins and ends."""
    flight = LinkedFlight(errand(n), GOOD, 0)
    while not flight.autopilot.armed:
        flight.step()
    armed_s = flight.clock()
    landed_s, record = flight.fly().t_s, flight.record
    assert record is not None
    assert record.plan_start_s is not None
    assert record.plan_end_s is not None
    return (armed_s, landed_s), (record.plan_start_s, record.plan_end_s)


@cache
def killed(n: int) -> Killed:
    chance = random.Random(n)
    whole, by_plan = undisturbed(n % len(FILES))
    armed_s = whole[0]
    flight = LinkedFlight(errand(n), GOOD, n)
    moment_s = chance.uniform(*(by_plan if n // len(FILES) % 2 else whole))
    down_s = chance.uniform(*DOWN_S)
    fly_until(flight, lambda: flight.clock() >= moment_s)
    turning, where = is_turning(flight), f"{flight.autopilot.mode} after {flight.clock() - armed_s:.2f} s"
    flight.end_station()
    fly_until(flight, lambda: flight.clock() >= moment_s + down_s)
    if flight.autopilot.mode in ("Offboard", "Hold"):
        fly_until(flight, lambda: flight.clock() >= moment_s + max(SETTLES_S, down_s))
    safe = not flight.world.crashed and (flight.autopilot.mode != "Hold" or not flight.autopilot.armed or flight.hovers)
    flight.start_station()
    try:
        continue_as_a_user_does(flight)
        ended = "complete" if flight.pilot.done else f"{flight.autopilot.mode} for {LONGEST_S:.0f} s"
    except HalfrollError as error:
        ended = str(error)
    safe = safe and not flight.world.crashed
    return Killed(where, turning, safe, ended, tuple(flight.account.texts), tuple(flight.account.broken))


def fly_until(flight: LinkedFlight, come: Callable[[], bool]) -> None:
    while not come() and not flight.pilot.done:
        flight.step()


def is_turning(flight: LinkedFlight) -> bool:
    """By the plan: upside down, or on the way there or back."""
    following = flight.station.following
    if following is None or following.stage is not Stage.FLYING:
        return False
    plan, t = following.planned.plan, flight.clock() - (following.record.plan_start_s or 0.0)
    inverted = sum(event <= t for event in plan.sigma_events) % 2 == 1
    return inverted or any(start <= t <= end for start, end in plan.turns or ()) or flight.up < 0.0


def continue_as_a_user_does(flight: LinkedFlight) -> None:
    """Once the plan of the rest stands, or it is said that there will be none."""
    seen_s = flight.clock()
    while not flight.pilot.done and flight.clock() < LONGEST_S:
        flight.step()
        waits = flight.autopilot.mode == "Hold" and flight.autopilot.armed and flight.station.outcome is not None
        if not waits or flight.station.state is State.PLANNING:
            seen_s = flight.clock()
        elif flight.clock() - seen_s > PLAN_SEEN_S:
            flight.say(PAUSE_CONTINUE, 1.0)
            seen_s = flight.clock()


def moments(quick: bool) -> Any:
    return pytest.mark.parametrize("n", (3,) if quick else range(MOMENTS))


@pytest.mark.long
@pytest.mark.reliability(SECTION, "moments after which the vehicle was safe")
@moments(quick=False)
def test_the_vehicle_is_safe(n: int, record_property: Callable[[str, object], None]) -> None:
    found = killed(n)
    record_property("outcome", "in a turn-over" if found.turning else "else")
    assert found.safe, found
    assert not found.broken, found.broken[:3]


@pytest.mark.long
@pytest.mark.reliability(SECTION, "moments after which the new one finished the mission")
@moments(quick=False)
def test_the_next_ground_station_finishes_the_mission(n: int) -> None:
    assert killed(n).ended == "complete", killed(n)


@moments(quick=True)
def test_a_mission_outlives_its_ground_station(n: int) -> None:
    found = killed(n)
    assert found.safe, found
    assert found.ended == "complete", found

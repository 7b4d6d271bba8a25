"""Missions over links that lose, delay, reorder, repeat, spoil and throttle: each is flown to its end, or ends in the
failsafe that the page of the protocol promises.

Why: what a flight does on a bad radio must be known of every fault on every kind of mission, not of the one that
somebody happened to try. Every millisecond of every flight is held against the invariants.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

from halfroll.missions.mission import PlanOptions
from system.links.faulty_link import Faults
from system.links.linked_flight import Account, Errand, LinkedFlight
from system.processes import EXAMPLES, MISSIONS

FAULTS = {
    "loss of 5 %": Faults(loss=0.05, delay_ms=2),
    "loss of 20 %": Faults(loss=0.2, delay_ms=2),
    "jitter of 30 ms": Faults(delay_ms=2, jitter_ms=30),
    "bursts of 150 ms": Faults(burst_ms=150, burst_every_s=1.0, delay_ms=2),
    "bursts of 400 ms": Faults(burst_ms=400, burst_every_s=3.0, delay_ms=2),
    "a fifth twice": Faults(duplicate=0.2, delay_ms=2),
    "a tenth spoilt": Faults(corrupt=0.1, delay_ms=2),
    "a fifth late": Faults(reorder=0.2, delay_ms=2),
    "delay of 20 ms": Faults(delay_ms=20),
    "delay of 60 ms": Faults(delay_ms=60),
    "16 kB/s": Faults(rate_B_s=16_000, delay_ms=2),
    "everything": Faults(0.1, 200, 3.0, 5, 15, 0.05, 0.05, 0.03, 30_000),
}


def box_of_fixed_pitch() -> Errand:
    return Errand.of(MISSIONS / "box.plan", "mit-fp", PlanOptions.of("paper"))


ERRANDS: dict[str, Callable[[], Errand]] = {
    "first flight": lambda: Errand.of(EXAMPLES / "first_flight.plan"),
    "box": lambda: Errand.of(MISSIONS / "box.plan"),
    "box, fixed pitch": box_of_fixed_pitch,
    "window": lambda: Errand.of(EXAMPLES / "window.toml"),
    "inspection": lambda: Errand.of(EXAMPLES / "inspection.toml"),
    "flips": lambda: Errand.of(MISSIONS / "flips.toml"),
    "aerobatics": lambda: Errand.of(EXAMPLES / "aerobatics.toml"),
}


SHORT = ("box", "box, fixed pitch", "window", "flips")  # of which there are more
SECTION = "Link faults"
QUICK = [("box", fault, 0) for fault in ("loss of 20 %", "jitter of 30 ms", "bursts of 400 ms", "everything")]
ALL = [(errand, fault, seed) for errand in ERRANDS for fault in FAULTS for seed in range(1, 3 + (errand in SHORT))]


@cache
def flown(errand: str, fault: str, seed: int) -> Account:
    return LinkedFlight(_errand(errand), FAULTS[fault], seed).fly()


@cache
def _errand(name: str) -> Errand:
    return ERRANDS[name]()


def require_an_end(account: Account) -> None:
    """Landed and disarmed with all items flown; or where the failsafe leaves it, which the vehicle has said."""
    if account.ended.startswith("completed"):
        assert not account.armed
    else:
        assert account.ended == "failsafe", f"{account}\n{account.texts}"
        assert account.hovers or not account.armed, account.texts


@pytest.mark.parametrize(("errand", "fault", "seed"), QUICK)
def test_over_a_bad_link_a_box_is_flown_to_its_end_or_ends_in_the_failsafe(errand: str, fault: str, seed: int) -> None:
    account = flown(errand, fault, seed)
    require_an_end(account)
    assert not account.crashed
    assert not account.broken


def claim(words: str) -> Callable[[Any], Any]:
    """Of each mission under each fault."""

    def decorate(test: Any) -> Any:
        each = pytest.mark.parametrize(("errand", "fault", "seed"), ALL)
        return pytest.mark.long(pytest.mark.reliability(SECTION, words)(each(test)))

    return decorate


@claim("missions completed, or ended in the documented failsafe")
def test_a_mission_is_flown_to_its_end_or_ends_in_the_failsafe(
    errand: str, fault: str, seed: int, record_property: Callable[[str, object], None]
) -> None:
    account = flown(errand, fault, seed)
    record_property("outcome", account.ended)
    require_an_end(account)


@claim("missions without a crash")
def test_nothing_crashes(errand: str, fault: str, seed: int) -> None:
    assert not flown(errand, fault, seed).crashed


@claim("missions with every rotor command within its limits, every state finite, every quaternion a unit one")
def test_the_invariants_hold_in_every_millisecond(errand: str, fault: str, seed: int) -> None:
    assert not flown(errand, fault, seed).broken


@pytest.mark.long
@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_befell_the_flights_that_were_to_suffer_it(fault: str) -> None:
    wanted = {name for name in ("loss", "duplicate", "corrupt", "reorder") if getattr(FAULTS[fault], name) > 0.0}
    wanted |= {"burst"} if FAULTS[fault].burst_ms > 0.0 else set()
    for errand in ERRANDS:
        assert wanted <= set(flown(errand, fault, 1).suffered)

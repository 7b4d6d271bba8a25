"""The faulty link itself: one seed gives one datagram one fate, and each fault does what it is called."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from system.links.faulty_link import QUEUE_S, Faults, Way

N = 2000
BAD = Faults(0.1, 200, 3.0, 5, 15, 0.05, 0.05, 0.03, 30_000)


def sent(faults: Faults, seed: int = 1, count: int = N) -> tuple[Way, list[tuple[int, bytes]]]:
    """A datagram each 10 ms; what arrives, with its millisecond."""
    way, arrived = Way(faults, seed), []
    for ms in range(10 * count + 1000):
        if ms % 10 == 0 and ms < 10 * count:
            way.post(1e-3 * ms, (ms // 10).to_bytes(4, "big") * 10)
        arrived += [(ms, datagram) for datagram in way.arrived(1e-3 * ms + 1e-9)]
    return way, arrived


def numbers(arrived: list[tuple[int, bytes]]) -> list[int]:
    return [int.from_bytes(datagram[:4], "big") for _, datagram in arrived]


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_the_same_seed_is_the_same_fate(seed: int) -> None:
    assert sent(BAD, seed, 50)[1] == sent(BAD, seed, 50)[1]


def test_the_fate_of_a_datagram_does_not_depend_on_those_before_it() -> None:
    whole, shorter = sent(Faults(loss=0.5))[1], Way(Faults(loss=0.5), 1)
    for n in range(N):
        shorter.post(0.0, n.to_bytes(4, "big"))  # all at once, and of another size
    assert sorted(int.from_bytes(datagram, "big") for datagram in shorter.arrived(0.0)) == numbers(whole)


def test_another_seed_is_another_fate() -> None:
    assert sent(BAD, 1)[1] != sent(BAD, 2)[1]


def test_a_good_link_brings_everything_at_once_and_in_order() -> None:
    arrived = sent(Faults())[1]
    assert numbers(arrived) == list(range(N))
    assert all(ms == 10 * n for n, (ms, _) in enumerate(arrived))


@pytest.mark.parametrize("kind", ["loss", "duplicate", "corrupt", "reorder"])
def test_a_share_is_that_share(kind: str) -> None:
    way, _ = sent(dataclasses.replace(Faults(), **{kind: 0.2}))
    assert 0.17 * N < way.suffered[kind] < 0.23 * N


def test_a_burst_takes_everything_for_so_long_once_in_its_time() -> None:
    there = set(numbers(sent(Faults(burst_ms=400, burst_every_s=2.0))[1]))
    gaps = [len(gap) * 10 for gap in "".join("x" if n in there else "." for n in range(N)).replace("x", " ").split()]
    assert len(gaps) == N * 0.01 / 2.0
    assert all(190 <= gap <= 410 for gap in gaps)


def test_jitter_delays_each_on_its_own() -> None:
    arrived = sent(Faults(delay_ms=5, jitter_ms=30))[1]
    late = [ms - 10 * n for (ms, _), n in zip(arrived, numbers(arrived), strict=True)]
    assert 5 <= min(late) <= 6
    assert 33 <= max(late) <= 36
    assert numbers(arrived) != sorted(numbers(arrived))


def test_what_is_spoilt_differs_and_the_rest_does_not() -> None:
    way, arrived = sent(Faults(corrupt=0.2))
    good = {n.to_bytes(4, "big") * 10 for n in range(N)}
    assert sum(datagram not in good for _, datagram in arrived) == way.suffered["corrupt"]


def test_a_throttled_line_carries_no_more_than_its_rate_and_drops_what_waits_too_long() -> None:
    way, arrived = sent(Faults(rate_B_s=2000.0))  # half of what is sent
    assert sum(len(datagram) for _, datagram in arrived) <= 2000.0 * (N * 0.01 + QUEUE_S) + 40
    assert way.suffered["rate"] > 0.45 * N

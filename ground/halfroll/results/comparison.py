"""Two flights side by side.

Why: whether a change made a flight better is a matter of numbers, each beside the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from halfroll.results.evaluation import at_times
from halfroll.results.logged_flight import LoggedFlight


@dataclass(frozen=True)
class Figure:
    """One figure of both; None where a flight has none."""

    name: str
    unit: str
    first: float | None
    second: float | None

    @property
    def difference(self) -> float | None:
        return None if self.first is None or self.second is None else self.second - self.first


@dataclass(frozen=True)
class Comparison:
    """apart: distance of the true positions at equal times since the plan's start, or since arming [m].

    same_commands: every rotor command equal in every bit; same_until_s: vehicle time of the first that differs.
    """

    flights: tuple[LoggedFlight, LoggedFlight]
    figures: tuple[Figure, ...]
    apart_rms_m: float
    apart_max_m: float
    same_commands: bool
    same_until_s: float | None
    parameters: tuple[tuple[str, float | None, float | None], ...]  # that differ

    def as_json(self) -> dict[str, Any]:
        return {
            "logs": [str(flight.log.path) for flight in self.flights],
            "verdicts": [flight.verdict.line for flight in self.flights],
            "figures": [{**asdict(figure), "difference": figure.difference} for figure in self.figures],
            "apart_rms_m": self.apart_rms_m,
            "apart_max_m": self.apart_max_m,
            "same_commands": self.same_commands,
            "same_until_s": self.same_until_s,
            "parameters": [list(row) for row in self.parameters],
        }


def compare(first: LoggedFlight, second: LoggedFlight) -> Comparison:
    apart = _apart(first, second)
    until_s = first_difference_s(first, second)
    return Comparison(
        (first, second),
        tuple(_figures(first, second)),
        float(np.sqrt(np.mean(apart**2))),
        float(apart.max()),
        until_s is None,
        until_s,
        tuple(_parameters(first, second)),
    )


def first_difference_s(first: LoggedFlight, second: LoggedFlight) -> float | None:
    """Vehicle time of the first rotor command that is not equal in every bit, or that only one of them has."""
    a, b = (flight.log["rotor_commands"] for flight in (first, second))
    count = min(len(a), len(b))
    bits_a, bits_b = (np.ascontiguousarray(topic["thrust"][:count]).view(np.uint32) for topic in (a, b))
    differs = np.flatnonzero((bits_a != bits_b).any(axis=1) | (a.t[:count] != b.t[:count]))
    if len(differs):
        return float(a.t[differs[0]])
    if len(a) != len(b):
        return float((a if len(a) > count else b).t[count])
    return None


def begin_s(flight: LoggedFlight) -> float:
    """Where its time is compared from: the plan's start, else arming, else the log's first sample."""
    if flight.start_s is not None:
        return flight.start_s
    state = flight.log["vehicle_state"]
    armed = state.t[np.asarray(state["armed"], dtype=bool)]
    return float(armed[0]) if len(armed) else float(flight.log["vehicle_truth"].t[0])


def _apart(first: LoggedFlight, second: LoggedFlight) -> np.ndarray[Any, np.dtype[np.float64]]:
    a, b = first.log["vehicle_truth"], second.log["vehicle_truth"]
    t = a.t - begin_s(first)
    both = (t >= b.t[0] - begin_s(second)) & (t <= b.t[-1] - begin_s(second))
    if not both.any():
        return np.array([np.nan])
    offset = a["p"][both] - at_times(b, "p", t[both] + begin_s(second))
    return np.asarray(np.linalg.norm(offset, axis=1), dtype=np.float64)


def _figures(first: LoggedFlight, second: LoggedFlight) -> Iterator[Figure]:
    for name, unit, scale in (
        ("T_planned_s", "s", 1.0),
        ("T_flown_s", "s", 1.0),
        ("flight_s", "s", 1.0),
        ("tracking_rms_m", "mm", 1e3),
        ("tracking_max_m", "mm", 1e3),
        ("waypoint_miss_max_m", "mm", 1e3),
        ("rotor_saturated", "%", 100.0),
    ):
        got = [None if f.figures is None else scale * float(getattr(f.figures, name)) for f in (first, second)]
        yield Figure(name, unit, *got)
    a, b = (flight.log["vehicle_truth"] for flight in (first, second))
    yield Figure("highest", "m", *(float(truth["p"][:, 2].max()) for truth in (a, b)))
    yield Figure("fastest", "m/s", *(float(np.linalg.norm(truth["v"], axis=1).max()) for truth in (a, b)))
    turns = (float(np.degrees(np.linalg.norm(truth["w"], axis=1).max())) for truth in (a, b))
    yield Figure("quickest_turn", "deg/s", *turns)


def _parameters(first: LoggedFlight, second: LoggedFlight) -> Iterator[tuple[str, float | None, float | None]]:
    a, b = first.log.parameters, second.log.parameters
    for name in sorted(a.keys() | b.keys()):
        if a.get(name) != b.get(name):
            yield name, a.get(name), b.get(name)

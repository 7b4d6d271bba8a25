"""What is in a log, in numbers.

Why: before anything is drawn one wants to know what was recorded, how often, and whether something is missing.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from halfroll.results.log import Log, Topic
from halfroll.results.logged_flight import LoggedFlight, require_flight

_AT_EVENTS = frozenset(("firmware_call", "link_input", "stored_image", "vehicle_state", "vehicle_status"))
_A_GAP = 1.5  # of the usual interval


@dataclass(frozen=True)
class TopicFacts:
    """rate_hz: samples a second over the time between the first and the last; gaps: intervals longer than half as much
    again as the usual one, None for what is written when something happens."""

    name: str
    samples: int
    rate_hz: float
    first_s: float
    last_s: float
    longest_interval_s: float
    gaps: int | None


@dataclass(frozen=True)
class LogFacts:
    flight: LoggedFlight
    duration_s: float
    bytes: int
    complete: bool  # the simulator closed it
    topics: tuple[TopicFacts, ...]

    def as_json(self) -> dict[str, Any]:
        log, verdict = self.flight.log, self.flight.verdict
        return {
            "log": str(log.path),
            "duration_s": self.duration_s,
            "bytes": self.bytes,
            "complete": self.complete,
            "damaged": log.damaged,
            "good": verdict.good,
            "verdict": verdict.line,
            "causes": list(verdict.causes),
            "topics": [asdict(topic) for topic in self.topics],
            "info": {
                key: value if isinstance(value, (int, float, str)) else str(value) for key, value in log.info.items()
            },
            "embedded": {key: len(text) for key, text in log.embedded.items()},
            "messages": [asdict(text) for text in log.texts],
            "parameters": dict(log.parameters),
            "changed_parameters": [list(change) for change in log.changed],
        }


def facts(log: Log) -> LogFacts:
    """Raises InputError for a log of something else than a simulated flight."""
    flight = require_flight(log)
    truth = log["vehicle_truth"]
    topics = tuple(_topic(log[name]) for name in sorted(log) if len(log[name]))
    size = log.path.stat().st_size
    return LogFacts(flight, float(truth.t[-1] - truth.t[0]), size, "commands_sha256" in log.info, topics)


def _topic(topic: Topic) -> TopicFacts:
    between = np.diff(topic.t)
    span, longest = float(topic.t[-1] - topic.t[0]), float(between.max()) if len(between) else 0.0
    gaps = (
        None if topic.name in _AT_EVENTS else int(np.sum(between > _A_GAP * np.median(between))) if len(between) else 0
    )
    rate = (len(topic) - 1) / span if span > 0.0 else 0.0
    return TopicFacts(topic.name, len(topic), rate, float(topic.t[0]), float(topic.t[-1]), longest, gaps)

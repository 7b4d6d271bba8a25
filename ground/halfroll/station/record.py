"""What the ground saw of a flight: events for people, and the references it sent.

Why: progress, rates and results cross from the station's process to whoever started it; these are the values that do.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from halfroll.station.planning import Planned


@dataclass(frozen=True)
class Glance:
    """A flight at one look. rotors: (4,) signed shares of the largest thrust; link_rate_Hz of wall clock."""

    mode: str
    armed: bool
    item: int | None
    items: int
    speed_m_s: float
    error_m: float | None  # from the plan, while it is flown
    rotors: tuple[float, ...] | None
    link_rate_Hz: float
    vehicle_rate: float  # seconds of vehicle time in one of wall clock


@dataclass(frozen=True)
class Event:
    """Something a person watching would like to know.

    kind: connected, mission, planning, plan-progress, planned, plan-failed, late, upload, uploaded, armed, approach,
    flying, progress, item, left, handed-back, released, text (STATUSTEXT of the autopilot), landed, time.
    t_s: vehicle time; fraction: of the planned part; item: its sequence number; glance: with time, where the flight is;
    planned: what is ready to be flown.
    """

    kind: str
    t_s: float
    text: str
    fraction: float | None = None
    item: int | None = None
    glance: Glance | None = None
    planned: Planned | None = None


@dataclass
class Record:
    """One flight of a plan, as far as the ground can tell. Vehicle times [s], except where the name says wall."""

    planned: Planned
    plan_start_s: float | None = None
    plan_end_s: float | None = None
    sent_s: list[float] = field(default_factory=list)  # each reference
    sent_wall_s: list[float] = field(default_factory=list)
    error_m: list[float] = field(default_factory=list)  # telemetry against the plan, each tick

    def __str__(self) -> str:
        rate, interval_ms = self.rate_hz(by_wall_clock=True), 1e3 * self.interval_p99_s()
        return f"{self.references_sent} references, {rate:.1f} a second, 99 % of intervals under {interval_ms:.1f} ms"

    @property
    def references_sent(self) -> int:
        return len(self.sent_s)

    def rate_hz(self, by_wall_clock: bool) -> float:
        times = self.sent_wall_s if by_wall_clock else self.sent_s
        return (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 and times[-1] > times[0] else 0.0

    def as_json(self) -> dict[str, float]:
        """Figures of the link, for the log."""
        return {
            "references_sent": self.references_sent,
            "rate_by_vehicle_Hz": self.rate_hz(by_wall_clock=False),
            "rate_by_wall_Hz": self.rate_hz(by_wall_clock=True),
            "interval_p99_s": self.interval_p99_s(),
        }

    def interval_p99_s(self) -> float:
        """99th percentile of the wall-clock time between references."""
        return float(np.percentile(np.diff(self.sent_wall_s), 99.0)) if len(self.sent_wall_s) > 1 else 0.0

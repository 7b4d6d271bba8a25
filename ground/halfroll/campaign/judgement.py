"""What a run came to: figures of one flight, and whether it counts as flown.

Why: both fidelities are judged by the same lines on the same rows: true positions and rotor commands, 1 kHz.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfroll.results import evaluation

if TYPE_CHECKING:
    from halfroll.campaign.space import Success
    from halfroll.station.planning import Planned
    from halfroll.vehicle import Vehicle

Rows = NDArray[np.float32]
NAN = float("nan")


@dataclass(frozen=True)
class Figures:
    """Over the planned part, as far as it was flown; NaN of what was never begun. Errors are distances in space."""

    T_planned_s: float = NAN
    plan_start_s: float = NAN  # vehicle time
    flight_s: float = 0.0  # vehicle time that was simulated
    tracking_rms_m: float = NAN
    tracking_max_m: float = NAN
    waypoint_miss_max_m: float = NAN
    rotor_saturated: float = NAN  # share of time with a rotor command at a limit
    rotor_min_N: float = NAN
    rotor_max_N: float = NAN
    waypoint_miss_m: tuple[float, ...] = ()
    commands_sha256: bytes = b"\0" * 32  # of all rotor commands from switch-on to the plan's end


SUMMED_UP = tuple(field.name for field in fields(Figures) if field.name not in ("waypoint_miss_m", "commands_sha256"))


@dataclass(frozen=True)
class Outcome:
    figures: Figures
    why: str = ""  # it does not count, or "": it does

    @property
    def succeeded(self) -> bool:
        return not self.why

    def as_row(self) -> dict[str, Any]:
        return {"succeeded": self.succeeded, "why": self.why, **vars(self.figures)}


def figures_of(
    planned: Planned, vehicle: Vehicle, positions: Rows, commands: Rows, start_ms: int | None, flight_s: float
) -> Figures:
    """positions (N, 3), commands (N, 4): a row each millisecond from switch-on; start_ms: when the plan was begun."""
    plan = planned.plan
    if start_ms is None or start_ms >= len(positions):
        return Figures(T_planned_s=plan.T, flight_s=flight_s, commands_sha256=_sha256(commands))
    end_ms = start_ms + int(np.ceil(1e3 * plan.T / 10.0 - 1e-9)) * 10  # the tick at which it is at its end
    p: NDArray[np.float64] = np.asarray(positions[start_ms : end_ms + 1], dtype=np.float64)
    commanded: NDArray[np.float64] = np.asarray(commands[start_ms : end_ms + 1], dtype=np.float64)
    t: NDArray[np.float64] = np.asarray(1e-3 * np.arange(len(p)), dtype=np.float64)
    table = planned.path.derivatives[:, 0, :3]  # of the plan, a row each millisecond, too: all runs have it at hand
    wanted = table[np.minimum(np.arange(len(p)), len(table) - 1)]
    flown = evaluation.path_figures(plan, t, p, wanted, commanded, vehicle)
    return Figures(
        T_planned_s=plan.T,
        plan_start_s=1e-3 * start_ms,
        flight_s=flight_s,
        tracking_rms_m=flown.tracking_rms_m,
        tracking_max_m=flown.tracking_max_m,
        waypoint_miss_max_m=max(flown.waypoint_miss_m),
        rotor_saturated=flown.rotor_saturated,
        rotor_min_N=min(flown.rotor_min_N),
        rotor_max_N=max(flown.rotor_max_N),
        waypoint_miss_m=flown.waypoint_miss_m,
        commands_sha256=_sha256(commands[: end_ms + 1]),
    )


def judged(figures: Figures, ended: str, wanted: Success) -> Outcome:
    """ended: why the flight ended early, or ""."""
    if ended:
        return Outcome(figures, ended)
    for name, got, most, unit in (
        ("tracking", figures.tracking_max_m, wanted.tracking_max_m, " m"),
        ("waypoint miss", figures.waypoint_miss_max_m, wanted.waypoint_miss_m, " m"),
        ("rotors at a limit", figures.rotor_saturated, wanted.saturated, " of the time"),
    ):
        if not got <= most:
            return Outcome(figures, f"{name} {got:.3f}{unit}, allowed {most:g}")
    return Outcome(figures)


def _sha256(commands: Rows) -> bytes:
    return hashlib.sha256(np.ascontiguousarray(commands, dtype="<f4").tobytes()).digest()

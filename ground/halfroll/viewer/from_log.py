"""A flight's log as moments. Why: one place knows which topic says what a viewer shows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfroll.results.log import Log, Topic, read_log
from halfroll.results.pictures import MODES
from halfroll.vehicle import Vehicle, load_vehicle
from halfroll.viewer.moments import Array, Columns, Recording, setting_of

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan

RATE_HZ = 100.0
DEFAULT_VEHICLE = "mit-vp"


def logged(
    log: Log | str | Path, plan: Plan | None = None, plan_start_s: float | None = None, vehicle: Vehicle | None = None
) -> Recording:
    """The flight in a log, beside its plan where one is given.

    plan_start_s: vehicle time at which the plan began; without it, when OFFBOARD had brought the vehicle to the plan's
    start. vehicle: default the plan's, else the shipped one that the log names. Raises InputError.
    """
    log = log if isinstance(log, Log) else read_log(log)
    flown_by = vehicle or (plan.vehicle if plan else load_vehicle(str(log.info.get("vehicle", DEFAULT_VEHICLE))))
    truth = log["vehicle_truth"]
    step = max(1, round(1.0 / (RATE_HZ * float(np.median(np.diff(truth.t)))))) if len(truth) > 1 else 1
    rows = np.arange(0, len(truth), step)
    t = truth.t[rows]
    p, v, q, w = (np.asarray(truth[name][rows], dtype=np.float64) for name in ("p", "v", "q", "w"))
    thrust = _latest(log["rotor_commands"], "thrust", t)
    wanted = _latest(log["attitude_reference"], "q", t)
    mode, armed = _latest(log["vehicle_state"], "mode", t), _latest(log["vehicle_state"], "armed", t)
    words = [MODES[int(each)].upper() if int(each) < len(MODES) else str(int(each)) for each in mode]
    is_armed = armed != 0.0
    nothing, nowhere = np.full(len(t), -1), np.full((len(t), 3), np.nan)
    known = np.where(is_armed[:, None], wanted, np.nan)
    flown = Columns(t, p, q, v, w, thrust, nowhere, known, words, is_armed, nothing)
    if plan is not None:
        start_s = plan_start_s if plan_start_s is not None else _plan_start(flown, plan)
        flown = flown if start_s is None else flown.beside(plan, start_s)
    return Recording.of_columns(setting_of(flown_by, plan, f"{log.path.name} · {flown_by.name}"), flown)


def _latest(topic: Topic, name: str, t: Array) -> NDArray[np.float64]:
    """The field's last samples not after the times t."""
    rows = np.clip(np.searchsorted(topic.t, t + 1e-7, side="right") - 1, 0, len(topic) - 1)
    return np.asarray(topic[name][rows], dtype=np.float64)


def _plan_start(flight: Columns, plan: Plan) -> float | None:
    """When the flight fits the plan best: the plan's clock is not in every log. None if it was never flown."""
    offboard = flight.t_s[np.array([mode == "OFFBOARD" for mode in flight.mode], dtype=bool)]
    if not len(offboard):
        return None
    late = np.linspace(0.0, plan.T, 60)
    where = np.asarray(plan.at(late).position, dtype=np.float64)

    def misfit(start_s: float) -> float:
        flown = np.stack([np.interp(start_s + late, flight.t_s, flight.p_WB[:, k]) for k in range(3)], axis=1)
        return float(np.sum((flown - where) ** 2))

    coarse = min(np.arange(offboard[0], offboard[-1] + 1e-9, 0.05), key=misfit)
    return float(min(np.arange(coarse - 0.06, coarse + 0.06, 0.005), key=misfit))

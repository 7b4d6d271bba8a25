"""One run, in either fidelity: inside this process, or through halfroll-sitl and MAVLink over UDP.

Why: the same run, the same plan, the same judgement; over an ideal link the same bits (tests/campaign says so).
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware
from halfroll.campaign.judgement import Figures, Outcome, figures_of, judged
from halfroll.campaign.prepared import Prepared, switched_on
from halfroll.campaign.sampling import Run
from halfroll.campaign.space import Setup, SpaceError
from halfroll.errors import FlightError, PlanError
from halfroll.flight import fly
from halfroll.results.log import read_log
from halfroll.station import references
from halfroll.station.planning import Planned
from halfroll.station.station import LINK_DELAY_S

_TAKEOFF_PATIENCE_S = 60.0
_LEAST_UPRIGHT = 0.7  # vertical component of the thrust axis at the end
_ARRIVED_M = 0.5
_ENDINGS = {
    _firmware.Ending.DID_NOT_START: "did not take off",
    _firmware.Ending.NEVER_SETTLED: "never settled at the plan's start",
    _firmware.Ending.LEFT_PLAN: "left the plan",
    _firmware.Ending.RELEASED: "the autopilot left OFFBOARD",
    _firmware.Ending.CRASHED: "crashed",
}


@dataclass(frozen=True)
class _Here:
    """The autopilot's estimate as its telemetry has it."""

    t_us: int
    q_WB: NDArray[np.float64]
    w_WB_B: NDArray[np.float64]
    p_WB: NDArray[np.float64]
    v_WB: NDArray[np.float64]


def fly_run(prepared: Prepared, run: Run) -> dict[str, Any]:
    """The row of a run: run, seed, the numbers that vary, what came of it. A run that cannot be flown is one that
    failed."""
    try:
        setup = prepared.space.setup(run.values)
        planned = prepared.planned_for(setup)
        told = prepared.space.told
        outcome = (closed_loop if told.fidelity == "closed-loop" else sitl)(prepared, planned, setup, run.seed)
    except (PlanError, SpaceError) as error:
        outcome = Outcome(Figures(), f"not flown: {error}")
    return {"run": run.index, "seed": run.seed, **run.values, **outcome.as_row()}


def closed_loop(prepared: Prepared, planned: Planned, setup: Setup, seed: int) -> Outcome:
    """Autopilot, world and references in this process, without the GIL while they fly."""
    told = prepared.space.told
    sortie = switched_on(setup, prepared.origin, prepared.image, seed)
    ended = _ENDINGS[_firmware.Ending.DID_NOT_START]
    if sortie.take_off(list(prepared.commands.start), planned.course.first_item, _TAKEOFF_PATIENCE_S):
        ended = _streamed(prepared, planned, setup, sortie)
    elif sortie.crashed:
        ended = _ENDINGS[_firmware.Ending.CRASHED]
    start_ms = sortie.plan_start_us // 1000 or None
    figures = figures_of(planned, setup.vehicle, sortie.positions, sortie.commands, start_ms, 1e-6 * sortie.t_us)
    return judged(figures, ended, told.success)


def _streamed(prepared: Prepared, planned: Planned, setup: Setup, sortie: _firmware.Sortie) -> str:
    """From take-over to the hover at the end; why it ended early, or ""."""
    estimate, start, link = sortie.estimate, planned.plan.waypoints[0], setup.link
    numbers = [np.asarray(x, dtype=np.float64) for x in (estimate.q_WB, estimate.w_WB_B, estimate.p_WB, estimate.v_WB)]
    values = {name: sortie.params[name] for name in references.PARAMETERS}
    believed = link.believed_s if link.believed_s is not None else 0.0 if link.is_ideal else LINK_DELAY_S
    ending = sortie.follow(
        references.for_vehicle(setup.known, values, believed),
        references.approach(_Here(sortie.t_us, *numbers), start.position, start.yaw),
        planned.path,
        planned.plan.T,
        np.asarray(start.position, dtype=np.float64),
        prepared.commands.take_over,
        hold_s=prepared.space.told.hold_s,
        delay_s=link.delay_s,
        jitter_s=link.jitter_s,
        loss=link.loss,
    )
    if ending != _firmware.Ending.FLOWN:
        return _ENDINGS[ending]
    away = float(np.linalg.norm(sortie.p_WB - np.asarray(planned.plan.waypoints[-1].position)))
    upright = 1.0 - 2.0 * float(sortie.q_WB[1] ** 2 + sortie.q_WB[2] ** 2)
    if away > _ARRIVED_M or upright < _LEAST_UPRIGHT:
        return f"ended {away:.2f} m from the last waypoint, thrust axis {upright:+.2f} up"
    return ""


def sitl(prepared: Prepared, planned: Planned, setup: Setup, seed: int) -> Outcome:
    """halfroll-sitl, ground station and pilot as `halfroll fly` has them, in lockstep, from upload to landing."""
    with tempfile.TemporaryDirectory(prefix="halfroll-") as folder:
        path, ended, start_s = Path(folder) / "flight.ulg", "", None
        try:
            flown = fly(
                prepared.mission,
                setup.known,
                in_world=setup.vehicle,
                planned=planned,
                scenario=setup.scenario,
                seed=seed,
                origin=prepared.origin,
                log_path=path,
            )
            start_s = flown.plan_start_s
        except FlightError as error:
            ended = re.sub(r"\s+", " ", str(error))
        log = read_log(path)
        positions, commands = log["vehicle_truth"]["p"], log["rotor_commands"]["thrust"]
        start_ms = None if start_s is None else round(1e3 * start_s)
        figures = figures_of(planned, setup.vehicle, positions, commands, start_ms, 1e-3 * len(positions))
        if not ended and start_s is None:
            ended = _ENDINGS[_firmware.Ending.NEVER_SETTLED]
        return judged(figures, ended, prepared.space.told.success)

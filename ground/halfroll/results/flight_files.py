"""The files of one flight. Why: log, plan, report, picture and figures lie side by side under names that stay.

A folder holds one flight: the next into the same folder overwrites it, so a script knows where to look.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfroll.errors import FlightError, InputError
from halfroll.planner.course import course
from halfroll.results.evaluation import FlightFigures, evaluate

if TYPE_CHECKING:
    from halfroll.flight import FlightResult

PLAN, EXACT_PLAN, PICTURE, RESULT = "plan.csv", "plan.json", "flight.png", "result.json"
REPLAY = "replay.html"


@dataclass(frozen=True)
class FlightFiles:
    """Log and report may lie elsewhere; the rest is in `folder`."""

    folder: Path
    log: Path
    report: Path

    def prepare(self) -> None:
        """Makes the folders and removes what the last flight left, before anything flies. Raises InputError."""
        named = {self.log: "--log F.ulg", self.report: "--report R.html"}
        for file in (
            *(self.folder / name for name in (PLAN, EXACT_PLAN, PICTURE, RESULT, REPLAY)),
            self.log,
            self.report,
        ):
            option = "--out DIR" if file.parent == self.folder else named[file]
            try:
                file.parent.mkdir(parents=True, exist_ok=True)
                file.touch()
                file.unlink()
            except OSError as error:
                raise InputError(
                    f"{file}: cannot be written: {error.strerror}; choose another with {option}"
                ) from error

    def write(self, flown: FlightResult, *, mission: str, command: str) -> FlightFigures | None:
        """Judges the flight and writes plan, report, picture and figures; None where there was nothing to plan.

        Raises FlightError if there was, but no plan was flown.
        """
        from halfroll.results.log import read_log
        from halfroll.results.report import save_picture, write_report

        if flown.plan is None or flown.plan_start_s is None:
            if len(course(flown.mission).waypoints) < 2:
                return None
            raise FlightError(f"{mission} was flown by the autopilot alone, its plan was not; the log is {self.log}")
        log, vehicle = read_log(flown.log_path), flown.vehicle
        figures = evaluate(flown.plan, flown.plan_start_s, log, vehicle)
        flown.plan.save(self.folder / PLAN)
        flown.plan.save(self.folder / EXACT_PLAN)
        references = f"{flown.references_sent}, {flown.reference_rate_Hz:.2f} per second"
        write_report(
            self.report,
            figures,
            flown.plan,
            flown.plan_start_s,
            log,
            vehicle,
            mission=mission,
            command=command,
            facts={"references sent": references},
            replay=self._replay,
        )
        save_picture(self.folder / PICTURE, flown.plan, flown.plan_start_s, log, vehicle)
        result = json.dumps(self.as_json(flown, figures), indent=2)
        (self.folder / RESULT).write_text(result + "\n", encoding="utf-8")
        return figures

    @property
    def _replay(self) -> str | None:
        """Where the report finds it, if it was written."""
        replay = self.folder / REPLAY
        return os.path.relpath(replay, self.report.parent) if replay.is_file() else None

    def as_json(self, flown: FlightResult, figures: FlightFigures | None) -> dict[str, Any]:
        """The machine-readable result of `fly`; figures are None for a flight without a plan."""
        if figures is None:
            alone = {"result": "flown without a plan", "commands_sha256": flown.commands_sha256, "log": str(self.log)}
            return alone if flown.board is None else {**alone, "board": dict(flown.board)}
        return {
            "result": "flown" if figures.within_limits else "out of limits",
            **figures.as_json(),
            "plan_start_s": flown.plan_start_s,
            "failed": [f"{c.what}: {c.got}, allowed {c.allowed}" for c in figures.checks if not c.holds],
            "references_sent": flown.references_sent,
            "reference_rate_Hz": flown.reference_rate_Hz,
            "reference_interval_p99_s": flown.interval_p99_s,
            "commands_sha256": flown.commands_sha256,
            **({} if flown.board is None else {"board": dict(flown.board)}),
            "notes": list(flown.notes),
            **({"replay": str(self.folder / REPLAY)} if self._replay else {}),
            "log": str(self.log),
            "report": str(self.report),
        }

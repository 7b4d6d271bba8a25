"""The files of one flight. Why: log, plan, report, picture and figures lie side by side under names that stay.

A folder holds one flight: the next into the same folder overwrites it, so a script knows where to look.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfroll.errors import FlightError, HalfrollError, InputError
from halfroll.planner.course import course
from halfroll.results.evaluation import FlightFigures, evaluate
from halfroll.results.log import read_log
from halfroll.results.logged_flight import LoggedFlight
from halfroll.results.report import report_json, write_report

if TYPE_CHECKING:
    from halfroll.flight import FlightResult

PLAN, EXACT_PLAN, PICTURE, RESULT = "plan.csv", "plan.json", "flight.png", "result.json"
REPLAY = "replay.html"


_REPORTS = (".html", ".htm", ".pdf")


def require_report(path: Path) -> None:
    """Raises InputError for a name that says of no form that reports have."""
    if path.suffix.lower() not in _REPORTS:
        raise InputError(f"{path}: a report is written as .html or .pdf; end the name in one of them")


@dataclass(frozen=True)
class FlightFiles:
    """Log and report may lie elsewhere; the rest is in `folder`."""

    folder: Path
    log: Path
    report: Path

    def prepare(self) -> None:
        """Makes the folders and removes what the last flight left, before anything flies. Raises InputError."""
        require_report(self.report)
        raw_link = self.log.with_suffix(".tlog")
        named = {self.log: "--log F.ulg", raw_link: "--log F.ulg", self.report: "--report R.html"}
        for file in (
            *(self.folder / name for name in (PLAN, EXACT_PLAN, PICTURE, RESULT, REPLAY)),
            self.log,
            raw_link,
            self.report,
        ):
            option = "--out DIR" if file.parent == self.folder else named[file]
            if file.exists() and not file.is_file():  # what is there is removed, and should be no device
                raise InputError(f"{file}: it is no file; choose another with {option}")
            try:
                file.parent.mkdir(parents=True, exist_ok=True)
                file.touch()
                file.unlink()
            except OSError as error:
                raise InputError(
                    f"{file}: cannot be written: {error.strerror}; choose another with {option}"
                ) from error

    def write(self, flown: FlightResult) -> FlightFigures | None:
        """Judges the flight and writes plan, report, picture and figures; None where there was nothing to plan.

        Raises FlightError if there was, but no plan was flown.
        """
        flight, figures = LoggedFlight.of(read_log(flown.log_path)), None
        if flown.plan is not None and flown.plan_start_s is not None:
            figures = evaluate(flown.plan, flown.plan_start_s, flight.log, flown.vehicle)
            flight = replace(
                flight,
                mission=flown.mission.name,
                plan=flown.plan,
                start_s=flown.plan_start_s,
                vehicle=flown.vehicle,
                figures=figures,
            )
        self._report(flight, {} if flown.board is None else {"steps on the board": str(flown.board["steps"])})
        if figures is None and len(course(flown.mission).waypoints) >= 2:
            raise FlightError(
                f"{flight.mission} was flown by the autopilot alone, its plan was not; the log is {self.log}"
            )
        self._keep(self.as_json(flown, figures))
        return figures

    def write_failed(self, error: HalfrollError) -> None:
        """The same for a flight that `error` has ended, as far as its log goes; the error then names the files."""
        try:
            flight = LoggedFlight.of(read_log(self.log))
        except InputError:  # it never came to a flight
            return
        self._report(flight, {})
        error.files = {"log": str(self.log), "report": str(self.report)}
        self._keep({"result": "failed", **report_json(flight), **error.as_json()})

    def _report(self, flight: LoggedFlight, facts: Mapping[str, str]) -> None:
        from halfroll.results.pictures import save_picture

        if flight.plan is not None:
            flight.plan.save(self.folder / PLAN)
            flight.plan.save(self.folder / EXACT_PLAN)
        write_report_as_named(self.report, flight, facts, self._replay)
        save_picture(self.folder / PICTURE, flight)

    def _keep(self, result: Mapping[str, Any]) -> None:
        (self.folder / RESULT).write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")

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


def write_report_as_named(
    path: Path, flight: LoggedFlight, facts: Mapping[str, str] | None = None, replay: str | None = None
) -> None:
    """A page, which links to the replay, or a PDF, as the name ends. Raises InputError for any other name, OSError."""
    require_report(path)
    if path.suffix.lower() == ".pdf":
        from halfroll.results.report_pdf import write_pdf

        write_pdf(path, flight)
    else:
        write_report(path, flight, facts, replay)

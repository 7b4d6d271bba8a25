"""What a person names to be looked at, as a recording. Why: logs, flights' folders, plans and missions are told apart
here and nowhere else.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfroll.errors import InputError
from halfroll.missions.mission import Mission
from halfroll.planner.plan import Plan
from halfroll.reading import parse_json, read_text
from halfroll.results.log import Log
from halfroll.viewer.from_log import logged
from halfroll.viewer.moments import Recording, planned

if TYPE_CHECKING:
    from halfroll.flight import FlightResult

LOG, PLAN, RESULT = "flight.ulg", "plan.json", "result.json"  # of a flight's folder


def recording_of(
    what: Plan | FlightResult | Log | Mission | str | Path, *, plan: Plan | str | Path | None = None, **planning: Any
) -> Recording:
    """Anything that flies, may fly or flew.

    what: a plan, a flight as hr.fly returns it, a log; a mission, which is planned first (`planning`: as for hr.plan);
    or a file of these, or a flight's folder. plan: what a log is shown beside; default what lies in the log's folder.
    Raises InputError for what is none of these, and what reading and planning raise.
    """
    if isinstance(what, Plan):
        return planned(what, f"plan · {what.vehicle.name} · {what.T:.2f} s")
    if isinstance(what, Log):
        return _of_log(what, what.path, plan)
    if isinstance(what, (str, Path)):
        return _of_file(Path(what), plan, planning)
    if isinstance(what, Mission):
        return _of_mission(what, planning)
    return logged(what.log_path, what.plan, what.plan_start_s, what.vehicle)


def _of_file(path: Path, plan: Plan | str | Path | None, planning: dict[str, Any]) -> Recording:
    if path.is_dir():
        path = path / LOG
    if path.suffix == ".ulg":
        return _of_log(path, path, plan)
    if path.suffix == ".npz" or (path.suffix == ".json" and path.is_file()):
        made = Plan.load(path)
        return planned(made, f"{path.name} · {made.vehicle.name} · {made.T:.2f} s")
    if not path.is_file():
        raise InputError(f"{path}: no such file; give live, a log (.ulg), a flight's folder, a plan or a mission")
    return _of_mission(path, planning)


def _of_log(log: Log | Path, path: Path, plan: Plan | str | Path | None) -> Recording:
    start_s = None
    if plan is None and (path.parent / PLAN).is_file():
        plan, start_s = path.parent / PLAN, _start_in(path.parent / RESULT)
    if isinstance(plan, (str, Path)):
        plan = Plan.load(plan)
    return logged(log, plan, start_s)


def _start_in(result: Path) -> float | None:
    try:
        start_s = parse_json(read_text(result)).get("plan_start_s")
    except (OSError, ValueError):
        return None
    return float(start_s) if isinstance(start_s, (int, float)) else None


def _of_mission(mission: Mission | Path, planning: dict[str, Any]) -> Recording:
    from halfroll import preflight

    made = preflight.plan(mission, **planning)
    name = mission.name
    return planned(made, f"{name} · {made.vehicle.name} · {made.T:.2f} s")

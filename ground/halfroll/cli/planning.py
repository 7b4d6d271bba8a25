"""`halfroll check` and `halfroll plan`. Why: what needs no vehicle."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from halfroll.cli.endings import Ended, errors_for_people, say_error
from halfroll.cli.options import (
    Changes,
    Json,
    LimitsKind,
    Margin,
    MissionFile,
    PlanningMode,
    Settings,
    VehicleName,
    YawRule,
    limit_changes,
    overrides,
)
from halfroll.errors import FlightError, InputError


def check(
    mission: MissionFile,
    vehicle: VehicleName = "mit-vp",
    settings: Settings = None,
    mode: PlanningMode = "paper",
    limits: LimitsKind = "mission",
    margin: Margin = None,
    changes: Changes = None,
    yaw: YawRule = None,
    as_json: Json = False,
) -> None:
    """Say what will be flown, what is not supported, and how long it takes."""
    with errors_for_people(as_json):
        from halfroll import console, preflight
        from halfroll.missions.mission import limits_kind

        with console.status("planning") as said:
            found = preflight.check(
                mission,
                vehicle,
                mode=mode,
                limits=limits_kind(limits),
                margin=margin,
                changes=limit_changes(changes),
                yaw=yaw,
                overrides=overrides(settings),
                progress=said,
            )
        if as_json:
            console.print_json(console.check_json(found) | (found.error.as_json() if found.error else {}))
        else:
            console.show_check(found)
        if found.error is not None:
            say_error(str(found.error))
            raise Ended(found.error.exit_code)


def plan(
    mission: MissionFile,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="P", help="Write the plan: .csv (1 kHz), .json or .npz.")
    ] = None,
    mode: PlanningMode = "paper",
    vehicle: VehicleName = "mit-vp",
    limits: LimitsKind = "mission",
    margin: Margin = None,
    changes: Changes = None,
    yaw: YawRule = None,
    settings: Settings = None,
    as_json: Json = False,
) -> None:
    """Plan the shortest flight through a mission, from its first to its last point."""
    with errors_for_people(as_json):
        if output is not None and output.suffix.lower() not in (".csv", ".json", ".npz"):
            raise InputError(f"{output}: plans are written as .csv, .json or .npz; end the name in one of them")
        from halfroll import console, preflight
        from halfroll.missions.mission import limits_kind
        from halfroll.vehicle import load_vehicle
        from halfroll.wire.transport import wall_s

        flown_by = load_vehicle(vehicle, overrides(settings))
        began_s = wall_s()
        with console.status("planning") as said:
            made = preflight.plan(
                mission,
                flown_by,
                mode=mode,
                limits=limits_kind(limits),
                margin=margin,
                changes=limit_changes(changes),
                yaw=yaw,
                progress=said,
            )
        solve_s = wall_s() - began_s
        if output is not None:
            made.save(output)
        if as_json:
            console.print_json(console.plan_json(made, str(mission), solve_s))
        else:
            console.show_plan(made)
            if output is not None:
                print(f"plan: {output}")
        if not made.certified:
            raise Ended(FlightError.exit_code)

"""`halfroll fly`, `sitl`, `hil` and `ground`. Why: what starts processes that fly."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from halfroll.cli.endings import Ended, errors_for_people
from halfroll.cli.options import (
    Changes,
    FlownVehicle,
    Instance,
    Json,
    LimitsKind,
    Margin,
    MissionFile,
    PlanningMode,
    Settings,
    VehicleName,
    YawRule,
    command_line,
    limit_changes,
    overrides,
)
from halfroll.cli.viewing import page_beside, require_viser
from halfroll.errors import FlightError, HalfrollError


def fly(
    mission: MissionFile,
    vehicle: FlownVehicle = None,
    scenario: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Air, sensors, faults: ideal, nominal, windy..., or a .toml file.")
    ] = "nominal",
    seed: Annotated[
        int | None, typer.Option(help="Of all that is random: one seed, one flight (the scenario's, else 0).", min=0)
    ] = None,
    lockstep: Annotated[
        bool, typer.Option("--lockstep/--real-time", help="Time waits for the ground station, or for nobody.")
    ] = True,
    speed: Annotated[
        float | None, typer.Option(help="Times real time, 0: as fast as it goes (lockstep 0, else 1).", min=0.0)
    ] = None,
    mode: PlanningMode = "paper",
    margin: Margin = None,
    limits: LimitsKind = "mission",
    changes: Changes = None,
    yaw: YawRule = None,
    settings: Settings = None,
    board: Annotated[
        str | None, typer.Option(metavar="NAME", help="Fly the firmware of a board: qemu-m4, qemu-m7, python, COMMAND.")
    ] = None,
    beside: Annotated[
        bool, typer.Option("--board-beside", help="Fly it in the simulator, too, and count the bits that differ.")
    ] = False,
    live: Annotated[
        bool, typer.Option("--live", help="Show it on a page while it flies, in real time unless --speed says else.")
    ] = False,
    replay: Annotated[
        bool, typer.Option("--replay", help="Also write DIR/replay.html, which shows the flight in any browser.")
    ] = False,
    log: Annotated[Path | None, typer.Option(metavar="F.ulg", help="Where the log goes; else into DIR.")] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="R", help="An .html or .pdf file; else DIR/report.html.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The flight's folder, overwritten; else flights/MISSION-VEHICLE.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Fly a mission from take-off to landing, and report. Exit code 0: flown within limits."""
    with errors_for_people(as_json):
        from halfroll import boards, console, preflight
        from halfroll.console_flight import watched_flight
        from halfroll.missions.mission import PlanOptions, limits_kind
        from halfroll.missions.mission_files import load_mission
        from halfroll.planner.near_optimal import limits_in
        from halfroll.results.flight_files import REPLAY, FlightFiles
        from halfroll.scenario import load_scenario
        from halfroll.vehicle import load_vehicle

        in_world = load_scenario(scenario)
        flown_by = load_vehicle(vehicle or in_world.vehicle or "mit-vp", overrides(settings))
        wanted = load_mission(mission)
        # What is wrong with what was asked for is said before the last flight's files go.
        planned_in = preflight.planning_mode(mode)
        limits_in(flown_by, PlanOptions.of(planned_in, limits_kind(limits), margin, limit_changes(changes), yaw))
        if board is not None:
            boards.command(board)
        if live or replay:
            require_viser()
        folder = out or Path("flights") / f"{mission.stem}-{flown_by.name}"
        files = FlightFiles(folder, log or folder / "flight.ulg", report or folder / "report.html")
        files.prepare()
        from halfroll.flight import fly as fly_mission

        watched = sys.stderr.isatty()  # the dashboard stands in its place below
        with contextlib.ExitStack() as stack:
            beside_page = stack.enter_context(page_beside(flown_by)) if live else None
            said, report_event = stack.enter_context(watched_flight(f"{mission.name} · {flown_by.name}"))
            try:
                flown = fly_mission(
                    wanted,
                    flown_by,
                    scenario=scenario,
                    seed=in_world.seed if seed is None else seed,
                    lockstep=lockstep,
                    speed=1.0 if live and speed is None else speed,
                    limits=limits_kind(limits),
                    margin=margin,
                    mode=planned_in,
                    changes=limit_changes(changes),
                    yaw=yaw,
                    log_path=files.log,
                    command=command_line(),
                    board=board,
                    beside=beside,
                    watched=watched,
                    on_ports=beside_page or (lambda instance: None),
                    progress=said,
                    report=report_event,
                )
            except HalfrollError as error:
                files.write_failed(error)
                raise
            except KeyboardInterrupt:
                if files.log.is_file():
                    typer.echo(f"the log ends here: {files.log}", err=True)
                raise
            if replay:
                said("replay", None)
                from halfroll.viewer.notebook import view

                view(flown).save(files.folder / REPLAY)
            said("report", None)
            figures = files.write(flown)
        if as_json:
            console.print_json(files.as_json(flown, figures))
        else:
            console.show_flight(flown, figures, files, real_time=not lockstep)
        if figures is not None and not figures.within_limits:
            raise Ended(FlightError.exit_code)


def sitl(context: typer.Context) -> None:
    """Run the simulated vehicle: halfroll-sitl, its own options (--help lists them), vehicle and scenario files."""
    with errors_for_people(as_json=False):
        from halfroll.simulator import arguments, executable

        program = str(executable())
        given = arguments(context.args)
        sys.stdout.flush()
        os.execv(program, [program, *given])


def hil(
    context: typer.Context,
    port: Annotated[str, typer.Option(metavar="DEVICE:BAUD", help="Serial port of the board, at 921600 or as said.")],
) -> None:
    """Hardware in the loop: the simulated world around a board at a serial port; other options as of sitl.

    In each millisecond 60 to 120 bytes go there and 170 come back: real time wants 4 Mbaud and drivers that take less
    than 0.4 ms together. Slower lines fly with --lockstep, or --speed 0.1.
    """
    with errors_for_people(as_json=False):
        from halfroll.simulator import arguments, executable

        program = str(executable())
        given = arguments(context.args)
        sys.stdout.flush()
        os.execv(program, [program, "--board-port", port, *given])


def ground(
    vehicle: VehicleName = "mit-vp",
    instance: Instance = 0,
    serial: Annotated[
        str | None, typer.Option(metavar="DEVICE:BAUD", help="An autopilot at a serial port, in place of UDP.")
    ] = None,
    mode: PlanningMode = "paper",
    margin: Margin = None,
    limits: LimitsKind = "mission",
    changes: Changes = None,
    yaw: YawRule = None,
    settings: Settings = None,
    log: Annotated[
        Path | None,
        typer.Option(metavar="F.ulg", help="The log that halfroll sitl --log writes: plan and reference are added."),
    ] = None,
    tlog: Annotated[Path | None, typer.Option(metavar="F.tlog", help="Where the raw link goes, for MAVProxy.")] = None,
) -> None:
    """Run the ground station until Ctrl-C: it plans what is uploaded, and flies it once it is started."""
    with errors_for_people(as_json=False):
        from halfroll import preflight
        from halfroll.flight import run_ground
        from halfroll.missions.mission import PlanOptions, limits_kind
        from halfroll.vehicle import load_vehicle

        run_ground(
            load_vehicle(vehicle, overrides(settings)),
            instance=instance,
            serial=serial,
            options=PlanOptions.of(
                preflight.planning_mode(mode), limits_kind(limits), margin, limit_changes(changes), yaw
            ),
            log=log,
            tlog=tlog,
            report=lambda event: print(f"{event.t_s:8.2f} s  {event.text}", flush=True),
        )

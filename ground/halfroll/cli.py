"""The command line. Why: arguments, exit codes and errors; everything is computed elsewhere, and imported only by the
command that needs it, so that `--help` comes at once.
"""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer

from halfroll.errors import FlightError, HalfrollError, InputError, LinkError

STOPPED, TERMINATED = 130, 143  # exit codes after Ctrl-C and SIGTERM, as shells have them

app = typer.Typer(
    name="halfroll",
    help="Minimum-time flight of quadrotors: plan a mission, prove that the rotors can fly it, fly it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

MissionFile = Annotated[Path, typer.Argument(metavar="MISSION", help=".plan, QGC WPL 110, KML, CSV or TOML.")]
VehicleName = Annotated[str, typer.Option("--vehicle", metavar="V", help="A shipped vehicle, or a .toml file.")]
FlownVehicle = Annotated[
    str | None,
    typer.Option("--vehicle", metavar="V", help="A shipped vehicle, or a .toml file (the scenario's, else mit-vp)."),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=NUMBER", help="A number of the vehicle, like rotor.thrust_max_N=2.5; repeatable."
    ),
]
LimitsKind = Annotated[str, typer.Option("--limits", metavar="mission|rotors", help="All, or rotor thrust alone.")]
Margin = Annotated[
    float | None,
    typer.Option("--margin", metavar="SHARE", help="Share of rotor thrust kept free (mission 0.1, rotors 0)."),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="NAME=NUMBER",
        help="A limit, or off: speed_m_s, tilt_deg, body_rate_deg_s, rotor_rate_N_s, floor_m, ceiling_m; repeatable.",
    ),
]
YawRule = Annotated[
    str | None,
    typer.Option(
        "--yaw",
        metavar="free|given|path|N,W",
        help="Where the nose points: what is fastest, as given, along the path, at a point in metres from home.",
    ),
]
PlanningMode = Annotated[str, typer.Option("--mode", metavar="paper|fast|best", help="How near the least time.")]
Json = Annotated[bool, typer.Option("--json", help="One JSON object on standard output, progress on standard error.")]


def _print_version(wanted: bool) -> None:
    if wanted:
        import halfroll

        print(f"halfroll {halfroll.__version__}")
        raise typer.Exit


@app.callback()
def _top(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command()
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
    with _errors_for_people(as_json):
        from halfroll import console, preflight

        with console.status("planning") as said:
            found = preflight.check(
                mission,
                vehicle,
                mode=mode,
                limits=_limits(limits),
                margin=_share(margin),
                changes=_changes(changes),
                yaw=yaw,
                overrides=_overrides(settings),
                progress=said,
            )
        if as_json:
            console.print_json(console.check_json(found) | _error_json(found.error))
        else:
            console.show_check(found)
        if found.error is not None:
            _say_error(str(found.error))
            raise Ended(found.error.exit_code)


@app.command()
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
    with _errors_for_people(as_json):
        if output is not None and output.suffix.lower() not in (".csv", ".json", ".npz"):
            raise InputError(f"{output}: plans are written as .csv, .json or .npz; end the name in one of them")
        from halfroll import console, preflight
        from halfroll.transport import wall_s
        from halfroll.vehicle import load_vehicle

        flown_by = load_vehicle(vehicle, _overrides(settings))
        began_s = wall_s()
        with console.status("planning") as said:
            made = preflight.plan(
                mission,
                flown_by,
                mode=mode,
                limits=_limits(limits),
                margin=_share(margin),
                changes=_changes(changes),
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


@app.command()
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
    log: Annotated[Path | None, typer.Option(metavar="F.ulg", help="Where the log goes; else into DIR.")] = None,
    report: Annotated[Path | None, typer.Option(metavar="R.html", help="Where the report goes; else into DIR.")] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The flight's folder, overwritten; else flights/MISSION-VEHICLE.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Fly a mission from take-off to landing, and report. Exit code 0: flown within limits."""
    with _errors_for_people(as_json):
        from halfroll import console, preflight
        from halfroll.flight_files import FlightFiles
        from halfroll.mission_files import load_mission
        from halfroll.scenario import load_scenario
        from halfroll.vehicle import load_vehicle

        in_world = load_scenario(scenario)
        flown_by = load_vehicle(vehicle or in_world.vehicle or "mit-vp", _overrides(settings))
        wanted = load_mission(mission)
        folder = out or Path("flights") / f"{mission.stem}-{flown_by.name}"
        files = FlightFiles(folder, log or folder / "flight.ulg", report or folder / "report.html")
        files.prepare()
        from halfroll.flight import fly as fly_mission

        with console.phases() as said:
            flown = fly_mission(
                wanted,
                flown_by,
                scenario=scenario,
                seed=in_world.seed if seed is None else seed,
                lockstep=lockstep,
                speed=speed,
                limits=_limits(limits),
                margin=_share(margin),
                mode=preflight.planning_mode(mode),
                changes=_changes(changes),
                yaw=yaw,
                log_path=files.log,
                board=board,
                beside=beside,
                progress=said,
            )
            said("report", None)
            figures = files.write(flown, mission=mission.name, command=_command_line())
        if as_json:
            console.print_json(files.as_json(flown, figures))
        else:
            console.show_flight(flown, figures, files, real_time=not lockstep)
        if figures is not None and not figures.within_limits:
            raise Ended(FlightError.exit_code)


@app.command(add_help_option=False, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def sitl(context: typer.Context) -> None:
    """Run the simulated vehicle: halfroll-sitl, its own options (--help lists them), vehicle and scenario files."""
    with _errors_for_people(as_json=False):
        from halfroll.simulator import arguments, executable

        program = str(executable())
        given = arguments(context.args)
        sys.stdout.flush()
        os.execv(program, [program, *given])


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def hil(
    context: typer.Context,
    port: Annotated[str, typer.Option(metavar="DEVICE:BAUD", help="Serial port of the board, at 921600 or as said.")],
) -> None:
    """Hardware in the loop: the simulated world around a board at a serial port; other options as of sitl.

    In each millisecond 60 to 120 bytes go there and 170 come back: real time wants 4 Mbaud and drivers that take less
    than 0.4 ms together. Slower lines fly with --lockstep, or --speed 0.1.
    """
    with _errors_for_people(as_json=False):
        from halfroll.simulator import arguments, executable

        program = str(executable())
        given = arguments(context.args)
        sys.stdout.flush()
        os.execv(program, [program, "--board-port", port, *given])


@app.command()
def ground(
    vehicle: VehicleName = "mit-vp",
    instance: Annotated[int, typer.Option(metavar="N", help="Of the simulator: added to its ports.", min=0)] = 0,
    serial: Annotated[
        str | None, typer.Option(metavar="DEVICE:BAUD", help="An autopilot at a serial port, in place of UDP.")
    ] = None,
    mode: PlanningMode = "paper",
    margin: Margin = None,
    limits: LimitsKind = "mission",
    changes: Changes = None,
    yaw: YawRule = None,
    settings: Settings = None,
) -> None:
    """Run the ground station until Ctrl-C: it plans what is uploaded, and flies it once it is started."""
    with _errors_for_people(as_json=False):
        if instance > 9:
            raise InputError(f"instance {instance}: ports are laid out for 0 to 9; choose one of these")
        from halfroll import preflight
        from halfroll.flight import run_ground
        from halfroll.mission import PlanOptions
        from halfroll.vehicle import load_vehicle

        run_ground(
            load_vehicle(vehicle, _overrides(settings)),
            instance=instance,
            serial=serial,
            options=PlanOptions.of(
                preflight.planning_mode(mode), _limits(limits), _share(margin), _changes(changes), yaw
            ),
            report=lambda event: print(f"{event.t_s:8.2f} s  {event.text}", flush=True),
        )


@app.command()
def paper(
    parts: Annotated[
        list[str] | None, typer.Argument(metavar="[fig1..fig9 t1..t5]", help="Figures, claims of the text; else all.")
    ] = None,
    out: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Where pictures and a page go.")] = Path(
        "flights/paper"
    ),
    seeds: Annotated[int, typer.Option(help="Flights of each claim that is flown; the worst counts.", min=1)] = 10,
    as_json: Json = False,
) -> None:
    """Reproduce the paper, claim by claim: planned, flown, drawn. Exit code 0: every claim holds."""
    with _errors_for_people(as_json):
        from halfroll import console
        from halfroll.paper import reproduction

        names = reproduction.chosen(parts or [])
        with console.phases() as said:
            claims = reproduction.reproduce(names, out, seeds, said)
        if as_json:
            console.print_json(console.claims_json(claims))
        else:
            console.show_claims(claims, out)
        if not all(claim.holds for claim in claims):
            raise Ended(FlightError.exit_code)


params = typer.Typer(help="Parameters of a running autopilot, to and from QGroundControl's .params files.")
app.add_typer(params, name="params")
Instance = Annotated[int, typer.Option(metavar="N", help="Of the simulator: added to its ports.", min=0, max=9)]
ParamFile = Annotated[Path, typer.Argument(metavar="FILE", help="A .params file.")]


@params.command("export")
def export_params(file: ParamFile, instance: Instance = 0) -> None:
    """Write all parameters into FILE."""
    with _errors_for_people(as_json=False):
        from halfroll import param_files, tuning

        values = tuning.export_params(instance)
        param_files.write_params(file, values, system=1 + instance)
        print(f"{len(values)} parameters: {file}")


@params.command("import")
def import_params(file: ParamFile, instance: Instance = 0) -> None:
    """Set every parameter of FILE. Exit code 2 if any was unknown or refused; the others are set all the same."""
    with _errors_for_people(as_json=False):
        from halfroll import param_files, tuning

        done = tuning.import_params(param_files.read_params(file), instance)
        print(f"{len(done.changed)} changed")
        for names, why in ((done.unknown, "unknown here"), (done.refused, "refused: out of range, or armed")):
            if names:
                _say_error(f"{', '.join(names)}: {why}")
        if done.unknown or done.refused:
            raise Ended(InputError.exit_code)


# What people type, turned into values.


def _overrides(settings: Sequence[str] | None) -> dict[str, str | float]:
    pairs: dict[str, str | float] = {}
    for setting in settings or ():
        key, equals, number = setting.partition("=")
        if not equals or not key.strip() or not number.strip():
            raise InputError(f"--set {setting}: KEY=NUMBER is wanted, like rotor.thrust_max_N=2.5")
        pairs[key.strip()] = number.strip()
    return pairs


def _changes(settings: Sequence[str] | None) -> dict[str, float | None]:
    changes: dict[str, float | None] = {}
    for setting in settings or ():
        name, _, number = (word.strip() for word in setting.partition("="))
        try:
            changes[name] = None if number == "off" else float(number)
        except ValueError:
            raise InputError(f"--limit {setting}: NAME=NUMBER or NAME=off is wanted, like tilt_deg=45") from None
    return changes


def _limits(kind: str) -> Literal["mission", "rotors"]:
    if kind == "mission":
        return "mission"
    if kind == "rotors":
        return "rotors"
    raise InputError(f"limits {kind!r} are not known; give mission or rotors")


def _share(margin: float | None) -> float | None:
    if margin is not None and not 0.0 <= margin < 1.0:
        raise InputError(f"margin {margin:g} is no share of the rotors' thrust; give 0 or more and less than 1")
    return margin


def _command_line() -> str:
    return shlex.join(["halfroll", *sys.argv[1:]])


# How it ends.


class _Terminated(KeyboardInterrupt):
    """SIGTERM: ends everything on the same way as Ctrl-C."""


def _terminate(*_: object) -> NoReturn:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # cleaning up is not stopped half way
    raise _Terminated


class Ended(SystemExit):
    """The command has said all it has to say."""


@contextlib.contextmanager
def _errors_for_people(as_json: bool) -> Iterator[None]:
    """One sentence on standard error and the exit code; with --json, the same as an object on standard output."""
    try:
        yield
    except HalfrollError as error:
        _fail(error, as_json)
    except KeyboardInterrupt as stop:
        if as_json:
            print(json.dumps({"error": {"kind": "stopped", "message": "stopped"}}))
        print("stopped", file=sys.stderr)
        raise Ended(TERMINATED if isinstance(stop, _Terminated) else STOPPED) from None
    except BrokenPipeError:  # whoever read us has gone, as `| head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise Ended(1) from None
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith("halfroll._"):  # what the build makes
            raise
        _fail(LinkError(f"{error.name} is missing: halfroll is not built; run `pip install .`"), as_json)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        _fail(InputError(f"{where}{error.strerror or error}; check its permissions and that there is room"), as_json)


def _fail(error: HalfrollError, as_json: bool) -> NoReturn:
    if as_json:
        print(json.dumps(_error_json(error)))
    _say_error(str(error))
    raise Ended(error.exit_code)


def _say_error(sentence: str) -> None:
    typer.echo(typer.style("error: ", fg="red") + sentence, err=True)


def _error_json(error: HalfrollError | None) -> dict[str, dict[str, str | int]]:
    if error is None:
        return {}
    about: dict[str, str | int] = {"kind": error.kind, "message": str(error)}
    return {"error": about if error.item is None else {**about, "item": error.item}}


class _WrongUsage(InputError):
    kind = "usage"


_TYPERS_USAGE_ERROR: Any = typer.BadParameter.__base__  # the only way to it in every typer


def main() -> None:
    """The `halfroll` command. Wrong usage ends as every error: one sentence, with --json an object, exit code 2."""
    if not sys.argv[1:]:
        app()  # prints the help and ends
    signal.signal(signal.SIGTERM, _terminate)
    try:
        sys.exit(app(standalone_mode=False))
    except _TYPERS_USAGE_ERROR as wrong:
        where = wrong.ctx.command_path if wrong.ctx else "halfroll"
        _fail(_WrongUsage(f"{wrong.format_message().rstrip('.')}; see {where} --help"), "--json" in sys.argv)

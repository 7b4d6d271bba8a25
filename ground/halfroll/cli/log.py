"""`halfroll log`. Why: what can be asked of a flight after it was flown, from its log alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from halfroll.cli.endings import Ended, errors_for_people
from halfroll.cli.options import Json
from halfroll.errors import FlightError

log = typer.Typer(
    no_args_is_help=True,
    help="Look at the log of a flight: what is in it, figures, tables, the flight again, two flights compared.",
)
LogFile = Annotated[Path, typer.Argument(metavar="F.ulg", help="A log of halfroll fly, or of halfroll sitl --log.")]


@log.command()
def info(file: LogFile, as_json: Json = False) -> None:
    """Say how the flight ended, which topics there are, how often they come, gaps, and what was said.

    For example: halfroll log info flights/first_flight-mit-vp/flight.ulg
    """
    with errors_for_people(as_json):
        from halfroll import console, console_logs
        from halfroll.results.log import read_log
        from halfroll.results.log_facts import facts

        found = facts(read_log(file))
        if as_json:
            console.print_json(found.as_json())
        else:
            console_logs.show_facts(found)


@log.command()
def plot(
    file: LogFile,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="P", help="A folder for all pictures, or one .png, .pdf or .svg."),
    ] = None,
    suffix: Annotated[str, typer.Option("--format", metavar="png|pdf|svg", help="Of pictures in a folder.")] = "png",
    as_json: Json = False,
) -> None:
    """Draw path, errors, attitude and rotors: one overview, or every picture of the report as a file of its own.

    For example: halfroll log plot flight.ulg -o flight.png, or -o pictures --format pdf
    """
    with errors_for_people(as_json):
        from halfroll import console, console_logs
        from halfroll.results.log import read_log
        from halfroll.results.logged_flight import require_flight
        from halfroll.results.pictures import save_picture, save_pictures

        flight = require_flight(read_log(file))
        where = output or file.with_suffix("")
        if where.suffix:
            save_picture(where, flight)
            files = [where]
        else:
            where.mkdir(parents=True, exist_ok=True)
            files = save_pictures(where, flight, f".{suffix}")
        if as_json:
            console.print_json({"pictures": [str(each) for each in files]})
        else:
            console_logs.show_files(files)


@log.command()
def export(
    file: LogFile,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Where the tables go; else beside the log.")
    ] = None,
    kind: Annotated[str, typer.Option("--format", metavar="csv|parquet", help="Parquet needs pyarrow.")] = "csv",
    topics: Annotated[
        list[str] | None, typer.Option("--topic", metavar="NAME", help="Only this topic; repeatable.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Write each topic as a table: t_s and its fields, every number bit for bit.

    For example: halfroll log export flight.ulg -o tables --topic vehicle_truth --topic rotor_commands
    """
    with errors_for_people(as_json):
        from halfroll import console, console_logs
        from halfroll.results.log import read_log
        from halfroll.results.log_export import export as write

        files = write(read_log(file), output or file.with_suffix(""), kind, topics or ())
        if as_json:
            console.print_json({"tables": [str(each) for each in files]})
        else:
            console_logs.show_files(files)


@log.command()
def replay(
    file: LogFile,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="F.ulg", help="Where the new log goes; else F.replay.ulg.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Fly it again from all that its firmware heard. Exit code 0: every rotor command is equal in every bit.

    It takes the seed, vehicle and world of the log, in lockstep or real time, and a log that was cut short as far as it
    goes. Another version of halfroll may fly otherwise. For example: halfroll log replay flight.ulg --json
    """
    with errors_for_people(as_json):
        from halfroll import console
        from halfroll.replay import replay as fly_again
        from halfroll.results.comparison import first_difference_s
        from halfroll.results.log import read_log
        from halfroll.results.logged_flight import require_flight

        first = require_flight(read_log(file))
        again = fly_again(file, output or file.with_suffix(".replay.ulg"))
        second = require_flight(read_log(again.log))
        differs_s = first_difference_s(first, second)
        logged = first.log.info.get("commands_sha256")
        same = differs_s is None and logged in (None, again.commands_sha256)
        if as_json:
            console.print_json(
                {
                    "identical": same,
                    "commands_sha256": again.commands_sha256,
                    "logged_sha256": logged,
                    "flown_s": again.flown_s,
                    "differs_from_s": differs_s,
                    "log": str(again.log),
                    "commits": [str(each.log.info.get("ver_sw")) for each in (first, second)],
                }
            )
        else:
            console.show_replay(again, None if same else differs_s, first.log.info, second.log.info)
        if not same:
            raise Ended(FlightError.exit_code)


@log.command()
def compare(
    first: LogFile,
    second: Annotated[Path, typer.Argument(metavar="G.ulg", help="The other.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="P.png", help="A picture of both; .png, .pdf or .svg.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Put the figures of two flights side by side, with their differences and the parameters that differ.

    For example: halfroll log compare before.ulg after.ulg -o both.png
    """
    with errors_for_people(as_json):
        from halfroll import console, console_logs
        from halfroll.results.comparison import compare as put_side_by_side
        from halfroll.results.log import read_log
        from halfroll.results.logged_flight import require_flight
        from halfroll.results.pictures import save_comparison

        found = put_side_by_side(*(require_flight(read_log(file)) for file in (first, second)))
        if output is not None:
            save_comparison(output, found.flights)
        if as_json:
            console.print_json({**found.as_json(), "picture": None if output is None else str(output)})
        else:
            console_logs.show_comparison(found)


@log.command()
def report(
    file: LogFile,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="R", help="An .html or .pdf file; else F.html.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Write the report of a flight: a page that needs nothing else, or a PDF. --json: the same numbers.

    For example: halfroll log report flight.ulg -o flight.pdf
    """
    with errors_for_people(as_json):
        from halfroll import console, console_logs
        from halfroll.results.flight_files import write_report_as_named
        from halfroll.results.log import read_log
        from halfroll.results.logged_flight import require_flight
        from halfroll.results.report import report_json

        flight = require_flight(read_log(file))
        where = output or file.with_suffix(".html")
        write_report_as_named(where, flight)
        if as_json:
            console.print_json({**report_json(flight), "report": str(where)})
        else:
            console_logs.show_verdict(flight)
            console_logs.show_files([where])

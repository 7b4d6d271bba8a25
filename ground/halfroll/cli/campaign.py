"""`halfroll campaign` and `halfroll tune`. Why: ten thousand flights in one command, and gains that survive them."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from halfroll.cli.endings import Ended, errors_for_people
from halfroll.cli.options import Json
from halfroll.errors import FlightError, InputError

if TYPE_CHECKING:
    from halfroll.campaign.engines import Engine
    from halfroll.campaign.space import Space

SpaceFile = Annotated[Path, typer.Argument(metavar="SPACE", help="A .toml file: what is flown, and what of it varies.")]
Runs = Annotated[int | None, typer.Option("--runs", metavar="N", help="In place of what the space says.", min=1)]
Seed = Annotated[int | None, typer.Option("--seed", metavar="S", help="In place of what the space says.", min=0)]
EngineName = Annotated[
    str, typer.Option("--engine", metavar="threads|processes", help="Of this machine; or give --dask.")
]
Workers = Annotated[
    int | None, typer.Option("--workers", metavar="N", help="Threads or processes (a core each).", min=1)
]
DaskAddress = Annotated[
    str | None, typer.Option("--dask", metavar="tcp://HOST:PORT", help="A Dask scheduler's address.")
]


def campaign(
    space: SpaceFile,
    runs: Runs = None,
    seed: Seed = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Where runs are kept, and gone on with.")
    ] = None,
    engine: EngineName = "threads",
    workers: Workers = None,
    dask: DaskAddress = None,
    fidelity: Annotated[
        str | None, typer.Option(metavar="closed-loop|sitl", help="In this process, or through halfroll-sitl and UDP.")
    ] = None,
    run: Annotated[int | None, typer.Option("--run", metavar="I", help="Fly this run alone, again.", min=0)] = None,
    stop_when: Annotated[
        str | None, typer.Option("--stop-when", metavar="ci<SHARE", help="Stop once success is known so well.")
    ] = None,
    compare: Annotated[
        Path | None,
        typer.Option("--compare", metavar="BASELINE", help="Exit code 1 if worse than this folder or file."),
    ] = None,
    save: Annotated[Path | None, typer.Option("--save", metavar="F.parquet", help="All runs in one file.")] = None,
    report: Annotated[Path | None, typer.Option(metavar="R.html", help="Where the report goes; else into DIR.")] = None,
    as_json: Json = False,
) -> None:
    """Fly a scenario space: thousands of runs, kept as Parquet, gone on with after a stop, summed up and compared."""
    with errors_for_people(as_json):
        from halfroll.campaign.space import load_space

        changes: dict[str, Any] = {"runs": runs, "seed": seed, "fidelity": fidelity}
        told = load_space(space, changes)
        if run is not None:
            _fly_one(told, run, as_json)
            return
        folder = out or Path("flights") / f"campaign-{space.stem}"
        replay = _replay(space, told, fidelity)
        _fly_all(told, folder, _engine(engine, workers, dask), stop_when, compare, save, report, replay, as_json)


def _fly_one(space: Space, run: int, as_json: bool) -> None:
    from halfroll import console
    from halfroll.campaign.flights import fly_run
    from halfroll.campaign.prepared import prepare
    from halfroll.campaign.sampling import runs_of

    (chosen,) = runs_of(space, run, 1)
    with console.status("planning"):
        prepared = prepare(space)
    row = fly_run(prepared, chosen)
    row["commands_sha256"] = row["commands_sha256"].hex()
    if as_json:
        console.print_json(row)
    else:
        for name, value in row.items():
            print(f"{name:32}{value}")


def _fly_all(
    space: Space,
    folder: Path,
    engine: Engine,
    stop_when: str | None,
    compare: Path | None,
    save: Path | None,
    report: Path | None,
    replay: str,
    as_json: bool,
) -> None:
    from halfroll import campaign_console, console
    from halfroll.campaign.archive import (
        LONG_COLUMNS,
        open_archive,
        read_runs,
        require_parquet,
        save_as_one,
        schema_of,
    )
    from halfroll.campaign.comparison import compared
    from halfroll.campaign.flying import StopRule, fly_campaign
    from halfroll.campaign.page import write_page
    from halfroll.campaign.prepared import prepare
    from halfroll.campaign.sensitivity import sensitivities
    from halfroll.campaign.statistics import summary_of
    from halfroll.wire.transport import wall_s

    stop = StopRule.parsed(stop_when) if stop_when else None
    before = read_runs(compare) if compare else None
    if save is not None:
        require_parquet(save)
    open_archive(folder, space)  # before planning: the folder may hold another campaign
    with console.status("planning"):
        prepared = prepare(space)
    began_s, last = wall_s(), None

    with campaign_console.flying(space.told.runs) as tell:

        def progress(now: Any) -> None:
            nonlocal last
            last = now
            tell(now)

        archive = fly_campaign(prepared, engine, folder, space.told.runs, stop, progress)
    wall = wall_s() - began_s
    table = read_runs(folder, [name for name in schema_of(space).names if name not in LONG_COLUMNS])
    summary, found = summary_of(table), sensitivities(space, table)
    page = report or folder / "report.html"
    write_page(page, space, table, replay)
    if save is not None:
        save_as_one(save, archive.tables(), schema_of(space))
    differences = compared(before, table) if before is not None else ()
    if as_json:
        told = summary.as_json(replay)
        told["wall_s"], told["flown_now"] = wall, last.flown if last else 0
        told["x_realtime"] = last.flown_s / wall if last else None
        told["sensitivity"] = [vars(each) for each in found]
        told["compared"] = [vars(each) for each in differences]
        told["folder"], told["report"] = str(folder), str(page)
        console.print_json(told)
    else:
        if last:
            print(
                f"{last.flown} runs, {last.flown_s:.0f} s of flight in {wall:.1f} s: {last.flown / wall:.1f} a second, "
                f"{last.flown_s / wall:.0f}x real time"
            )
        campaign_console.show_summary(summary, found, replay, (("runs", folder), ("report", page)))
        if differences:
            campaign_console.show_comparison(differences)
    if any(each.worse for each in differences):
        raise Ended(FlightError.exit_code)


def tune(
    space: SpaceFile,
    over: Annotated[
        list[str], typer.Option("--over", metavar="KEY=LOW:HIGH", help="params.NAME or plan.margin; repeatable.")
    ],
    out: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="F", help="A .params file, or a vehicle .toml, with what was found."),
    ],
    goal: Annotated[
        str, typer.Option("--minimise", metavar="tracking|T", help="Error (95 % of RMS), or the plan's time.")
    ] = "tracking",
    success: Annotated[float, typer.Option(metavar="SHARE", help="Success wanted.", min=0.0, max=1.0)] = 0.999,
    trials: Annotated[int, typer.Option(help="Candidates.", min=2)] = 30,
    runs: Annotated[int, typer.Option(help="Of each candidate.", min=10)] = 200,
    proof: Annotated[int, typer.Option(help="Runs, that none was tuned on, to prove the best.", min=10)] = 3000,
    engine: EngineName = "threads",
    workers: Workers = None,
    dask: DaskAddress = None,
    seed: Seed = None,
    as_json: Json = False,
) -> None:
    """Find gains and margins that make a space's runs fast, or near their plan, and still succeed."""
    with errors_for_people(as_json):
        from halfroll import campaign_console, console
        from halfroll.campaign import gains
        from halfroll.campaign.space import load_space

        if goal not in ("T", "tracking"):
            raise InputError(f"--minimise {goal} is not known; give T or tracking")
        knobs = [gains.Knob.parsed(words) for words in over]
        told = load_space(space, {"seed": seed})
        if out.suffix not in (".params", ".toml"):
            raise InputError(f"{out}: write the result as .params or as a vehicle .toml")
        tuned = gains.tune(
            told,
            knobs,
            _engine(engine, workers, dask),
            goal="T" if goal == "T" else "tracking",
            trials=trials,
            runs=runs,
            proof_runs=proof,
            least_success=success,
            progress=campaign_console.show_trial,
        )
        gains.write_tuned(out, told, tuned)
        if as_json:
            console.print_json(
                {
                    "values": dict(tuned.best.values),
                    "goal": tuned.proof.goal,
                    "untuned": tuned.untuned.goal,
                    "T_s": tuned.proof.T_s,
                    "success": {
                        "rate": tuned.proof.success,
                        "at_least": tuned.at_least,
                        "runs": tuned.proof.runs,
                        "untuned": tuned.untuned.success,
                    },
                    "file": str(out),
                }
            )
        else:
            campaign_console.show_tuned(tuned)
            print(f"written {out}")
        if not tuned.is_proven:
            raise FlightError(
                f"on runs that it was not tuned on, {tuned.proof.succeeded} of {tuned.proof.runs} succeed: with 95 % "
                f"confidence at least {tuned.at_least:.2%}, and {success:.2%} were wanted; give more --proof, more "
                "--runs or a wider margin"
            )


def _engine(name: str, workers: int | None, dask: str | None) -> Engine:
    from halfroll.campaign import engines

    if dask is not None:
        return engines.Dask(dask)
    if name == "threads":
        return engines.Threads(workers)
    if name == "processes":
        return engines.Processes(workers)
    raise InputError(f"--engine {name} is not known; give threads or processes, or --dask")


def _replay(file: Path, space: Space, fidelity: str | None) -> str:
    """The command that flies one run again, {run} in it."""
    words = ["halfroll", "campaign", str(file), "--seed", str(space.told.seed)]
    words += ["--runs", str(space.told.runs)] if space.told.sampling == "lhs" else []
    words += ["--fidelity", fidelity] if fidelity else []
    return shlex.join(words).replace("{", "{{").replace("}", "}}") + " --run {run}"

"""What people type, turned into values. Why: an option that several commands have is written once."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from halfroll.errors import InputError

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


Instance = Annotated[int, typer.Option(metavar="N", help="Of the simulator: added to its ports.", min=0, max=9)]


def overrides(settings: Sequence[str] | None) -> dict[str, str | float]:
    pairs: dict[str, str | float] = {}
    for setting in settings or ():
        key, equals, number = setting.partition("=")
        if not equals or not key.strip() or not number.strip():
            raise InputError(f"--set {setting}: KEY=NUMBER is wanted, like rotor.thrust_max_N=2.5")
        pairs[key.strip()] = number.strip()
    return pairs


def limit_changes(settings: Sequence[str] | None) -> dict[str, float | None]:
    changes: dict[str, float | None] = {}
    for setting in settings or ():
        name, _, number = (word.strip() for word in setting.partition("="))
        try:
            changes[name] = None if number == "off" else float(number)
        except ValueError:
            raise InputError(f"--limit {setting}: NAME=NUMBER or NAME=off is wanted, like tilt_deg=45") from None
    return changes


def command_line() -> str:
    return shlex.join(["halfroll", *sys.argv[1:]])

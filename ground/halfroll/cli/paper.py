"""`halfroll paper`. Why: the paper in one command."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from halfroll.cli.endings import Ended, errors_for_people
from halfroll.cli.options import Json
from halfroll.errors import FlightError


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
    with errors_for_people(as_json):
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

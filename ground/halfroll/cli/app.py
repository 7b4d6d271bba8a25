"""The command line: its commands, and how wrong usage ends.

Why: one list of commands in the order of `--help`.
"""

from __future__ import annotations

import itertools
import signal
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from halfroll.cli import campaign, flying, log, paper, params, planning, viewing
from halfroll.cli.endings import fail, terminate
from halfroll.errors import InputError

app = typer.Typer(
    name="halfroll",
    help="Minimum-time flight of quadrotors: plan a mission, prove that the rotors can fly it, fly it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


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


app.command()(planning.check)
app.command()(planning.plan)
app.command()(flying.fly)
app.command(add_help_option=False, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(
    flying.sitl
)
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(flying.hil)
app.command()(flying.ground)
app.command()(viewing.view)
app.command()(paper.paper)
app.add_typer(log.log, name="log")
app.command()(campaign.campaign)
app.command()(campaign.tune)
app.add_typer(params.params, name="params")


class _WrongUsage(InputError):
    kind = "usage"


_TYPERS_USAGE_ERROR: Any = typer.BadParameter.__base__  # the only way to it in every typer


def main() -> None:
    """The `halfroll` command. Wrong usage ends as every error: one sentence, with --json an object, exit code 2."""
    if not sys.argv[1:]:
        app()  # prints the help and ends
    signal.signal(signal.SIGTERM, terminate)
    try:
        sys.exit(app(standalone_mode=False))
    except _TYPERS_USAGE_ERROR as wrong:
        where = wrong.ctx.command_path if wrong.ctx else "halfroll"
        said = wrong.format_message().rstrip(".")
        given = _given(sys.argv, getattr(getattr(wrong, "param", None), "opts", ()))
        if given is not None and given not in said:
            said += f", not {given}"
        fail(_WrongUsage(f"{said}; see {where} --help"), "--json" in sys.argv)


def _given(words: Sequence[str], names: Sequence[str]) -> str | None:
    """The value of an option of these names, as it was typed: what is wrong with it is said without it."""
    for word, following in itertools.pairwise([*words, ""]):
        name, equals, value = word.partition("=")
        if name in names:
            return value if equals else following
    return None

"""How a command ends: one sentence for people, one object for programs, an exit code for both.

Why: no command shows a traceback for what a person can mend.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
from collections.abc import Iterator
from typing import NoReturn

import typer

from halfroll.errors import HalfrollError, InputError, LinkError

STOPPED, TERMINATED = 130, 143  # exit codes after Ctrl-C and SIGTERM, as shells have them


class _Terminated(KeyboardInterrupt):
    """SIGTERM: ends everything on the same way as Ctrl-C."""


def terminate(*_: object) -> NoReturn:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # cleaning up is not stopped half way
    raise _Terminated


class Ended(SystemExit):
    """The command has said all it has to say."""


@contextlib.contextmanager
def errors_for_people(as_json: bool) -> Iterator[None]:
    """One sentence on standard error and the exit code; with --json, the same as an object on standard output."""
    try:
        yield
    except HalfrollError as error:
        fail(error, as_json)
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
        fail(LinkError(f"{error.name} is missing: halfroll is not built; run `pip install .`"), as_json)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        fail(InputError(f"{where}{error.strerror or error}; check its permissions and that there is room"), as_json)


def fail(error: HalfrollError, as_json: bool) -> NoReturn:
    if as_json:
        print(json.dumps(error.as_json()))
    say_error(str(error))
    for name, file in error.files.items():
        typer.echo(f"{name:7}{file}", err=True)
    raise Ended(error.exit_code)


def say_error(sentence: str) -> None:
    typer.echo(typer.style("error: ", fg="red") + sentence, err=True)

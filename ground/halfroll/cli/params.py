"""`halfroll params`: parameters of a running autopilot, and their files. Why: QGroundControl's files work here, too."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from halfroll.cli.endings import Ended, errors_for_people, say_error
from halfroll.cli.options import Instance
from halfroll.errors import InputError

params = typer.Typer(help="Parameters of a running autopilot, to and from QGroundControl's .params files.")
ParamFile = Annotated[Path, typer.Argument(metavar="FILE", help="A .params file.")]


@params.command("export")
def export_params(file: ParamFile, instance: Instance = 0) -> None:
    """Write all parameters into FILE."""
    with errors_for_people(as_json=False):
        from halfroll import param_files, tuning

        values = tuning.export_params(instance)
        param_files.write_params(file, values, system=1 + instance)
        print(f"{len(values)} parameters: {file}")


@params.command("import")
def import_params(file: ParamFile, instance: Instance = 0) -> None:
    """Set every parameter of FILE. Exit code 2 if any was unknown or refused; the others are set all the same."""
    with errors_for_people(as_json=False):
        from halfroll import param_files, tuning

        done = tuning.import_params(param_files.read_params(file), instance)
        print(f"{len(done.changed)} changed")
        for names, why in ((done.unknown, "unknown here"), (done.refused, "refused: out of range, or armed")):
            if names:
                say_error(f"{', '.join(names)}: {why}")
        if done.unknown or done.refused:
            raise Ended(InputError.exit_code)

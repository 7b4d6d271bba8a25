"""Parameter files as QGroundControl writes and reads them: a line per parameter, separated by tabs.

Why: a vehicle's tuning must outlive its autopilot, and be readable by the ground station people have.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from halfroll.errors import InputError
from halfroll.reading import read_text

_REAL32 = 9  # MAV_PARAM_TYPE
_COMPONENT = 1
_COLUMNS = 5  # vehicle, component, name, value, type


def write_params(file: Path, values: Mapping[str, float], system: int = 1) -> None:
    """Shortest decimals that give the same 32-bit floats again. Raises OSError."""
    head = [
        f"# Onboard parameters for Vehicle {system}",
        "#",
        "# Stack: halfroll",
        "#",
        "# Vehicle-Id Component-Id Name Value Type",
    ]
    rows = [f"{system}\t{_COMPONENT}\t{name}\t{_shortest(values[name])}\t{_REAL32}" for name in sorted(values)]
    file.write_text("\n".join([*head, *rows]) + "\n")


def read_params(file: Path) -> dict[str, float]:
    """By name. Raises InputError naming the line."""
    values: dict[str, float] = {}
    for number, line in enumerate(_lines(file), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        columns = line.split("\t")
        where = f"{file}, line {number}"
        if len(columns) != _COLUMNS:
            raise InputError(f"{where}: {len(columns)} columns, wanted are vehicle, component, name, value and type")
        name = columns[2].strip()
        try:
            value = float(columns[3])
        except ValueError:
            raise InputError(f"{where}: {name} is {columns[3]!r}, which is no number") from None
        if not math.isfinite(value):
            raise InputError(f"{where}: {name} is {columns[3]}; a parameter must be finite")
        if name in values:
            raise InputError(f"{where}: {name} stands there twice; keep one")
        values[name] = value
    if not values:
        raise InputError(f"{file}: no parameters in it; QGroundControl's .params format is wanted")
    return values


def _lines(file: Path) -> list[str]:
    try:
        return read_text(file).splitlines()
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror or error}; check the path") from None
    except UnicodeDecodeError:
        raise InputError(f"{file}: not a text file; QGroundControl's .params format is wanted") from None


def _shortest(value: float) -> str:
    return str(np.float32(value))

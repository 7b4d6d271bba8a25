"""The simulated vehicle's program. Why: where it lies, and how it gets a vehicle file, since it reads no TOML."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from halfroll.errors import InputError, LinkError
from halfroll.vehicle import Vehicle, load_vehicle

NAME = "halfroll-sitl"


def executable() -> Path:
    """halfroll-sitl beside this Python, else on the path. Raises LinkError where it is not installed."""
    beside = Path(sys.executable).with_name(NAME)
    found = str(beside) if beside.is_file() else shutil.which(NAME)
    if found is None:
        raise LinkError(f"{NAME} is neither beside {sys.executable} nor on the PATH; run `pip install .`")
    return Path(found)


def arguments(given: Sequence[str]) -> list[str]:
    """What halfroll-sitl is started with when a person typed `given`: a vehicle file becomes its numbers."""
    rest = list(given)
    for i, word in enumerate(rest):
        name, equals, joined = word.partition("=")
        if name != "--vehicle":
            continue
        if not equals and i + 1 == len(rest):
            raise InputError("--vehicle wants the name of a shipped vehicle or a .toml file")
        chosen = joined if equals else rest[i + 1]
        if chosen.endswith(".toml"):
            del rest[i : i + (1 if equals else 2)]
            return [*vehicle_arguments(load_vehicle(chosen)), *rest]  # first, so that --set changes them
    return rest


def vehicle_arguments(vehicle: Vehicle) -> list[str]:
    """Any vehicle, as a shipped one of its kind with every number set."""
    words = ["--vehicle", "mit-vp" if vehicle.variable_pitch else "mit-fp"]
    for key, number in vehicle.numbers().items():
        words += ["--set", f"{key}={number:.17g}"]
    return words

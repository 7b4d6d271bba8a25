"""The simulated vehicle's program. Why: where it lies, and how it gets vehicle and scenario files, since it reads no
TOML."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from halfroll import boards
from halfroll.errors import InputError, LinkError
from halfroll.scenario import Scenario, load_scenario
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
    """What halfroll-sitl is started with when a person typed `given`: vehicle and scenario files become numbers.

    These come first, so that --set, --scenario-set and --seed change them."""
    rest, scenario = _without(list(given), "--scenario")
    first: list[str] = []
    if scenario is not None:
        told = load_scenario(scenario)
        first += scenario_arguments(told)
        if told.seed is not None:
            first += ["--seed", str(told.seed)]
        if told.vehicle is not None and not any(word.partition("=")[0] == "--vehicle" for word in rest):
            rest = ["--vehicle", told.vehicle, *rest]
    rest, vehicle = _without(rest, "--vehicle")
    if vehicle is not None:
        first += vehicle_arguments(load_vehicle(vehicle))
    return [*first, *_with_board_started(rest)]


def _with_board_started(words: list[str]) -> list[str]:
    """The words with the name of a board replaced by what starts it."""
    for i, word in enumerate(words):
        name, equals, joined = word.partition("=")
        if name == "--board" and (equals or i + 1 < len(words)):
            command = boards.command(joined if equals else words[i + 1])
            return [*words[:i], "--board", command, *words[i + (1 if equals else 2) :]]
    return words


def _without(words: list[str], option: str) -> tuple[list[str], str | None]:
    """The words without an option that names a .toml file, and that file; other names stay."""
    for i, word in enumerate(words):
        name, equals, joined = word.partition("=")
        if name != option:
            continue
        if not equals and i + 1 == len(words):
            raise InputError(f"{option} wants the name of a shipped {option[2:]} or a .toml file")
        chosen = joined if equals else words[i + 1]
        if chosen.endswith(".toml"):
            return [*words[:i], *words[i + (1 if equals else 2) :]], chosen
    return words, None


def vehicle_arguments(vehicle: Vehicle, in_world: Vehicle | None = None) -> list[str]:
    """Any vehicle, as a shipped one of its kind with every number set; in_world: as the world has it."""
    words = ["--vehicle", "mit-vp" if vehicle.variable_pitch else "mit-fp"]
    for key, number in vehicle.numbers().items():
        words += ["--set", f"{key}={number:.17g}"]
    for key, number in in_world.numbers().items() if in_world else ():
        if number != vehicle.numbers().get(key):
            words += ["--world-set", f"{key}={number:.17g}"]
    return words


def scenario_arguments(scenario: Scenario) -> list[str]:
    """Any scenario, as the perfect world with every number set."""
    words = ["--scenario", "ideal", "--scenario-called", scenario.name or "own"]
    for key, number in scenario.numbers().items():
        words += ["--scenario-set", f"{key}={number:.17g}"]
    return words

"""A scenario space: what is flown, and what of it varies.

Why: a campaign is a value. Run i is a function of (space, seed, i) and nothing else, so any run can be flown again
alone, and everything that could be wrong with a space is said before the first flight.
"""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from halfroll import _firmware, tables
from halfroll.campaign.axes import Axis, Value
from halfroll.errors import HalfrollError, InputError
from halfroll.missions.mission import PlanMode
from halfroll.scenario import Scenario, load_scenario, scenario_table
from halfroll.tables import Table
from halfroll.vehicle import Vehicle, load_vehicle, vehicle_table

Fidelity = Literal["closed-loop", "sitl"]
Sampling = Literal["sobol", "lhs", "random", "grid", "saltelli"]
EXAMPLE = "docs/campaigns.md"
MOST_RUNS = 100_000_000  # a Sobol sequence ends at a thousand million


class SpaceError(InputError):
    kind = "space"


class LinkSetup(Table):
    """Between ground and vehicle, each way: delay and up to so much jitter, and the share of frames that is lost.
    believed_s: what the ground allows for; as a real one does, 2 ms, unless the link is ideal."""

    delay_s: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    jitter_s: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    loss: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    believed_s: Annotated[float, Field(ge=0.0, le=0.1)] | None = None

    @property
    def is_ideal(self) -> bool:
        return self.delay_s == self.jitter_s == self.loss == 0.0


class Planning(Table):
    """How the mission is planned. once: for the vehicle that the space names; else for the vehicle that each run flies,
    which its autopilot then knows, too."""

    mode: PlanMode = "fast"
    limits: Literal["mission", "rotors"] = "mission"
    margin: Annotated[float, Field(ge=0.0, lt=1.0)] | None = None
    once: bool = True


class Success(Table):
    """When a run that came to its end counts: distances from plan and waypoints, share of time with a rotor at its
    limit."""

    tracking_max_m: Annotated[float, Field(gt=0.0)] = 0.5
    waypoint_miss_m: Annotated[float, Field(gt=0.0)] = 0.5
    saturated: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0


class SpaceFile(Table):
    """What a space's file says."""

    name: str = ""
    description: str = ""
    mission: str
    vehicle: str = "mit-vp"
    scenario: str = "nominal"
    fidelity: Fidelity = "closed-loop"
    sampling: Sampling = "sobol"
    runs: Annotated[int, Field(ge=1, le=MOST_RUNS)] = 1000
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    hold_s: Annotated[float, Field(ge=0.0, le=60.0)] = 0.5  # hovers so long after the plan's end
    plan: Planning = Planning()
    link: LinkSetup = LinkSetup()
    success: Success = Success()
    set: dict[str, Value] = Field(default_factory=dict)
    vary: dict[str, Axis] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _varies_once(self) -> SpaceFile:
        both = sorted(set(self.set) & set(self.vary))
        if both:
            raise ValueError(f"{both[0]} is both set and varied; leave one")
        return self


@dataclass(frozen=True)
class Setup:
    """What one run flies, every number in its place."""

    vehicle: Vehicle  # as the world has it
    known: Vehicle  # as its autopilot and the planner have it
    scenario: Scenario
    link: LinkSetup
    plan: Planning


@dataclass(frozen=True)
class Space:
    """A checked space. `vary` and `set` name numbers by dotted key: vehicle.KEY (the world's, which the autopilot does
    not know of unless it plans for each run), params.NAME, scenario.KEY, link.KEY, plan.KEY."""

    told: SpaceFile
    folder: Path  # what relative names start from
    _vehicle: Mapping[str, Any] = field(repr=False)
    _scenario: Mapping[str, Any] = field(repr=False)

    @property
    def axes(self) -> dict[str, Axis]:
        return self.told.vary

    @property
    def mission(self) -> Path:
        return self.folder / self.told.mission

    @cached_property
    def fingerprint(self) -> str:
        """Equal for spaces whose runs are equal."""
        told = self.told.model_dump(mode="json", exclude={"name", "description", "runs", "seed"})
        mission = hashlib.sha256(self.mission.read_bytes()).hexdigest()
        words = json.dumps([told, mission, self._vehicle, self._scenario], sort_keys=True)
        return hashlib.sha256(words.encode()).hexdigest()[:16]

    def setup(self, values: Mapping[str, Value]) -> Setup:
        """The numbers of a run. Raises SpaceError for what no flight can begin with."""
        vehicle, scenario = copy.deepcopy(dict(self._vehicle)), copy.deepcopy(dict(self._scenario))
        link, planning = self.told.link.model_dump(), self.told.plan.model_dump()
        params: dict[str, Value] = {}
        for key, value in {**self.told.set, **values}.items():
            where, _, rest = key.partition(".")
            axis = self.axes.get(key)
            times = axis is not None and axis.times
            try:
                if where == "vehicle":
                    _change(vehicle, rest, value, times, ("params", "battery"), "vehicle")
                elif where == "scenario":
                    _change(scenario, rest, value, times, tuple(Scenario.model_fields), "scenario")
                elif where == "params":
                    _require_param(rest, value)
                    params[rest] = value
                elif where == "link":
                    _change(link, rest, value, times, (), "link")
                elif where == "plan":
                    _change(planning, rest, value, times, (), "plan")
                else:
                    raise SpaceError("is not known; keys begin with vehicle., scenario., params., link. or plan.")
            except HalfrollError as error:
                raise SpaceError(f"{key}: {error}") from None
        known = copy.deepcopy(vehicle if not planning["once"] else dict(self._vehicle))
        for table in (vehicle, known):
            table["params"] = {**table.get("params", {}), **params}
        try:
            return Setup(
                Vehicle.model_validate(vehicle),
                Vehicle.model_validate(known),
                Scenario.model_validate(scenario),
                LinkSetup.model_validate(link),
                Planning.model_validate(planning),
            )
        except ValidationError as error:
            raise SpaceError(tables.sentence(error, EXAMPLE)) from None

    @cached_property
    def nominal(self) -> Setup:
        """With nothing varied but what has no number of its own: there, the first of its axis."""
        first = {key: axis.extremes[0] for key, axis in self.axes.items() if not axis.times and not axis.is_numeric}
        return self.setup(first)


def _change(table: dict[str, Any], key: str, value: Value, times: bool, made: tuple[str, ...], what: str) -> None:
    unknown = SpaceError(f"{what} has no number called {key}; check its spelling ({EXAMPLE} says where the keys stand)")
    if not times:
        tables.override(table, key, value, unknown, made)
        return
    assert isinstance(value, float)
    before: Any = table
    for step in key.split("."):
        entry = int(step) if isinstance(before, list | tuple) and step.isdigit() else step
        try:
            before = before[entry]
        except (KeyError, IndexError, TypeError):
            raise unknown from None
    if isinstance(before, list | tuple):
        for i, number in enumerate(before):
            tables.override(table, f"{key}.{i}", number * value, unknown, made)
    elif isinstance(before, int | float):
        tables.override(table, key, before * value, unknown, made)
    else:
        raise SpaceError(f"is {before!r}, which cannot be multiplied")


def _require_param(name: str, value: Value) -> None:
    for row in _firmware.parameter_table():
        if row.id == name:
            if not isinstance(value, float | int) or not row.least <= value <= row.most:
                raise SpaceError(f"{value} is out of range; {name} lies between {row.least:g} and {row.most:g}")
            return
    raise SpaceError(f"the autopilot has no parameter {name}; docs/parameters.md lists them")


def load_space(path: str | Path, changes: Mapping[str, Any] | None = None) -> Space:
    """A space from its TOML file, `changes` (like runs, seed) in place of what it says; everything is checked.

    Raises SpaceError, or what is wrong with its vehicle or scenario.
    """
    path = Path(path)
    if path.suffix != ".toml":
        raise SpaceError(f"space {path}: a space is a .toml file, like examples/campaign_course_d.toml")
    table = tables.as_written(path, path.parent, "space", SpaceError)
    table.update({key: value for key, value in (changes or {}).items() if value is not None})
    table.setdefault("name", path.stem)
    return make_space(table, path.parent, f"space {path}")


def make_space(table: Mapping[str, Any], folder: Path, called: str = "space") -> Space:
    """A space from what its file would say; relative names start from `folder`. Raises as load_space."""
    try:
        told = SpaceFile.model_validate(table)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(step) for step in first["loc"]) if first["type"] == "value_error" else ""
        raise SpaceError(f"{called}: {where}{' ' if where else ''}{tables.sentence(error, EXAMPLE)}") from None
    try:
        space = Space(told, folder, *(_read(told, folder)))
        _check(space)
    except SpaceError as error:
        raise SpaceError(f"{called}: {error}") from None
    return space


def _read(told: SpaceFile, folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    def beside(name: str) -> str:
        return str(folder / name) if name.endswith(".toml") else name

    vehicle, scenario = beside(told.vehicle), beside(told.scenario)
    load_vehicle(vehicle)
    load_scenario(scenario)
    return vehicle_table(vehicle), scenario_table(scenario)


def _check(space: Space) -> None:
    """Everything that can be said before flying."""
    told = space.told
    if not space.mission.is_file():
        raise SpaceError(f"mission {space.mission} is not there; give its path from the space's folder")
    nominal = space.nominal
    for key, axis in space.axes.items():
        for value in axis.extremes:
            try:
                setup = space.setup({key: value})
            except SpaceError as error:
                raise SpaceError(f"vary {key} = {value}: {_without(str(error), key)}") from None
            if told.fidelity == "sitl" and not setup.link.is_ideal:
                raise SpaceError(f"vary {key}: fidelity sitl has a link without delay or loss; fly it closed-loop")
        if key.startswith("plan.") and nominal.plan.once:
            raise SpaceError(f"vary {key}: the mission is planned once; say plan.once = false")
    if told.fidelity == "sitl" and not nominal.link.is_ideal:
        raise SpaceError("link: fidelity sitl has a link without delay or loss; fly it closed-loop")
    loose = next((key for key, axis in space.axes.items() if axis.levels is None), None)
    if told.sampling == "grid" and loose:
        raise SpaceError(f"sampling grid wants axes with grid or choice, which {loose} is not; take sobol or random")
    if told.sampling in ("sobol", "lhs", "saltelli", "grid") and not space.axes:
        raise SpaceError(f'sampling {told.sampling}, but nothing varies; say sampling = "random" (seeds alone differ)')


def _without(sentence: str, key: str) -> str:
    return sentence.removeprefix(f"{key}: ")

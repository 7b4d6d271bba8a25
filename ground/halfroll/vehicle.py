"""The vehicle: mass, inertia, rotors, and what differs in its autopilot's parameters.

Why: `vehicles/*.toml` is the only place of these numbers; the planner, the simulator and the firmware all get them
from here, checked once.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from halfroll.errors import VehicleError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

GRAVITY = 9.81  # [m/s²], as firmware/core/constants.hpp

_FOLDER = Path(__file__).with_name("vehicles")
_ROTOR_KINDS = {"variable-pitch": 0.0, "fixed-pitch": 1.0}  # enumerators of firmware/core/vehicle.hpp

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
ParameterName = Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9_]{0,15}$")]  # a MAVLink parameter id


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Rotor(_Table):
    """One of four equal rotors in plus layout. Thrust is signed, positive along the body's +z."""

    kind: Literal["variable-pitch", "fixed-pitch"]
    thrust_min_N: float
    thrust_max_N: Positive
    delay_s: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0
    lag_s: Annotated[float, Field(gt=0.0, le=2.0)]  # of thrust (variable pitch) or of motor speed, rising (fixed pitch)
    lag_down_s: Annotated[float, Field(gt=0.0, le=2.0)]  # fixed pitch: of motor speed, falling
    slew_N_s: Positive


class Vehicle(_Table):
    """What a vehicle file says; frozen. Raises pydantic.ValidationError: `load_vehicle` turns it into VehicleError."""

    name: Annotated[str, Field(min_length=1)]
    description: str = ""
    mass_kg: Annotated[float, Field(gt=0.0, le=1000.0)]
    inertia_kg_m2: tuple[Positive, Positive, Positive]  # principal, body axes
    arm_m: Annotated[float, Field(gt=0.0, le=10.0)]
    yaw_coefficient_m: Annotated[float, Field(gt=0.0, le=1.0)]  # rotor torque per thrust
    drag_N_s_m: NonNegative = 0.0
    speed_max_m_s: Positive
    body_rate_max_rad_s: Positive
    rotor: Rotor
    params: dict[ParameterName, float] = {}  # autopilot parameters that differ from the firmware's defaults

    @property
    def weight(self) -> float:
        """[N]"""
        return self.mass_kg * GRAVITY

    @property
    def variable_pitch(self) -> bool:
        return self.rotor.kind == "variable-pitch"

    @model_validator(mode="after")
    def _can_fly(self) -> Vehicle:
        rotor, (jx, jy, jz) = self.rotor, self.inertia_kg_m2
        if rotor.thrust_min_N >= rotor.thrust_max_N:
            raise ValueError(
                f"rotor.thrust_min_N {rotor.thrust_min_N:g} is not below thrust_max_N {rotor.thrust_max_N:g}"
            )
        if not self.variable_pitch and rotor.thrust_min_N < 0.0:
            raise ValueError(
                f"rotor.thrust_min_N is {rotor.thrust_min_N:g}, but a fixed-pitch rotor cannot push down: "
                'give 0 or more, or kind = "variable-pitch"'
            )
        if 4.0 * rotor.thrust_max_N <= self.weight:
            raise ValueError(
                f"it cannot hover: 4 rotors give at most {4.0 * rotor.thrust_max_N:.1f} N, the weight is "
                f"{self.weight:.1f} N; lower mass_kg or raise rotor.thrust_max_N"
            )
        if 4.0 * rotor.thrust_min_N >= self.weight:
            raise ValueError(
                f"it cannot hover: 4 rotors give at least {4.0 * rotor.thrust_min_N:.1f} N, the weight is "
                f"{self.weight:.1f} N; lower rotor.thrust_min_N"
            )
        if max(jx, jy, jz) > (jx + jy + jz) / 2.0 * (1.0 + 1e-9):
            raise ValueError(f"inertia_kg_m2 {[jx, jy, jz]}: no body has one moment larger than the sum of the others")
        return self

    def numbers(self) -> dict[str, float]:
        """Every number by its dotted key ("rotor.thrust_max_N", "inertia_kg_m2.0", "params.ATT_WN"), as
        `halfroll-sitl --set` takes them; rotor.kind is 0 for variable pitch, 1 for fixed."""
        return dict(_numbers(self.model_dump(), ""))


def _numbers(table: Mapping[str, Any], prefix: str) -> list[tuple[str, float]]:
    found: list[tuple[str, float]] = []
    for key, entry in table.items():
        path = prefix + key
        if isinstance(entry, Mapping):
            found += _numbers(entry, path + ".")
        elif isinstance(entry, (list, tuple)):
            found += [(f"{path}.{i}", float(number)) for i, number in enumerate(entry)]
        elif path == "rotor.kind":
            found.append((path, _ROTOR_KINDS[entry]))
        elif isinstance(entry, (int, float)):
            found.append((path, float(entry)))
    return found


def shipped_vehicles() -> list[str]:
    """Names of the vehicles that come with halfroll, sorted."""
    return sorted(file.stem for file in _FOLDER.glob("*.toml"))


def load_vehicle(name_or_path: str | Path, overrides: Mapping[str, str | float] | None = None) -> Vehicle:
    """A shipped vehicle by name, or any .toml file, with numbers changed by dotted key.

    Raises VehicleError, which names the key, the value, the limit and the way out.
    """
    table = _read(name_or_path)
    for key, entry in (overrides or {}).items():
        _override(table, key, entry)
    try:
        return Vehicle.model_validate(table)
    except ValidationError as error:
        raise VehicleError(f"vehicle {table.get('name', name_or_path)}: {_sentence(error)}") from None


def built_vehicle(vehicle: Vehicle | str | Path, overrides: Mapping[str, str | float] | None = None) -> Vehicle:
    """`vehicle` itself, or as load_vehicle reads it. Raises VehicleError, also for overrides of one that is built."""
    if not isinstance(vehicle, Vehicle):
        return load_vehicle(vehicle, overrides)
    if overrides:
        raise VehicleError(
            "overrides change a vehicle named or read from a file; a Vehicle that is built stays as it is"
        )
    return vehicle


def _read(name_or_path: str | Path) -> dict[str, Any]:
    file = Path(name_or_path)
    if file.suffix != ".toml":
        file = _FOLDER / f"{name_or_path}.toml"
        if str(name_or_path) not in shipped_vehicles():
            known = ", ".join(shipped_vehicles())
            raise VehicleError(
                f"no vehicle is called {name_or_path!s}; shipped are {known}; or give the path of a .toml file"
            )
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise VehicleError(f"vehicle file {file}: {error.strerror or error}; check the path") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise VehicleError(f"vehicle file {file} is not TOML: {error}") from None


def _override(table: dict[str, Any], key: str, entry: str | float) -> None:
    *path, last = key.split(".")
    inner: Any = table
    for step in path:
        inner = inner.get(step) if isinstance(inner, dict) else None
        if inner is None and step == "params":
            inner = table.setdefault("params", {})
    new: str | float = _number_or_text(entry)
    if isinstance(inner, list) and last.isdigit() and int(last) < len(inner):
        inner[int(last)] = new
    elif isinstance(inner, dict) and not isinstance(inner.get(last), (dict, list)):
        inner[last] = new  # a wrong name is refused by the model, with the names it knows
    else:
        raise VehicleError(
            f"vehicle has no number called {key}; keys are dotted, like rotor.thrust_max_N or inertia_kg_m2.0"
        )


def _number_or_text(entry: str | float) -> str | float:
    try:
        return float(entry)
    except ValueError:
        return entry


def _sentence(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    key = ".".join(str(step) for step in first["loc"])
    if first["type"] == "value_error":  # our own words
        return str(first["ctx"]["error"])
    if first["type"] == "missing":
        return f"{key} is missing; add it to the file"
    if first["type"] == "extra_forbidden":
        return f"{key} is not a known key; check its spelling (vehicles/mit-vp.toml has them all)"
    return f"{key} is {first['input']!r}: {first['msg'][0].lower()}{first['msg'][1:]}"

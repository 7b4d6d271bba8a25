"""The vehicle: mass, inertia, rotors, and what differs in its autopilot's parameters.

Why: `vehicles/*.toml` is the only place of these numbers; the planner, the simulator and the firmware all get them
from here, checked once.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from halfroll import tables
from halfroll.errors import VehicleError
from halfroll.tables import Table

GRAVITY = 9.81  # [m/s²], as firmware/core/constants.hpp

_FOLDER = Path(__file__).with_name("vehicles")
_ROTOR_KINDS = {"variable-pitch": 0.0, "fixed-pitch": 1.0}  # enumerators of firmware/core/vehicle.hpp

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
ParameterName = Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9_]{0,15}$")]  # a MAVLink parameter id


class Rotor(Table):
    """One of four equal rotors in plus layout. Thrust is signed, positive along the body's +z. What has a default of 0
    is known to the simulator alone, and acts in scenarios that switch it on (docs/world.md)."""

    kind: Literal["variable-pitch", "fixed-pitch"]
    thrust_min_N: float
    thrust_max_N: Positive
    delay_s: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0
    lag_s: Annotated[float, Field(gt=0.0, le=2.0)]  # of thrust (variable pitch) or of motor speed, rising (fixed pitch)
    lag_down_s: Annotated[float, Field(gt=0.0, le=2.0)]  # fixed pitch: of motor speed, falling
    slew_N_s: Positive
    stiction_N: NonNegative = 0.0  # a blade at rest stays until it is off by this
    radius_m: NonNegative = 0.0
    inertia_kg_m2: NonNegative = 0.0  # about its axis
    speed_rad_s: NonNegative = 0.0  # governed (variable pitch), at thrust_max_N (fixed pitch)
    inflow_N_s_m: NonNegative = 0.0  # thrust lost per speed of the air along the axis
    drag_N_s_m: NonNegative = 0.0  # force per speed of the air across the axis
    profile_torque_N_m: NonNegative = 0.0  # drag torque without thrust
    figure_of_merit: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0  # ideal over electrical power in hover
    governor_droop: Annotated[float, Field(ge=0.0, le=0.5)] = 0.0  # share of speed lost at full thrust
    governor_lag_s: NonNegative = 0.05
    governor_headroom: Annotated[float, Field(ge=0.0, le=0.9)] = 0.15  # of full voltage, before speed falls


class Battery(Table):
    """Open-circuit voltages, and what is between them and the motors. 0 V: none is modelled."""

    full_V: NonNegative = 0.0
    empty_V: NonNegative = 0.0
    capacity_Ah: Positive = 1.0
    resistance_ohm: NonNegative = 0.0


class Vehicle(Table):
    """What a vehicle file says; frozen. Raises pydantic.ValidationError: `load_vehicle` turns it into VehicleError."""

    name: Annotated[str, Field(min_length=1)]
    description: str = ""
    mass_kg: Annotated[float, Field(gt=0.0, le=1000.0)]
    inertia_kg_m2: tuple[Positive, Positive, Positive]  # principal, body axes
    arm_m: Annotated[float, Field(gt=0.0, le=10.0)]
    yaw_coefficient_m: Annotated[float, Field(gt=0.0, le=1.0)]  # rotor torque per thrust
    drag_N_s_m: NonNegative = 0.0  # per airspeed; the autopilot knows it
    drag_N_s2_m2: NonNegative = 0.0  # per airspeed squared; it does not
    speed_max_m_s: Positive
    body_rate_max_rad_s: Positive
    rotor: Rotor
    battery: Battery = Battery()
    params: dict[ParameterName, float] = Field(default_factory=dict)  # autopilot parameters that differ

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
        return dict(tables.numbers(self.model_dump(), _ROTOR_KINDS))


def shipped_vehicles() -> list[str]:
    """Names of the vehicles that come with halfroll, sorted."""
    return tables.shipped(_FOLDER)


def vehicle_table(name_or_path: str | Path) -> dict[str, Any]:
    """What the file of a vehicle says, with what it is like filled in; unchecked. Raises VehicleError."""
    return tables.read(name_or_path, _FOLDER, "vehicle", VehicleError)


def load_vehicle(name_or_path: str | Path, overrides: Mapping[str, str | float] | None = None) -> Vehicle:
    """A shipped vehicle by name, or any .toml file, with numbers changed by dotted key.

    Raises VehicleError, which names the key, the value, the limit and the way out.
    """
    table = vehicle_table(name_or_path)
    for key, entry in (overrides or {}).items():
        unknown = VehicleError(
            f"vehicle has no number called {key}; keys are dotted, like rotor.thrust_max_N or inertia_kg_m2.0"
        )
        tables.override(table, key, entry, unknown, ("params", "battery"))
    try:
        return Vehicle.model_validate(table)
    except ValidationError as error:
        what = tables.sentence(error, "vehicles/mit-vp.toml")
        raise VehicleError(f"vehicle {table.get('name', name_or_path)}: {what}") from None


def built_vehicle(vehicle: Vehicle | str | Path, overrides: Mapping[str, str | float] | None = None) -> Vehicle:
    """`vehicle` itself, or as load_vehicle reads it. Raises VehicleError, also for overrides of one that is built."""
    if not isinstance(vehicle, Vehicle):
        return load_vehicle(vehicle, overrides)
    if overrides:
        raise VehicleError(
            "overrides change a vehicle named or read from a file; a Vehicle that is built stays as it is"
        )
    return vehicle

"""The scenario: in what air, with which sensors, loads and faults a vehicle is simulated.

Why: `scenarios/*.toml` are the only place of these numbers; a flight names one, or a file of the user's own, and the
simulator gets it checked. docs/world.md says what each number does.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from halfroll import tables
from halfroll.errors import ScenarioError
from halfroll.tables import Table

_FOLDER = Path(__file__).with_name("scenarios")
_FAULTS = {  # enumerators of sim/scenario.hpp
    "weak-rotor": 1.0,
    "stuck-rotor": 2.0,
    "dead-rotor": 3.0,
    "mocap-lost": 4.0,
    "mocap-frozen": 5.0,
    "gps-lost": 6.0,
}

Deviation = Annotated[float, Field(ge=0.0, le=1000.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Rate = Annotated[float, Field(ge=0.0, le=1000.0)]  # 0: there is no such sensor
Metres = Annotated[float, Field(ge=0.0, le=100.0)]
Degrees = Annotated[float, Field(ge=0.0, le=30.0)]
Instant = Annotated[float, Field(ge=0.0, le=1e6)]
Wind = Annotated[float, Field(ge=-50.0, le=50.0)]


class Effects(Table):
    """Which effects of the vehicle are on; each needs its numbers in the vehicle file."""

    drag: bool = False
    rotor_drag: bool = False
    inflow: bool = False
    gyroscopic: bool = False
    ground_effect: bool = False
    governor: bool = False
    stiction: bool = False
    battery: bool = False
    physical_torque: bool = False


class Payload(Table):
    """A point mass on the vehicle that the autopilot does not know of; body axes, from the vehicle's centre of mass."""

    mass_kg: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Gust(Table):
    at_s: Instant
    rise_s: Annotated[float, Field(ge=0.001, le=1000.0)] = 1.0
    hold_s: Instant = 0.0
    velocity_m_s: tuple[Wind, Wind, Wind]


class Air(Table):
    """Where the air goes, north-west-up, and Dryden turbulence along the mean, across it and vertically."""

    mean_m_s: tuple[Wind, Wind, Wind] = (0.0, 0.0, 0.0)
    turbulence_m_s: tuple[Deviation, Deviation, Deviation] = (0.0, 0.0, 0.0)
    turbulence_length_m: tuple[float, float, float] = (100.0, 100.0, 100.0)
    turbulence_speed_m_s: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0  # 0: the mean's
    gust: Annotated[tuple[Gust, ...], Field(max_length=4)] = ()


class Gyro(Table):
    noise_rad_s: Deviation = 0.0
    bias_rad_s: Deviation = 0.0
    bias_walk_rad_s2: Deviation = 0.0  # per square root of a second
    range_rad_s: Deviation = 0.0  # 0: no limit
    step_rad_s: Deviation = 0.0
    vibration_rad_s: Deviation = 0.0


class Accelerometer(Table):
    noise_m_s2: Deviation = 0.0
    bias_m_s2: Deviation = 0.0
    bias_walk_m_s3: Deviation = 0.0
    range_m_s2: Deviation = 0.0
    step_m_s2: Deviation = 0.0
    vibration_m_s2: Deviation = 0.0


class Mocap(Table):
    rate_hz: Rate = 100.0
    delay_s: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0
    jitter_s: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0
    position_noise_m: Metres = 0.0
    attitude_noise_deg: Degrees = 0.0
    attitude_wander_deg: Degrees = 0.0
    wander_time_s: Annotated[float, Field(ge=0.01, le=1e4)] = 0.5
    dropout: Share = 0.0
    outlier: Share = 0.0
    outlier_size: Metres = 1.0


class Gps(Table):
    rate_hz: Annotated[float, Field(ge=0.0, le=50.0)] = 0.0
    delay_s: Annotated[float, Field(ge=0.0, le=0.2)] = 0.0
    noise_xy_m: Metres = 0.0
    noise_z_m: Metres = 0.0
    wander_xy_m: Metres = 0.0
    wander_z_m: Metres = 0.0
    wander_time_s: Annotated[float, Field(ge=0.1, le=1e5)] = 60.0
    velocity_noise_m_s: Metres = 0.0


class Barometer(Table):
    rate_hz: Rate = 0.0
    noise_m: Metres = 0.0
    drift_m_s: Metres = 0.0  # per square root of a second


class Magnetometer(Table):
    rate_hz: Rate = 0.0
    noise: Share = 0.0  # of the field
    bias: Share = 0.0


class Fault(Table):
    """What goes wrong between at_s and until_s; rotor 1 to 4 for faults of one, share of thrust that a weak one has."""

    kind: Literal["weak-rotor", "stuck-rotor", "dead-rotor", "mocap-lost", "mocap-frozen", "gps-lost"]
    at_s: Instant
    until_s: Instant = 1e6
    rotor: Annotated[int, Field(ge=1, le=4)] = 1
    share: Annotated[float, Field(ge=0.0, le=2.0)] = 1.0

    @model_validator(mode="after")
    def _ends(self) -> Fault:
        if self.until_s <= self.at_s:
            raise ValueError(f"fault {self.kind} ends at {self.until_s:g} s, not after it begins at {self.at_s:g} s")
        return self


class Scenario(Table):
    """What a scenario file says; frozen. A vehicle and a seed are what a flight uses that names none itself."""

    name: str = ""  # default: the file's
    description: str = ""
    vehicle: str | None = None
    seed: Annotated[int, Field(ge=0)] | None = None
    effects: Effects = Effects()
    payload: Payload = Payload()
    wind: Air = Air()
    gyro: Gyro = Gyro()
    accelerometer: Accelerometer = Accelerometer()
    mocap: Mocap = Mocap()
    gps: Gps = Gps()
    barometer: Barometer = Barometer()
    magnetometer: Magnetometer = Magnetometer()
    fault: Annotated[tuple[Fault, ...], Field(max_length=8)] = ()

    @model_validator(mode="after")
    def _delivers(self) -> Scenario:
        mocap = self.mocap
        if mocap.rate_hz > 0.0 and (mocap.delay_s + mocap.jitter_s) * mocap.rate_hz > 16.0:
            raise ValueError("mocap.delay_s and jitter_s are more than 16 periods of its rate_hz")
        return self

    def numbers(self) -> dict[str, float]:
        """Every number by its dotted key ("wind.mean_m_s.0", "fault.0.kind"), as `halfroll-sitl --scenario-set` takes
        them."""
        told = self.model_dump(exclude={"name", "description", "vehicle", "seed"})
        return dict(tables.numbers(told, _FAULTS))


def shipped_scenarios() -> list[str]:
    """Names of the scenarios that come with halfroll, sorted."""
    return tables.shipped(_FOLDER)


def scenario_table(name_or_path: str | Path) -> dict[str, Any]:
    """What the file of a scenario says, with what it is like and what it leaves out filled in; unchecked. Raises
    ScenarioError."""
    left_out = Scenario(name="").model_dump(mode="json", exclude={"name", "description", "vehicle", "seed"})
    return tables.merged(left_out, tables.read(name_or_path, _FOLDER, "scenario", ScenarioError))


def load_scenario(name_or_path: str | Path, overrides: Mapping[str, str | float] | None = None) -> Scenario:
    """A shipped scenario by name, or any .toml file, with numbers changed by dotted key.

    Raises ScenarioError, which names the key, the value, the limit and the way out.
    """
    table = scenario_table(name_or_path)
    for key, entry in (overrides or {}).items():
        unknown = ScenarioError(
            f"scenario has no number called {key}; keys are dotted, like mocap.delay_s or wind.mean_m_s.0"
        )
        tables.override(table, key, entry, unknown, tuple(Scenario.model_fields))
    table.setdefault("name", Path(name_or_path).stem)
    try:
        return Scenario.model_validate(table)
    except ValidationError as error:
        raise ScenarioError(f"scenario {name_or_path}: {tables.sentence(error, 'docs/world.md')}") from None

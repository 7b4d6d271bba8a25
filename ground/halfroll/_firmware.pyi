"""
The firmware and the simulated world, linked from the same libraries as halfroll-sitl.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['Aiding', 'Autopilot', 'Estimate', 'Estimator', 'FlatReference', 'OuterLoop', 'Outputs', 'ParamInfo', 'Params', 'Plant', 'PoseFix', 'RotorKind', 'Scenario', 'Setpoint', 'Vehicle', 'VehicleSetup', 'World', 'allocate', 'attitude_wrench', 'conjugate', 'failsafe_table', 'free_rotation', 'mission_item_table', 'mode_rule_table', 'mode_table', 'multiply', 'parameter_table', 'rotate', 'scenario_setup', 'serve_board', 'stream_table', 'understands', 'vehicle_setup']
class RotorKind:
    """
    Members:
    
      VARIABLE_PITCH
    
      FIXED_PITCH
    """
    FIXED_PITCH: typing.ClassVar[RotorKind]
    VARIABLE_PITCH: typing.ClassVar[RotorKind]
    __members__: typing.ClassVar[dict[str, RotorKind]]
    @typing.overload
    def __eq__(self, other: RotorKind) -> bool:
        ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> int:
        ...
    def __hash__(self) -> int:
        ...
    def __index__(self) -> int:
        ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def __int__(self) -> int:
        ...
    @typing.overload
    def __ne__(self, other: RotorKind) -> bool:
        ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def __str__(self) -> str:
        ...
    @property
    def name(self) -> str:
        ...
    @property
    def value(self) -> int:
        ...
class Vehicle:
    """
    What the firmware knows of the vehicle. SI; inertia (3,) about body axes.
    """
    rotor_kind: RotorKind
    def __init__(self) -> None:
        ...
    @property
    def arm(self) -> float:
        ...
    @arm.setter
    def arm(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def inertia(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @inertia.setter
    def inertia(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"]) -> None:
        ...
    @property
    def mass(self) -> float:
        ...
    @mass.setter
    def mass(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def rotor_lag(self) -> float:
        ...
    @rotor_lag.setter
    def rotor_lag(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def rotor_lag_down(self) -> float:
        ...
    @rotor_lag_down.setter
    def rotor_lag_down(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def thrust_max(self) -> float:
        ...
    @thrust_max.setter
    def thrust_max(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def thrust_min(self) -> float:
        ...
    @thrust_min.setter
    def thrust_min(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def yaw_coefficient(self) -> float:
        ...
    @yaw_coefficient.setter
    def yaw_coefficient(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
class FlatReference:
    """
    A point of a trajectory in W: (3,) vectors, SI; yaw in radians.
    """
    def __init__(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ..., acceleration: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ..., jerk: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ..., snap: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ..., yaw: typing.SupportsFloat | typing.SupportsIndex = 0.0, yaw_rate: typing.SupportsFloat | typing.SupportsIndex = 0.0, yaw_acceleration: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    @property
    def acceleration(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @acceleration.setter
    def acceleration(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"]) -> None:
        ...
    @property
    def position(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @position.setter
    def position(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"]) -> None:
        ...
    @property
    def velocity(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @velocity.setter
    def velocity(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"]) -> None:
        ...
    @property
    def yaw(self) -> float:
        ...
    @yaw.setter
    def yaw(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
class Setpoint:
    """
    Attitude, body rates and signed thrust [N] wanted at t_us.
    """
    @property
    def dw_WD_D(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def q_WD(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[4, 1]"]:
        ...
    @property
    def t_us(self) -> int:
        ...
    @property
    def thrust(self) -> float:
        ...
    @property
    def w_WD_D(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
class PoseFix:
    """
    A pose from outside, sampled at t_us.
    """
    def __init__(self, t_us: typing.SupportsInt | typing.SupportsIndex, p_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], q_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"], *, position_deviation: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ..., attitude_deviation: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ...) -> None:
        ...
    @property
    def p_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def q_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[4, 1]"]:
        ...
    @property
    def t_us(self) -> int:
        ...
class Aiding:
    """
    What keeps an estimate from drifting.
    
    Members:
    
      NONE
    
      POSE
    
      SATELLITES
    """
    NONE: typing.ClassVar[Aiding]
    POSE: typing.ClassVar[Aiding]
    SATELLITES: typing.ClassVar[Aiding]
    __members__: typing.ClassVar[dict[str, Aiding]]
    @typing.overload
    def __eq__(self, other: Aiding) -> bool:
        ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> int:
        ...
    def __hash__(self) -> int:
        ...
    def __index__(self) -> int:
        ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def __int__(self) -> int:
        ...
    @typing.overload
    def __ne__(self, other: Aiding) -> bool:
        ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def __str__(self) -> str:
        ...
    @property
    def name(self) -> str:
        ...
    @property
    def value(self) -> int:
        ...
class Estimate:
    """
    What the autopilot believes of its motion.
    """
    @property
    def aiding(self) -> Aiding:
        ...
    @property
    def attitude_deviation(self) -> float:
        ...
    @property
    def attitude_valid(self) -> bool:
        ...
    @property
    def p_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def position_deviation(self) -> float:
        ...
    @property
    def position_valid(self) -> bool:
        ...
    @property
    def q_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[4, 1]"]:
        ...
    @property
    def resets(self) -> int:
        ...
    @property
    def v_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def velocity_deviation(self) -> float:
        ...
    @property
    def w_WB_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
class ParamInfo:
    """
    One row of the parameter table.
    """
    @property
    def default(self) -> float:
        ...
    @property
    def flags(self) -> int:
        ...
    @property
    def id(self) -> str:
        ...
    @property
    def least(self) -> float:
        ...
    @property
    def meaning(self) -> str:
        ...
    @property
    def most(self) -> float:
        ...
    @property
    def unit(self) -> str:
        ...
class Params:
    """
    Current parameter values by MAVLink id.
    """
    def __getitem__(self, id: str) -> float:
        ...
    def __init__(self) -> None:
        ...
    def __setitem__(self, id: str, wanted: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    def copy(self) -> Params:
        ...
class OuterLoop:
    """
    Outer loop (Eqs 6-19), the one the firmware flies: call every 10 ms.
    """
    def __init__(self, vehicle: Vehicle, params: Params) -> None:
        ...
    def copy(self) -> OuterLoop:
        ...
    def reset(self, q_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"]) -> None:
        """
        Forget errors and chart; continue from this attitude.
        """
    def step(self, *, t_us: typing.SupportsInt | typing.SupportsIndex, q_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"], w_WB_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], p_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], v_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], at_sample: FlatReference, now: FlatReference, lead_acceleration: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ..., lead_rate: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"] = ..., mid_age: typing.SupportsFloat | typing.SupportsIndex = 0.0, sigma: typing.SupportsFloat | typing.SupportsIndex = 1.0, sigma_event_near: bool = False, on_ground: bool = False) -> Setpoint:
        """
        State (when sampled), the plan at the sample and now, and the plan's leads -> Setpoint.
        """
class Estimator:
    """
    The estimator of the firmware; its first step is at time 0.
    """
    def __init__(self, params: Params) -> None:
        ...
    def step(self, w_WB_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], specific_force_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], pose: PoseFix | None = None, *, flying: bool = True) -> Estimate:
        """
        Advance 1 ms: gyro [rad/s], accelerometer [m/s^2], perhaps a pose -> Estimate.
        """
    def step_many(self, imu: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], poses: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None, *, flying: bool = True) -> numpy.typing.NDArray[numpy.float32]:
        """
        N steps: imu (N, 6), poses (N, 7) or None (NaN rows: none) -> positions (N, 3) [m].
        """
    @property
    def accelerometer_bias(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def covariance(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[15, 15]"]:
        """
        (15, 15) of attitude error in W, velocity, position, gyro bias, accelerometer bias; every 10 ms and when a measurement has been taken in it is that of now.
        """
    @property
    def gyro_bias(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def rejected(self) -> int:
        ...
    @property
    def used(self) -> int:
        ...
class Plant:
    """
    The simulated vehicle, SI.
    """
    ideal_rotors: bool
    @property
    def arm(self) -> float:
        ...
    @arm.setter
    def arm(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def gravity(self) -> float:
        ...
    @gravity.setter
    def gravity(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def inertia(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        ...
    @inertia.setter
    def inertia(self, arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"]) -> None:
        ...
    @property
    def mass(self) -> float:
        ...
    @mass.setter
    def mass(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def thrust_max(self) -> float:
        ...
    @thrust_max.setter
    def thrust_max(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
    @property
    def thrust_min(self) -> float:
        ...
    @thrust_min.setter
    def thrust_min(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
class Scenario:
    """
    Air, sensors, loads and faults of a world.
    """
class World:
    """
    The simulated world (double precision): rotors, air, rigid body, ground, sensors.
    """
    @staticmethod
    def run_batch(autopilots: collections.abc.Sequence[Autopilot], worlds: collections.abc.Sequence[World], steps: typing.SupportsInt | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        """
        Fly each autopilot in the world beside it for so many milliseconds, in parallel (threads 0: one a core) and without the GIL. The bits are those of Autopilot.fly.
        """
    @typing.overload
    def __init__(self, plant: Plant, scenario: str = 'nominal', seed: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
    @typing.overload
    def __init__(self, plant: Plant, scenario: Scenario, seed: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
    def copy(self) -> World:
        """
        A snapshot: flies the same future.
        """
    def place(self, p_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"], v_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"], q_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[4, 1]"], w_WB_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"], thrust: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"]) -> None:
        """
        Start again at time 0 from this state, rotors settled at these thrusts; the seed stays.
        """
    def restore(self, snapshot: World) -> None:
        """
        Be again what was copied.
        """
    def same_state(self, other: World) -> bool:
        ...
    def step(self, thrust: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(4)"]) -> None:
        """
        Advance 1 ms under four rotor commands [N].
        """
    def step_many(self, thrusts: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float64]:
        """
        thrusts (N, 4) -> truth (N, 13): p, v, q [w, x, y, z], w after each millisecond.
        """
    def turn_to(self, q_WD: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"], thrust: typing.SupportsFloat | typing.SupportsIndex, vehicle: Vehicle, params: Params, steps: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        The attitude loop alone, on the true state: turn to q_WD under a thrust [N]; truth (N, 13) as step_many.
        """
    @property
    def accelerometer(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def battery_V(self) -> float:
        ...
    @property
    def battery_charge(self) -> float:
        ...
    @property
    def crashed(self) -> bool:
        ...
    @property
    def gyro(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
        ...
    @property
    def p_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        ...
    @property
    def pose(self) -> PoseFix | None:
        ...
    @property
    def q_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"]:
        ...
    @property
    def rotor_thrust(self) -> typing.Annotated[list[float], "FixedSize(4)"]:
        ...
    @property
    def t_us(self) -> int:
        ...
    @property
    def v_WB(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        ...
    @property
    def w_WB_B(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        ...
    @property
    def wind_W(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]:
        ...
class VehicleSetup:
    """
    A vehicle as firmware, world and parameters see it.
    """
    @property
    def name(self) -> str:
        ...
    @property
    def params(self) -> Params:
        ...
    @property
    def plant(self) -> Plant:
        ...
    @property
    def vehicle(self) -> Vehicle:
        ...
class Outputs:
    """
    Rotor commands (4,) [N], and frames to send as (link, slot, bytes).
    """
    @property
    def thrust(self) -> typing.Annotated[list[float], "FixedSize(4)"]:
        ...
    @property
    def tx(self) -> list[tuple[int, int, bytes]]:
        ...
class Autopilot:
    """
    The firmware itself, the same library as halfroll-sitl.
    """
    def __init__(self, vehicle: Vehicle, params: Params, *, px4_identity: bool = False, simulation_speed: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> None:
        ...
    def copy(self) -> Autopilot:
        """
        A snapshot: with a World's it flies the same future.
        """
    def fly(self, world: World, steps: typing.SupportsInt | typing.SupportsIndex) -> None:
        """
        N milliseconds of closed loop with a World; the links hear nothing meanwhile.
        """
    def restore(self, snapshot: Autopilot) -> None:
        """
        Be again what was copied.
        """
    def same_state(self, other: Autopilot) -> bool:
        ...
    def service(self, rx: bytes, link: typing.SupportsInt | typing.SupportsIndex = 0, slot: typing.SupportsInt | typing.SupportsIndex = 0, wall_us: typing.SupportsInt | typing.SupportsIndex = 0) -> list[tuple[int, int, bytes]]:
        """
        Answer the link while no time passes; frames as (link, slot, bytes).
        """
    def step(self, w_WB_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], specific_force_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], pose: PoseFix | None = None, *, rx: bytes = b'', link: typing.SupportsInt | typing.SupportsIndex = 0, slot: typing.SupportsInt | typing.SupportsIndex = 0, wall_us: typing.SupportsInt | typing.SupportsIndex = 0, state_of_charge: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> Outputs:
        """
        Advance 1 ms: sensors and received bytes in, Outputs out.
        """
    def step_many(self, imu: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], poses: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None) -> numpy.typing.NDArray[numpy.float32]:
        """
        N steps: imu (N, 6) [rad/s, m/s^2], poses (N, 7) or None (NaN rows: none) -> rotor thrusts (N, 4) [N].
        """
    @property
    def armed(self) -> bool:
        ...
    @property
    def broken_invariant(self) -> str:
        """
        What does not hold that must after every step, in words, or None.
        """
    @property
    def estimate(self) -> Estimate:
        ...
    @property
    def mode(self) -> str:
        ...
    @property
    def on_ground(self) -> bool:
        ...
    @property
    def params(self) -> Params:
        ...
    @property
    def state_checksum(self) -> int:
        """
        One number of all that it remembers: equal states have equal ones, on any processor.
        """
    @property
    def storage_works(self) -> bool:
        """
        Whether the writes that it asks for succeed.
        """
    @storage_works.setter
    def storage_works(self, arg0: bool) -> None:
        ...
    @property
    def t_us(self) -> int:
        ...
def allocate(thrust: typing.SupportsFloat | typing.SupportsIndex, torque: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], vehicle: Vehicle) -> tuple[typing.Annotated[list[float], "FixedSize(4)"], typing.Annotated[list[bool], "FixedSize(3)"]]:
    """
    Four rotor thrusts inside the limits, and which of (roll/pitch torque, thrust, yaw torque) was cut.
    """
def attitude_wrench(q_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"], w_WB_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], q_WD: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"], w_WD_D: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], dw_WD_D: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"], thrust: typing.SupportsFloat | typing.SupportsIndex, vehicle: Vehicle, params: Params) -> tuple[float, typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]]:
    """
    Attitude law (Eq 22, corrected): (thrust [N], torque (3,) [N m]).
    """
def conjugate(q: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"]) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[4, 1]"]:
    ...
def failsafe_table() -> list[dict[str, typing.Any]]:
    """
    words, condition, action, recovery.
    """
def free_rotation(inertia: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"], q_WB: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[4, 1]"], w_WB_B: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"], h: typing.SupportsFloat | typing.SupportsIndex, steps: typing.SupportsInt | typing.SupportsIndex) -> tuple[typing.Annotated[numpy.typing.NDArray[numpy.float64], "[4, 1]"], typing.Annotated[numpy.typing.NDArray[numpy.float64], "[3, 1]"]]:
    """
    The world's integrator on a body that nothing pushes: (q, w) after so many steps of h seconds.
    """
def mission_item_table() -> list[dict[str, typing.Any]]:
    """
    Commands a mission may hold; params as (least, most, NaN allowed, step).
    """
def mode_rule_table() -> list[dict[str, typing.Any]]:
    """
    Why a change of mode is refused: who, from, to, when, why; first match counts.
    """
def mode_table() -> list[dict[str, typing.Any]]:
    """
    Modes as the wire numbers them.
    """
def multiply(a: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"], b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"]) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[4, 1]"]:
    """
    Hamilton product of two quaternions (4,), [w, x, y, z].
    """
def parameter_table() -> list[ParamInfo]:
    """
    All parameters in MAVLink index order.
    """
def rotate(q: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[4, 1]"], v: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[3, 1]"]) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[3, 1]"]:
    """
    R(q) v: body components to world for q_WB.
    """
def scenario_setup(name: str = 'nominal', settings: collections.abc.Sequence[str] = []) -> Scenario:
    """
    A shipped scenario with settings like 'wind.mean_m_s.0=3' over it. ValueError says what is wrong.
    """
def serve_board(in_fd: typing.SupportsInt | typing.SupportsIndex, out_fd: typing.SupportsInt | typing.SupportsIndex, storage: str = '') -> None:
    """
    Fly as the board of a halfroll-sitl --board: its frames come and go by two file descriptors, until the other end is closed. storage: directory of what outlives the process.
    """
def stream_table() -> list[dict[str, typing.Any]]:
    """
    Message ids and their rates on each link.
    """
def understands(frame: bytes) -> bool:
    """
    Whether this MAVLink frame says anything to the autopilot.
    """
def vehicle_setup(name: str = 'mit-vp', settings: collections.abc.Sequence[str] = []) -> VehicleSetup:
    """
    A shipped vehicle with settings like 'rotor.thrust_max_N=2.5' over it. ValueError says what is wrong.
    """

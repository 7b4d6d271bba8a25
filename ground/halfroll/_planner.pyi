"""
The planner's kernel: least time inside the limits, repair between samples, and the proof.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['Certificate', 'Constraints', 'Limits', 'Problem', 'Tightening', 'Vehicle', 'bound_name', 'certify', 'minimise_time', 'rotor_range', 'tighten_around_peaks']
class Vehicle:
    """
    What thrust depends on; SI, inertia (3,) about body axes.
    """
    def __init__(self, *, mass: typing.SupportsFloat | typing.SupportsIndex, inertia: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], arm: typing.SupportsFloat | typing.SupportsIndex, yaw_coefficient: typing.SupportsFloat | typing.SupportsIndex, gravity: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
class Limits:
    """
    Infinite: switched off. SI; see halfroll.limits.Limits.
    """
    def __init__(self, *, rotor_min: typing.SupportsFloat | typing.SupportsIndex, rotor_max: typing.SupportsFloat | typing.SupportsIndex, force_min: typing.SupportsFloat | typing.SupportsIndex = ..., force_z_min: typing.SupportsFloat | typing.SupportsIndex = ..., body_rate_max: typing.SupportsFloat | typing.SupportsIndex = ..., floor: typing.SupportsFloat | typing.SupportsIndex = ..., vertical: bool = False) -> None:
        ...
class Constraints:
    """
    The rows that a vehicle and its limits make.
    """
    def __init__(self, vehicle: Vehicle, limits: Limits, any_speed_limit: bool) -> None:
        ...
class Problem:
    """
    A trajectory to improve: N pieces, nodes (N+1, 5, 4) derivatives 0..4 of x, y, z, yaw.
    """
    def __init__(self, nodes: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], durations: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], given: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], leg: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], speed_max: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], frozen: typing.Annotated[collections.abc.Sequence[bool], "FixedSize(4)"], tied: bool) -> None:
        """
        given (N+1, 5, 4): what is not free; leg and speed_max (N,) of each piece; frozen (4,): axes that stand still.
        """
    def least_margin(self, constraints: Constraints, samples: typing.SupportsInt | typing.SupportsIndex) -> float:
        """
        Relative, the most negative of all limits; samples of each piece.
        """
    def split(self, parts: typing.SupportsInt | typing.SupportsIndex) -> Problem:
        """
        Each piece cut into equal ones; the path does not change.
        """
    def stretched(self, factor: typing.SupportsFloat | typing.SupportsIndex) -> Problem:
        ...
    @property
    def coefficients(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (N, 10, 4)
        """
    @property
    def durations(self) -> list[float]:
        ...
    @property
    def leg(self) -> list[int]:
        ...
    @property
    def nodes(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def speed_max(self) -> list[float]:
        ...
    @property
    def tied(self) -> bool:
        """
        Whether the pieces of a leg keep their shares of its time.
        """
    @tied.setter
    def tied(self, arg0: bool) -> None:
        ...
    @property
    def total(self) -> float:
        ...
class Tightening:
    """
    What repair has added to the limits.
    """
    def __init__(self) -> None:
        ...
class Certificate:
    """
    Whether all limits hold at every time, and where that could not be proven.
    """
    @property
    def bound(self) -> int:
        ...
    @property
    def excess(self) -> float:
        ...
    @property
    def intervals(self) -> int:
        ...
    @property
    def piece(self) -> int:
        ...
    @property
    def proven(self) -> bool:
        ...
    @property
    def unproven(self) -> list[int]:
        ...
def bound_name(constraints: Constraints, bound: typing.SupportsInt | typing.SupportsIndex) -> tuple[str, str]:
    """
    What a bound limits, in words, and its unit.
    """
def certify(coefficients: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], durations: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], speed_max: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], constraints: Constraints) -> Certificate:
    """
    Proof over whole pieces (N, 10, 4), lowest power of tau first.
    """
def minimise_time(problem: Problem, constraints: Constraints, tightening: Tightening, *, samples: typing.SupportsInt | typing.SupportsIndex, barrier_start: typing.SupportsFloat | typing.SupportsIndex, barrier_end: typing.SupportsFloat | typing.SupportsIndex, iterations: typing.SupportsInt | typing.SupportsIndex, duration_min: typing.SupportsFloat | typing.SupportsIndex, shift: typing.SupportsFloat | typing.SupportsIndex, curvature: typing.SupportsFloat | typing.SupportsIndex, progress: collections.abc.Callable[[float], bool]) -> tuple[Problem, bool, bool, int]:
    """
    (problem with the better trajectory, feasible at its samples, interrupted, iterations)
    """
def rotor_range(problem: Problem, constraints: Constraints, samples: typing.SupportsInt | typing.SupportsIndex) -> tuple[typing.Any, typing.Any]:
    """
    Smallest and largest thrust of each rotor [N].
    """
def tighten_around_peaks(problem: Problem, constraints: Constraints, samples: typing.SupportsInt | typing.SupportsIndex, spare: typing.SupportsFloat | typing.SupportsIndex, tightening: Tightening) -> float:
    """
    The least relative margin between the samples; tightening is raised where it is below spare.
    """

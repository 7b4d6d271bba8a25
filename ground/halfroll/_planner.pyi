"""
The planner's kernel: least time inside the limits, repair between samples, and the proof.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['Certificate', 'ClosedForm', 'Constraints', 'Drive', 'Heading', 'Limits', 'PieceLimits', 'Problem', 'Vehicle', 'bound_limit', 'bound_name', 'certify', 'certify_planar', 'closed_forms', 'minimise_time', 'rotor_range', 'rotor_slopes']
class Vehicle:
    """
    What thrust depends on; SI, inertia (3,) about body axes.
    """
    def __init__(self, *, mass: typing.SupportsFloat | typing.SupportsIndex, inertia: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], arm: typing.SupportsFloat | typing.SupportsIndex, yaw_coefficient: typing.SupportsFloat | typing.SupportsIndex, gravity: typing.SupportsFloat | typing.SupportsIndex) -> None:
        ...
class Drive:
    """
    How rotors follow their commands [N]; see halfroll.planner.limits.Drive.
    """
    def __init__(self, lag_up: typing.SupportsFloat | typing.SupportsIndex = 0.0, lag_down: typing.SupportsFloat | typing.SupportsIndex = 0.0, of_speed: bool = False, command_min: typing.SupportsFloat | typing.SupportsIndex = ..., command_max: typing.SupportsFloat | typing.SupportsIndex = ...) -> None:
        ...
class Heading:
    """
    Where the nose points, within an angle: along the path, or towards a point [m].
    """
    @staticmethod
    def path(cosine: typing.SupportsFloat | typing.SupportsIndex, slack: typing.SupportsFloat | typing.SupportsIndex) -> Heading:
        ...
    @staticmethod
    def towards(x: typing.SupportsFloat | typing.SupportsIndex, y: typing.SupportsFloat | typing.SupportsIndex, cosine: typing.SupportsFloat | typing.SupportsIndex, slack: typing.SupportsFloat | typing.SupportsIndex) -> Heading:
        ...
    def __init__(self) -> None:
        ...
class Limits:
    """
    Infinite: switched off. SI; see halfroll.planner.limits.Limits.
    """
    def __init__(self, *, rotor_min: typing.SupportsFloat | typing.SupportsIndex, rotor_max: typing.SupportsFloat | typing.SupportsIndex, force_min: typing.SupportsFloat | typing.SupportsIndex = ..., force_z_min: typing.SupportsFloat | typing.SupportsIndex = ..., body_rate_max: typing.SupportsFloat | typing.SupportsIndex = ..., floor: typing.SupportsFloat | typing.SupportsIndex = ..., vertical: bool = False, rotor_rate_max: typing.SupportsFloat | typing.SupportsIndex = ..., drive: Drive = ..., tilt_cos_min: typing.SupportsFloat | typing.SupportsIndex = ..., ceiling: typing.SupportsFloat | typing.SupportsIndex = ..., heading: Heading = ...) -> None:
        ...
class Constraints:
    """
    The rows that a vehicle and its limits make.
    """
    def __init__(self, vehicle: Vehicle, limits: Limits, any_speed_limit: bool, walls: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
class PieceLimits:
    """
    What differs from leg to leg: speed [m/s], and walls (x, y, offset) that are not crossed.
    """
    def __init__(self, speed_max: typing.SupportsFloat | typing.SupportsIndex = ..., walls: collections.abc.Sequence[typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]] = []) -> None:
        ...
    @property
    def speed_max(self) -> float:
        ...
    @property
    def walls(self) -> list[typing.Annotated[list[float], "FixedSize(3)"]]:
        ...
class Problem:
    """
    A trajectory to improve: N pieces, nodes (N+1, 5, 4) derivatives 0..4 of x, y, z, yaw.
    """
    def __init__(self, nodes: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], durations: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], given: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], leg: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], limits: collections.abc.Sequence[PieceLimits], frozen: typing.Annotated[collections.abc.Sequence[bool], "FixedSize(4)"], tied: bool, timed: collections.abc.Sequence[bool] = []) -> None:
        """
        given (N+1, 5, 4): what is not free; leg and limits (N,) of each piece; frozen (4,): axes that stand still; timed (N,): whose time is given.
        """
    def least_margin(self, constraints: Constraints, samples: typing.SupportsInt | typing.SupportsIndex) -> float:
        """
        Relative, the most negative of all limits; samples of each piece.
        """
    def part(self, first: typing.SupportsInt | typing.SupportsIndex, last: typing.SupportsInt | typing.SupportsIndex) -> Problem:
        """
        Pieces first..last-1 between nodes that are given whole.
        """
    def split(self, parts: typing.SupportsInt | typing.SupportsIndex) -> Problem:
        """
        Each piece cut into equal ones; the path does not change.
        """
    def stretched(self, factor: typing.SupportsFloat | typing.SupportsIndex) -> Problem:
        ...
    def with_part(self, first: typing.SupportsInt | typing.SupportsIndex, part: Problem) -> Problem:
        """
        With the flight of a part whose first piece is `first` here.
        """
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
    def limits(self) -> list[PieceLimits]:
        ...
    @property
    def nodes(self) -> numpy.typing.NDArray[numpy.float64]:
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
class ClosedForm:
    """
    The path through nodes in given times, and its exact slopes.   Eqs 23-24
    """
    def __init__(self, nodes: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], durations: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], continuity: typing.SupportsInt | typing.SupportsIndex = 8) -> None:
        """
        nodes (n, 5, 4): NaN where free; durations (n-1,) > 0.
        """
    def slopes(self, cost: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        (by durations (n-1,), by given derivatives (n, 5, 4)) from slopes over coefficients (n-1, 10, 4).
        """
    @property
    def bytes(self) -> int:
        """
        Of the eliminated equations.
        """
    @property
    def coefficients(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n-1, 10, 4), lowest power of tau first
        """
    @property
    def durations(self) -> numpy.typing.NDArray[numpy.float64]:
        ...
    @property
    def nodes(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n, 5, 4), all derivatives
        """
    @property
    def solved(self) -> bool:
        ...
    @property
    def stuck(self) -> int:
        """
        About which node what is given determines no path.
        """
def bound_limit(constraints: Constraints, bound: typing.SupportsInt | typing.SupportsIndex, piece: PieceLimits) -> float:
    """
    What a bound allows on a piece.
    """
def bound_name(constraints: Constraints, bound: typing.SupportsInt | typing.SupportsIndex) -> tuple[str, str]:
    """
    What a bound limits, in words, and its unit.
    """
def certify(coefficients: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], durations: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], limits: collections.abc.Sequence[PieceLimits], constraints: Constraints) -> Certificate:
    """
    Proof over whole pieces (N, 10, 4), lowest power of tau first.
    """
def certify_planar(coefficients: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], durations: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], signs: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], speed_max: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], vehicle: Vehicle, limits: Limits) -> Certificate:
    """
    Proof of flight that turns over in the x-z plane: pieces (N, 10, 4), the sign of the thrust and the speed limit of each.
    """
def closed_forms(nodes: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], durations: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    Coefficients (B, n-1, 10, 4) for B sets of durations (B, n-1); None if one has none.
    """
def minimise_time(problem: Problem, constraints: Constraints, *, samples: typing.SupportsInt | typing.SupportsIndex, gap_start: typing.SupportsFloat | typing.SupportsIndex, gap_end: typing.SupportsFloat | typing.SupportsIndex, gap_factor: typing.SupportsFloat | typing.SupportsIndex, negligible: typing.SupportsFloat | typing.SupportsIndex, iterations: typing.SupportsInt | typing.SupportsIndex, duration_min: typing.SupportsFloat | typing.SupportsIndex, shift: typing.SupportsFloat | typing.SupportsIndex, curvature: typing.SupportsFloat | typing.SupportsIndex, elastic: bool, spare: typing.SupportsFloat | typing.SupportsIndex, progress: collections.abc.Callable[[float], bool]) -> tuple[Problem, bool, bool, float]:
    """
    (problem with the better trajectory, feasible at its samples, interrupted, what a newton less of the least rotor thrust would save, to first order [s/N])
    """
def rotor_range(problem: Problem, constraints: Constraints, samples: typing.SupportsInt | typing.SupportsIndex) -> tuple[typing.Any, typing.Any]:
    """
    Smallest and largest thrust of each rotor [N].
    """
def rotor_slopes(flat: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], vehicle: Vehicle) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Rotor thrusts (S, 4) and slopes (S, 4, 12) over flat (S, 12): acceleration, jerk, snap, yaw and its two derivatives; thrust upward.
    """

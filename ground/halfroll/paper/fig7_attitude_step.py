"""Fig 7: half a turn about the roll axis, commanded at once.

Why: a planned flip turns no faster than its path asks; this is as fast as the attitude loop turns. The stream jumps by
179 degrees (180 would leave the way round to chance) at zero net thrust, and goes on with inverted hover.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware
from halfroll.drawing import Palette, angle_between, draw_thrust_limits, legend
from halfroll.paper.claims import below, near
from halfroll.paper.part import Part
from halfroll.planner import segments
from halfroll.scenario import load_scenario
from halfroll.station.references import TABLE_STEP_S, Path
from halfroll.streamed import Flown, StreamedFlight
from halfroll.vehicle import Vehicle, load_vehicle

Array = NDArray[np.float64]

_STEP_DEG = 179.0
_HEIGHT_M = 8.0
_TURNING_S = 0.5  # commanded; then it stops its fall, upside down
_CATCH_S, _SETTLES_S, _HOVER_S = 1.2, 1.0, 3.0
_SETTLED_DEG = 9.0  # 5 % of half a turn
_STARTS, _LAW_MS, _REACHED_DEG = 500, 2000, 2.0  # of the attitude loop alone


@dataclass(frozen=True)
class Turn:
    flown: Flown  # from the command on
    turned_deg: Array  # (N,)
    wanders: float  # [m] from where it hovers afterwards
    up: float  # the body's z then: -1 is upside down

    @property
    def settled_s(self) -> float:
        off = np.abs(self.turned_deg - _STEP_DEG) > _SETTLED_DEG
        return float(self.flown.t[min(np.flatnonzero(off)[-1] + 1, len(off) - 1)])

    def passed_s(self, angle_deg: float) -> float:
        return float(self.flown.t[np.argmax(self.turned_deg > angle_deg)])

    def between_s(self, angle_deg: float, later_deg: float) -> float:
        return self.passed_s(later_deg) - self.passed_s(angle_deg)

    @property
    def peak_deg(self) -> float:
        return float(np.degrees(np.abs(self.flown.w_WB_B[:, 0]).max()))


@dataclass(frozen=True)
class Standing:
    """A setpoint that does not turn."""

    q_WD: Array
    thrust: float
    w_WD_D: Array


def reproduce(seeds: int) -> Part:
    turns = turned(seeds)
    corrected, printed = converged(0, _STARTS), converged(1, _STARTS)
    quick = [turn.between_s(10.0, 160.0) for turn in turns]
    of, starts = f"worst of {seeds} flights", f"the attitude loop alone, {_STARTS} attitudes up to 179.9 degrees off"
    claims = (
        below(
            "7a", "from the command to within 5 %", max(turn.settled_s for turn in turns), 0.4, "s", paper=0.4, note=of
        ),
        near(
            "7b",
            "from 10 to 160 degrees, quickest and slowest",
            [min(quick), max(quick)],
            0.23,
            "s",
            off=0.03,
            paper=0.23,
        ),
        below(
            "7b.170", "from 10 to 170 degrees", max(turn.between_s(10.0, 170.0) for turn in turns), 0.3, "s", note=of
        ),
        near("7c", "largest rate", max(turn.peak_deg for turn in turns), 1046.0, "deg/s", share=0.06, paper=1046.0),
        near(
            "7.inverted",
            "it goes on hovering upside down: vertical part of its z axis",
            max(turn.up for turn in turns),
            -1.0,
            off=1e-3,
        ),
        below("7.hover", "and stays within", max(turn.wanders for turn in turns), 0.05, "m", note=of),
        near(
            "7.law",
            "the attitude law (Eq 22, corrected) reaches its reference",
            corrected,
            100.0,
            "%",
            off=0.0,
            note=starts,
        ),
        near("7.printed", "the law as printed does", printed, 0.0, "%", off=0.0, note="it turns away: docs/errata.md"),
    )
    return Part(
        "Fig 7: half a turn, commanded at once",
        claims,
        "A step of 179° flown with sensor noise; faint lines are more seeds.",
        lambda figure, colours: _draw(figure, colours, turns),
        (11.0, 4.8),
    )


@cache
def turned(seeds: int) -> tuple[Turn, ...]:
    return tuple(_turn(load_vehicle("mit-vp"), seed) for seed in range(seeds))


def _turn(vehicle: Vehicle, seed: int) -> Turn:
    flight = StreamedFlight(vehicle, load_scenario("nominal"), seed)
    flight.take_off(_HEIGHT_M)
    flight.settle((0.0, 0.0, _HEIGHT_M))
    half = np.radians(_STEP_DEG) / 2.0
    command = Standing(np.array([np.cos(half), np.sin(half), 0.0, 0.0]), 0.0, np.zeros(3))
    turning = flight.stream(lambda here: command, _TURNING_S)
    angle = np.degrees(np.unwrap(2.0 * np.arctan2(turning.q_WB[:, 1], turning.q_WB[:, 0])))
    path = _catch(flight)
    caught = flight.follow(path, path.duration + _SETTLES_S + _HOVER_S)
    hovers = caught.t > path.duration + _SETTLES_S
    off = np.linalg.norm(caught.p_WB[hovers] - path.at(path.duration)[0, :3], axis=1)
    return Turn(turning, angle, float(off.max()), float(caught.up_axis[hovers, 2].max()))


def _catch(flight: StreamedFlight) -> Path:
    """From the fall to rest, upside down."""
    here = flight.state()
    start = segments.rest([*here.p_WB, 0.0])
    start[1, :3] = here.v_WB
    end = segments.rest([*(here.p_WB + 0.5 * _CATCH_S * here.v_WB), 0.0])
    pieces = segments.solve([start, end], [_CATCH_S])
    t = np.arange(round(_CATCH_S / TABLE_STEP_S) + 1) * TABLE_STEP_S
    return Path(pieces.derivatives(t, 5), np.zeros((len(t), 3)), sigma_events=(-1.0,))  # inverted from the start


def converged(law: int, starts: int) -> float:
    """[%] of attitudes from which the attitude loop alone, with the rotors' lag, turns to upright under ATT_LAW."""
    setup = _firmware.vehicle_setup("mit-vp", [f"params.ATT_LAW={law}"])
    random = np.random.default_rng(1)
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    reached = 0
    for _ in range(starts):
        axis, half = random.normal(size=3), np.radians(random.uniform(0.0, 179.9)) / 2.0
        start = np.array([np.cos(half), *(np.sin(half) * axis / np.linalg.norm(axis))])
        world = _firmware.World(setup.plant, "ideal", 0)
        world.place([0.0, 0.0, 1000.0], np.zeros(3), start, np.zeros(3), [0.0] * 4)
        truth = world.turn_to(upright, 0.0, setup.vehicle, setup.params, _LAW_MS)
        reached += bool(np.degrees(angle_between(truth[-1:, 6:10], upright[None])[0]) < _REACHED_DEG)
    return 100.0 * reached / starts


def _draw(figure: Any, colours: Palette, turns: tuple[Turn, ...]) -> None:
    left, right = figure.add_gridspec(1, 2)
    angle = figure.add_subplot(left)
    rate, thrust = (figure.add_subplot(part) for part in right.subgridspec(2, 1))
    for k, turn in enumerate(turns):
        faint = {"alpha": 1.0 if k == 0 else 0.3, "label": "flown" if k == 0 else None}
        angle.plot(turn.flown.t, turn.turned_deg, color=colours.flown, **faint)
        rate.plot(turn.flown.t, np.degrees(turn.flown.w_WB_B[:, 0]), color=colours.flown, **faint)
    for level in (10.0, 160.0):
        angle.axhline(level, color=colours.faint, lw=1.2, ls=(0, (4, 3)))
    angle.axhspan(_STEP_DEG - _SETTLED_DEG, _STEP_DEG + _SETTLED_DEG, color=colours.x, alpha=0.12, label="within 5 %")
    angle.axvline(0.4, color=colours.alert, lw=1.0, ls=(0, (1, 1.5)), label="0.4 s")
    for number, line_colour in enumerate((colours.flown, *colours.axes)):
        first = turns[0].flown
        thrust.plot(first.t, first.rotors[:, number], color=line_colour, lw=1.1, label=f"rotor {number + 1}")
    draw_thrust_limits(thrust, -3.0, 3.0, colours)
    angle.set(xlabel="time since the command [s]", ylabel="roll [°]")
    rate.set_ylabel("roll rate [°/s]")
    thrust.set(xlabel="time since the command [s]", ylabel="rotor thrust [N]")
    legend(angle)
    legend(thrust)

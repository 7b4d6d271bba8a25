"""T4: blades that change their pitch change thrust much faster than motors that change their speed.

Why: the figures fly with these rotors; their speed is measured here, on the simulated ones.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware
from halfroll.drawing import Palette, legend
from halfroll.paper.claims import above, near
from halfroll.paper.part import Part

Array = NDArray[np.float64]

_SMALL_N = (1.4, 1.5)  # a step around hover
_MS = 1000


def reproduce(seeds: int) -> Part:
    vp, fp = (_step(name, *_SMALL_N) for name in ("mit-vp", "mit-fp"))
    reversal = _step("mit-vp", -3.0, 3.0)
    rises = _rise_s(vp), _rise_s(fp)
    claims = (
        above("T4", "rise of a small step, fixed over variable pitch", rises[1] / rises[0], 5.0),
        near("T4.variable", "variable pitch, 10 to 90 %", rises[0], 0.0396, "s", off=0.002),
        near("T4.fixed", "fixed pitch, 10 to 90 %", rises[1], 0.268, "s", off=0.01),
        near(
            "T4.reversal",
            "variable pitch from -3 to 3 N, within 5 % of the step",
            _passed_s(reversal, 0.95),
            0.069,
            "s",
            off=0.005,
        ),
    )
    return Part(
        "T4: how fast thrust changes",
        claims,
        "A small step of the command at 0, as the simulated rotors follow it; dashed: full reversal.",
        lambda figure, colours: _draw(figure, colours, vp, fp, reversal),
        (8.0, 4.0),
    )


def _step(vehicle: str, low: float, high: float) -> Array:
    """(N,) thrust of a rotor each millisecond, as a share of the step commanded at 0."""
    plant = _firmware.vehicle_setup(vehicle).plant
    world = _firmware.World(plant, "ideal", 0)
    world.place([0.0, 0.0, 1000.0], np.zeros(3), [1.0, 0.0, 0.0, 0.0], np.zeros(3), [low] * 4)
    thrust = [low]
    for _ in range(_MS):
        world.step([high] * 4)
        thrust.append(world.rotor_thrust[0])
    return (np.array(thrust) - low) / (high - low)


def _passed_s(share: Array, level: float) -> float:
    """When it first reaches this share, between the milliseconds."""
    after = int(np.argmax(share >= level))
    part = (level - share[after - 1]) / (share[after] - share[after - 1])
    return 1e-3 * float(after - 1 + part)


def _rise_s(share: Array) -> float:
    return _passed_s(share, 0.9) - _passed_s(share, 0.1)


def _draw(figure: Any, colours: Palette, vp: Array, fp: Array, reversal: Array) -> None:
    axes = figure.subplots()
    t = 1e-3 * np.arange(len(vp))
    axes.plot(t, vp, color=colours.flown, label="variable pitch")
    axes.plot(t, fp, color=colours.y, label="fixed pitch")
    axes.plot(t, reversal, color=colours.flown, ls=(0, (4, 3)), label="variable pitch, -3 to 3 N")
    axes.set(xlabel="time since the command [s]", ylabel="share of the step", xlim=(0.0, 0.5))
    legend(axes)

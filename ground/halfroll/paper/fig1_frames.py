"""Fig 1: the frames and the numbers of the rotors.

Why: every sign in the mixer hangs on this drawing. It is drawn from what the simulated rotors do: each pushes alone for
a millisecond, and how the body begins to turn says where it sits and which way it spins.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware
from halfroll.drawing import Palette
from halfroll.paper.claims import near
from halfroll.paper.part import Part
from halfroll.planner.flatness import rotor_thrusts
from halfroll.station.references import firmware_vehicle
from halfroll.vehicle import load_vehicle

Array = NDArray[np.float64]

_PUSH_N = 1.0
_TILT = np.radians(25.0)  # of the vehicle drawn in space
_ROTOR_RADIUS = 0.45  # of the arm
_AXIS_M = 0.14


def reproduce(seeds: int) -> Part:
    vehicle = load_vehicle("mit-vp")
    d, c = vehicle.arm_m, vehicle.yaw_coefficient_m
    places, spins = _rotors()
    wanted = np.array([[0.0, d], [-d, 0.0], [0.0, -d], [d, 0.0]])
    torque = np.array([0.11, -0.07, 0.004])
    asked, _ = _firmware.allocate(5.0, torque, firmware_vehicle(vehicle))
    planned = rotor_thrusts(np.array(5.0), torque, vehicle)
    claims = (
        near(
            "1",
            "rotors 1 left, 2 rear, 3 right, 4 front: largest distance from there",
            np.abs(places - wanted).max(),
            0.0,
            "m",
            off=1e-6,
            note="simulated rotors pushing one at a time",
        ),
        near("1.spin", "yaw torque per thrust of rotors 1 to 4", spins, [-c, c, -c, c], "m", off=1e-6),
        near(
            "1.mixer",
            "torque that the firmware's rotor thrusts make about these places, against what was asked",
            np.abs(_torque(np.array(asked), places, spins) - torque).max(),
            0.0,
            "N m",
            off=1e-6,
        ),
        near(
            "1.planner",
            "the same for the planner's",
            np.abs(_torque(planned, places, spins) - torque).max(),
            0.0,
            "N m",
            off=1e-6,
        ),
    )
    return Part(
        "Fig 1: frames and rotors",
        claims,
        "Left: the rotors seen from above, where the simulated vehicle has them. Right: world and body frames; the "
        "total thrust is along the body's z.",
        lambda figure, colours: _draw(figure, colours, places, spins),
        (11.0, 5.2),
    )


def _rotors() -> tuple[Array, Array]:
    """(4, 2) x and y of each rotor in B; (4,) yaw torque per thrust."""
    plant = _firmware.vehicle_setup("mit-vp").plant
    level = [1.0, 0.0, 0.0, 0.0]
    places, spins = np.empty((4, 2)), np.empty(4)
    for i in range(4):
        world = _firmware.World(plant, "ideal", 0)
        push = [_PUSH_N * (i == k) for k in range(4)]
        world.place([0.0, 0.0, 5.0], np.zeros(3), level, np.zeros(3), push)
        world.step(push)
        x, y, z = world.w_WB_B / 1e-3 * plant.inertia / _PUSH_N  # r x f e3 = (y, -x) f
        places[i], spins[i] = (-y, x), z
    return places, spins


def _torque(thrusts: Array, places: Array, spins: Array) -> Array:
    return np.array([places[:, 1] @ thrusts, -places[:, 0] @ thrusts, spins @ thrusts])


def _draw(figure: Any, colours: Palette, places: Array, spins: Array) -> None:
    _draw_from_above(figure.add_subplot(1, 2, 1), colours, places, spins)
    _draw_in_space(figure.add_subplot(1, 2, 2, projection="3d"), colours, places)


def _draw_from_above(axes: Any, colours: Palette, places: Array, spins: Array) -> None:
    """x up, y to the left, as a pilot sees it."""
    arm = float(np.linalg.norm(places[0]))
    radius, turn = _ROTOR_RADIUS * arm, np.linspace(0.0, 2.0 * np.pi, 100)
    for i, ((x, y), spin) in enumerate(zip(places.round(6) + 0.0, spins, strict=True), start=1):
        hub = np.array([-y, x])
        axes.plot([0.0, hub[0]], [0.0, hub[1]], color=colours.ink, lw=3.0, solid_capstyle="round", zorder=1)
        axes.plot(hub[0] + radius * np.cos(turn), hub[1] + radius * np.sin(turn), color=colours.planned, lw=1.0)
        arc = np.radians(np.linspace(-50.0, 50.0, 40)) * np.sign(spin) + np.arctan2(hub[1], hub[0])
        arrow = hub[:, None] + 0.72 * radius * np.stack([np.cos(arc), np.sin(arc)])
        axes.plot(*arrow, color=colours.alert, lw=1.4)
        axes.annotate("", arrow[:, -1], arrow[:, -2], arrowprops={"arrowstyle": "-|>", "color": colours.alert})
        label = hub - 0.3 * radius
        axes.text(*label, str(i), fontsize=15, weight="bold", color=colours.ink, ha="center", va="center")
        below = hub + np.array([0.0, 1.2 * radius if x > 0.0 else -1.2 * radius])
        axes.text(*below, f"x {x:.3f}, y {y:.3f} m", ha="center", va="center", fontsize=8.5, color=colours.ink)
    for name, colour, tip in (("x", colours.x, (0.0, 0.085)), ("y", colours.y, (-0.085, 0.0))):
        axes.annotate("", tip, (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2.4}, zorder=5)
        axes.text(tip[0] + 0.016, tip[1] + 0.016, name, color=colour, fontsize=13, ha="center", va="center")
    axes.plot([], [], color=colours.alert, label="torque on the body from positive thrust")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, -0.06))
    axes.set(xlim=(-0.3, 0.3), ylim=(-0.33, 0.3), aspect="equal")
    axes.axis("off")
    axes.set_title("from above, body axes", color=colours.ink)


def _draw_in_space(axes: Any, colours: Palette, places: Array) -> None:
    at = np.array([0.0, 0.0, 0.36])
    c, s = np.cos(_TILT), np.sin(_TILT)
    R = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    rotors = at + np.column_stack([places, np.zeros(4)]) @ R.T
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    disc = _ROTOR_RADIUS * float(np.linalg.norm(places[0])) * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    for i, rotor in enumerate(rotors, start=1):
        axes.plot(*np.stack([at, rotor]).T, color=colours.ink, lw=2.5)
        axes.plot(*(rotor[:, None] + R @ disc), color=colours.planned, lw=1.0)
        axes.text(*(at + 1.62 * (rotor - at)), str(i), fontsize=12, weight="bold", color=colours.ink, ha="center")
    frames = ((np.array([0.12, 0.12, 0.0]), np.eye(3), "W"), (at, R, "B"))
    for origin, frame, name in frames:
        for k, axis in enumerate("xyz"):
            tip = origin + _AXIS_M * frame[:, k]
            axes.quiver(*origin, *(_AXIS_M * frame[:, k]), color=colours.axes[k], lw=2.0, arrow_length_ratio=0.14)
            axes.text(*(tip + 0.02 * frame[:, k]), f"{axis}$_{name}$", color=colours.axes[k], fontsize=11)
    axes.quiver(*at, *(0.27 * R[:, 2]), color=colours.alert, lw=1.6, arrow_length_ratio=0.1, zorder=0)
    axes.text(*(at + 0.3 * R[:, 2]), "thrust, signed", color=colours.alert, fontsize=10)
    axes.quiver(0.0, -0.2, 0.2, 0.0, 0.0, -0.15, color=colours.ink, lw=1.5, arrow_length_ratio=0.18)
    axes.text(0.0, -0.22, 0.12, "gravity", color=colours.ink, fontsize=10)
    axes.set(xlim=(-0.25, 0.3), ylim=(-0.28, 0.28), zlim=(0.0, 0.66))
    axes.set_box_aspect((0.55, 0.56, 0.66), zoom=1.45)
    axes.view_init(elev=30, azim=-150)
    axes.axis("off")
    axes.set_title("world W (north, west, up) and body B", color=colours.ink)

"""The scene: a quadrotor whose rotors show their thrust, where it should be, where it was, and what it flies through.

Why: the only module that knows what things look like in space. It is given a viser scene and moments; whether these go
to a browser now or into a file is not its business.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll.viewer import colours
from halfroll.viewer.moments import Array, Moment, Setting, saturated

COLOURINGS = ("speed", "rotor use")
_FULL_SPEED_M_S = 12.0  # the brightest of the ramp
_ARROW_ARMS = 1.7  # length of full thrust, in arms
_PIECE = 96  # points of a node of the flown path: what is done is never sent again
_GRID_CELL_M = 1.0
# rotors 1 left, 2 rear, 3 right, 4 front, in arms (docs/conventions.md)
ROTORS = np.array([(0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)])


class Stage:
    """Draws a setting at once; `show` moves the vehicle, `trace` lengthens the flown path."""

    def __init__(self, scene: Any, setting: Setting, colouring: str = COLOURINGS[0]) -> None:
        self._scene, self.setting, self._colouring = scene, setting, colouring
        self._arm = setting.arm_m * setting.magnification
        self._thrusts: Any = None
        self._pieces = 0
        self._points: list[tuple[Array, float]] = []  # of the piece that grows: position, share of the ramp
        scene.configure_default_lights(cast_shadow=False)  # costs a phone half its frames
        with_grid(scene, setting)
        self._draw_reference()
        self._vehicle = self._draw_quadrotor("/vehicle", opacity=None)
        self._ghost = self._draw_quadrotor("/ghost", opacity=0.3)
        self._ghost.visible = False
        self._thrusts = scene.add_arrows(
            "/vehicle/thrusts",
            np.zeros((4, 2, 3), dtype=np.float32),
            np.tile(np.array(colours.PUSHES, dtype=np.uint8), (4, 1)),
            shaft_radius=0.05 * self._arm,
            head_radius=0.13 * self._arm,
            head_length=0.22 * self._arm,
        )

    def show(self, moment: Moment) -> None:
        self._vehicle.position = tuple(moment.p_WB)
        self._vehicle.wxyz = tuple(moment.q_WB)
        ghost = moment.reference_q is not None
        if self._ghost.visible != ghost:
            self._ghost.visible = ghost
        if moment.reference_q is not None:
            self._ghost.position = tuple(moment.p_WB if moment.reference_p is None else moment.reference_p)
            self._ghost.wxyz = tuple(moment.reference_q)
        if moment.rotor_N is not None:
            points, shades = thrust_arrows(moment.rotor_N, self.setting.thrust_N, self._arm)
            self._thrusts.points = points
            self._thrusts.colors = shades

    def trace(self, moments: Sequence[Moment]) -> None:
        """The flown path goes on through these."""
        self._points += [(moment.p_WB, share_of(moment, self.setting, self._colouring)) for moment in moments]
        while len(self._points) > 1:
            piece = self._points[:_PIECE]
            self._draw_line(f"/flown/{self._pieces}", [p for p, _ in piece], np.array([share for _, share in piece]))
            if len(self._points) <= _PIECE:
                return
            self._points = self._points[_PIECE - 1 :]
            self._pieces += 1

    def forget(self) -> None:
        """Nothing was flown yet."""
        for piece in range(self._pieces + 1):
            self._scene.remove_by_name(f"/flown/{piece}")
        self._pieces, self._points = 0, []

    def colour_by(self, colouring: str) -> None:
        """From here on; what is drawn already is drawn again by whoever has it."""
        self._colouring = colouring

    def _draw_line(self, name: str, points: Sequence[Array], shares: Array) -> None:
        line = np.array(points, dtype=np.float32)
        segments = np.stack([line[:-1], line[1:]], axis=1)
        shades = colours.ramp(shares)
        self._scene.add_line_segments(
            name,
            segments,
            np.stack([shades[:-1], shades[1:]], axis=1),
            thickness=3.0,
            thickness_units="screen",
        )

    def _draw_reference(self) -> None:
        path = self.setting.path.astype(np.float32)
        if len(path) > 1:
            self._scene.add_line_segments(
                "/reference",
                np.stack([path[:-1], path[1:]], axis=1),
                colours.PLANNED,
                thickness=1.5,
                thickness_units="screen",
            )
        for number, gate in enumerate(self.setting.gates, start=1):
            name = f"/waypoints/{number}"
            self._scene.add_frame(
                name,
                show_axes=False,
                position=tuple(gate.position),
                wxyz=tuple(_IDENTITY if gate.q_WB is None else gate.q_WB),
            )
            self._scene.add_icosphere(f"{name}/point", radius=0.18 * self._arm, color=colours.GATE)
            self._scene.add_label(f"{name}/number", str(number), anchor="bottom-center", font_screen_scale=0.8)
            if gate.q_WB is not None:
                self._scene.add_line_segments(
                    f"{name}/window", window(self._arm), colours.GATE, thickness=3.0, thickness_units="screen"
                )

    def _draw_quadrotor(self, name: str, opacity: float | None) -> Any:
        scene, arm = self._scene, self._arm
        frame = scene.add_frame(name, show_axes=False)
        body = colours.BODY if opacity is None else colours.PLANNED
        look = {} if opacity is None else {"opacity": opacity, "cast_shadow": False, "receive_shadow": False}
        scene.add_box(f"{name}/hull", dimensions=(0.5 * arm, 0.36 * arm, 0.16 * arm), color=body, **look)
        scene.add_box(f"{name}/arm_x", dimensions=(2.0 * arm, 0.09 * arm, 0.06 * arm), color=body, **look)
        scene.add_box(f"{name}/arm_y", dimensions=(0.09 * arm, 2.0 * arm, 0.06 * arm), color=body, **look)
        scene.add_box(
            f"{name}/nose",
            dimensions=(0.16 * arm, 0.2 * arm, 0.12 * arm),
            position=(0.33 * arm, 0.0, 0.0),
            color=colours.NOSE if opacity is None else colours.PLANNED,
            **look,
        )
        for number, place in enumerate(ROTORS, start=1):
            scene.add_cylinder(
                f"{name}/rotor_{number}",
                radius=0.55 * arm,
                height=0.02 * arm,
                position=tuple(arm * place + np.array([0.0, 0.0, 0.07 * arm])),
                color=colours.PLANNED,
                opacity=0.45 if opacity is None else 0.5 * opacity,
                cast_shadow=False,
            )
        if opacity is None:  # how far full thrust would reach, either way
            scene.add_line_segments(
                f"{name}/limits",
                limit_marks(self.setting.thrust_N, arm),
                colours.AT_LIMIT,
                thickness=2.0,
                thickness_units="screen",
            )
        return frame


_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def with_grid(scene: Any, setting: Setting) -> None:
    """The ground, as large as the flight."""
    low, high = setting.corners
    size = max(20.0, 2.5 * float((high - low)[:2].max()))
    middle = 0.5 * (low + high)
    scene.add_grid(
        "/ground",
        width=size,
        height=size,
        cell_size=_GRID_CELL_M,
        section_size=5.0 * _GRID_CELL_M,
        cell_color=(222, 222, 222),
        section_color=(190, 190, 190),
        shadow_opacity=0.0,
        position=(float(np.round(middle[0])), float(np.round(middle[1])), 0.0),
    )


def thrust_arrows(
    rotor_N: Array, thrust_N: tuple[float, float], arm: float
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """(4, 2, 3) ends in B of the arrows of thrusts (4,), and their colours (4, 3). Full thrust is _ARROW_ARMS long."""
    start = arm * ROTORS
    length = np.clip(rotor_N / thrust_N[1], -1.5, 1.5) * _ARROW_ARMS * arm
    end = start + np.stack([np.zeros(4), np.zeros(4), length], axis=1)
    shades = np.where((rotor_N >= 0.0)[:, None], colours.PUSHES, colours.PULLS)
    shades = np.where(saturated(rotor_N, thrust_N)[:, None], colours.AT_LIMIT, shades)
    return np.stack([start, end], axis=1).astype(np.float32), shades.astype(np.uint8)


def limit_marks(thrust_N: tuple[float, float], arm: float) -> NDArray[np.float32]:
    """(N, 2, 3) short bars in B where the arrows of least and largest thrust end."""
    half = np.array([0.18 * arm, 0.0, 0.0])
    bars = []
    for place in ROTORS:
        for limit_N in thrust_N:
            middle = arm * place + np.array([0.0, 0.0, limit_N / thrust_N[1] * _ARROW_ARMS * arm])
            bars.append((middle - half, middle + half))
    return np.array(bars, dtype=np.float32)


def window(arm: float) -> NDArray[np.float32]:
    """(4, 2, 3) a frame in B, across the nose, as wide as the vehicle with room to spare."""
    y, z = 2.2 * arm, 1.0 * arm
    corners = np.array([(0, -y, -z), (0, y, -z), (0, y, z), (0, -y, z)], dtype=np.float32)
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def share_of(moment: Moment, setting: Setting, colouring: str) -> float:
    """Where on the ramp a point of the flown path lies, 0 … 1."""
    if colouring == "speed" or moment.rotor_N is None:
        return min(moment.speed / _FULL_SPEED_M_S, 1.0)
    return rotor_use(moment.rotor_N, setting.thrust_N)


def rotor_use(rotor_N: Array, thrust_N: tuple[float, float]) -> float:
    """Of the rotor that is nearest to a limit: 0 in the middle of its range, 1 at its end."""
    low, high = thrust_N
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return float(np.clip(np.abs(rotor_N - middle).max() / half, 0.0, 1.0))

"""The live page: scene, panels and buttons in a browser, fed by a recording or by a flight that goes on.

Why: who turns moments into updates, and how often. It runs in a process of its own: a browser may be as slow as it
likes, and no reference is late for it.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from halfroll.viewer.listening import Listener
from halfroll.viewer.moments import Moment, Recording, Setting
from halfroll.viewer.panels import SAMPLES, WINDOW_S, Panels, status_html
from halfroll.viewer.server import LocalServer
from halfroll.viewer.stage import COLOURINGS, Stage
from halfroll.wire.transport import Clock, wall_s

FRAME_S = 0.02  # wall clock between two updates of the scene at most
PANEL_S, TRACE_S = 0.2, 0.2
SPEEDS = ("0.1×", "0.25×", "0.5×", "1×", "2×")
_BEHIND_ARMS = 14.0  # of the follow camera
_TRACED = 6000  # samples of the flown path that are kept
_TAKES_UP_S = 0.05  # a listener that hears nothing looks at buttons as often


class Page:
    """Scene and GUI on a server. Callbacks of the browser only leave a wish; the loops below fulfil it."""

    def __init__(self, server: LocalServer, setting: Setting, live: bool, dark: bool = False) -> None:
        self.server, self._live = server, live
        server.gui.configure_theme(dark_mode=dark, show_logo=False, show_share_button=False, control_width="medium")
        self._following = False
        self._offsets: dict[int, Any] = {}  # client id: from the vehicle to the camera (3,)
        self._last: Moment | None = None
        self._shown_s: deque[float] = deque(maxlen=128)
        self._status = server.gui.add_html(status_html(setting, None, (), None))
        self.colouring = COLOURINGS[0]
        self.recoloured = False  # since it was last looked at
        self.stage = self._staged(setting)
        self.controls = server.gui.add_folder("Flight" if live else "Time")
        self._add_view()
        charts = server.gui.add_panel()
        with charts.add_tab("Figures"):
            self._panels = Panels(server.gui, setting, live)
        server.gui.main_panel.dock_right()
        charts.dock_left()
        charts.set_width(330)
        server.on_client_connect(self._look)
        server.on_client_disconnect(lambda client: self._offsets.pop(client.client_id, None))

    @property
    def updates_Hz(self) -> float:
        shown = self._shown_s
        return (len(shown) - 1) / (shown[-1] - shown[0]) if len(shown) > 1 and shown[-1] > shown[0] else 0.0

    def restage(self, setting: Setting) -> None:
        """Another plan, or other rotors."""
        with self.server.atomic():
            self.server.scene.reset()
            self.stage = self._staged(setting)
            if not self._following:
                for client in self.server.get_clients().values():
                    self._seat(client)

    def show(self, moment: Moment, now_s: float) -> None:
        with self.server.atomic():
            self.stage.show(moment)
            if self._following:
                self._follow(moment)
        self._last = moment
        self._shown_s.append(now_s)

    def show_figures(self, moments: list[Moment] | Any, said: Any = ()) -> None:
        if len(moments):
            rate = self.updates_Hz if self._live else None
            self._status.content = status_html(self.stage.setting, moments[-1], said, rate)
            self._panels.show(moments)

    def _staged(self, setting: Setting) -> Stage:
        camera, (place, middle) = self.server.initial_camera, setting.seat
        camera.position, camera.look_at, camera.up = tuple(place), tuple(middle), (0.0, 0.0, 1.0)
        return Stage(self.server.scene, setting, self.colouring)

    def _add_view(self) -> None:
        gui = self.server.gui
        with gui.add_folder("View"):
            follow = gui.add_checkbox("Follow", False)
            colouring = gui.add_dropdown("Path by", COLOURINGS)
            dark = gui.add_checkbox("Dark", False)

        @follow.on_update
        def _(_: Any) -> None:
            self._offsets.clear()
            self._following = follow.value

        @colouring.on_update
        def _(_: Any) -> None:
            self.colouring, self.recoloured = colouring.value, True

        @dark.on_update
        def _(_: Any) -> None:
            gui.configure_theme(dark_mode=dark.value, show_logo=False, show_share_button=False)

    def _look(self, client: Any) -> None:
        """Follow goes on from where a person turns the camera to."""

        def turned(camera: Any) -> None:
            if client.client_id in self._offsets:
                self._offsets[client.client_id] = camera.position - camera.look_at

        client.camera.on_update(turned)
        self._seat(client)  # the plan may have come while it connected

    def _seat(self, client: Any) -> None:
        """Where all that stands still is seen from."""
        client.camera.position, client.camera.look_at = self.stage.setting.seat

    def _follow(self, moment: Moment) -> None:
        reach = _BEHIND_ARMS * self.stage.setting.arm_m * self.stage.setting.magnification
        for client in self.server.get_clients().values():
            away = self._offsets.setdefault(client.client_id, reach * np.array([-0.8, -0.45, 0.4]))
            client.camera.look_at = moment.p_WB
            client.camera.position = moment.p_WB + away


def play(page: Page, recording: Recording, stopped: threading.Event, clock: Clock = wall_s) -> None:
    """A recording under a time slider, until stopped."""
    first_s, last_s = recording.span
    gui = page.server.gui
    with page.controls:
        slider: Any = gui.add_slider("time, s", min=0.0, max=last_s - first_s, step=0.01, initial_value=0.0)
        playing = gui.add_checkbox("Play", True)
        speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1×")
    wish: deque[float] = deque(maxlen=1)

    def sought(event: Any) -> None:
        if event.client is not None:  # a person, not the loop below
            wish.append(slider.value)

    slider.on_update(sought)

    thin = recording.thinned(50.0)
    page.stage.trace(thin.moments)
    t_s, before_s, figures_s, shown_s = 0.0, clock(), -1.0, -1.0
    while not stopped.is_set():
        now_s = clock()
        if playing.value:
            t_s += (now_s - before_s) * float(speed.value.rstrip("×"))
            t_s = 0.0 if t_s > last_s - first_s else t_s
        before_s = now_s
        if wish:
            t_s = wish.popleft()
        if page.recoloured:
            page.recoloured = False
            page.stage.forget()
            page.stage.colour_by(page.colouring)
            page.stage.trace(thin.moments)
        if t_s != shown_s:
            shown_s = t_s
            page.show(recording.at(first_s + t_s), now_s)
            if now_s - figures_s > PANEL_S or not playing.value:
                figures_s = now_s
                if playing.value:
                    slider.value = round(t_s, 2)
                page.show_figures(recording.window(first_s + t_s, WINDOW_S, SAMPLES))
        stopped.wait(FRAME_S)


def _wished(wishes: deque[Callable[[], None]], order: Callable[[], None], _: object) -> None:
    wishes.append(order)


def watch(page: Page, listener: Listener, stopped: threading.Event, clock: Clock = wall_s) -> None:
    """A flight that goes on, until stopped."""
    wishes: deque[Callable[[], None]] = deque()
    gui = page.server.gui
    with page.controls:
        for name, order, hint in (
            ("Start", listener.start, "arm, and start the stored mission"),
            ("Hold", listener.hold, "stop here"),
            ("Land", listener.land, "land here"),
            ("Wind gust", listener.gust, "6 m/s to the east, in the simulator"),
            ("Cut the link", listener.cut_link, "of the ground station for a second, in the simulator"),
        ):
            button: Any = gui.add_button(name, hint=hint)
            button.on_click(partial(_wished, wishes, order))
    setting = listener.setting
    recent: deque[Moment] = deque(maxlen=2 * SAMPLES)
    flown: deque[Moment] = deque(maxlen=_TRACED)
    untraced: list[Moment] = []
    shown_s = panel_s = trace_s = -1.0
    while not stopped.is_set():
        while wishes:
            wishes.popleft()()
        new = listener.listen(_TAKES_UP_S)
        now_s = clock()
        moment = listener.moment
        if listener.setting is not setting:
            setting = listener.setting
            page.restage(setting)
            untraced = list(flown)
        if page.recoloured:
            page.recoloured = False
            page.stage.forget()
            page.stage.colour_by(page.colouring)
            untraced = list(flown)
        if moment is None:
            continue
        if flown and moment.t_s < flown[-1].t_s - 1.0:  # its clock began anew
            page.stage.forget()
            for kept in (flown, recent, untraced):
                kept.clear()
        if new and now_s - shown_s >= FRAME_S * 0.8:
            shown_s = now_s
            page.show(moment, now_s)
            if moment.armed and (not flown or moment.t_s - flown[-1].t_s >= 0.04):
                flown.append(moment)
                untraced.append(moment)
        if not recent or (new and moment.t_s - recent[-1].t_s >= WINDOW_S / SAMPLES):
            recent.append(moment)
        if untraced and now_s - trace_s >= TRACE_S:
            trace_s = now_s
            page.stage.trace(untraced)
            untraced = []
        if now_s - panel_s >= PANEL_S:
            panel_s = now_s
            window = [each for each in recent if each.t_s >= moment.t_s - WINDOW_S]
            page.show_figures([*window, moment], listener.said)

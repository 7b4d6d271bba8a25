"""`halfroll view`. Why: the page and its replay, and what they are made from."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from halfroll.cli.endings import errors_for_people
from halfroll.cli.options import Instance, PlanningMode, Settings, VehicleName, overrides
from halfroll.errors import InputError, LinkError

if TYPE_CHECKING:
    from halfroll.vehicle import Vehicle
    from halfroll.viewer.server import LocalServer

LIVE = "live"


def view(
    what: Annotated[str, typer.Argument(metavar="live|LOG|PLAN", help="Or a flight's folder, or a mission.")],
    save: Annotated[
        Path | None, typer.Option("--save", metavar="R.html", help="Write a replay that opens without anything else.")
    ] = None,
    plan: Annotated[
        Path | None, typer.Option(metavar="P", help="The plan of a log, .json or .npz (else beside the log).")
    ] = None,
    vehicle: VehicleName = "mit-vp",
    settings: Settings = None,
    mode: PlanningMode = "paper",
    instance: Instance = 0,
    port: Annotated[int, typer.Option(help="Of the page; the first free one from there on.", min=1, max=65535)] = 8090,
    dark: Annotated[bool, typer.Option("--dark", help="Light on dark.")] = False,
    browser: Annotated[bool, typer.Option("--open", help="Open the page in a browser.")] = False,
) -> None:
    """Look at a flight in space: as it flies, as it was logged, or as it is planned.

    \b
    halfroll view live                      beside halfroll sitl and halfroll ground, or halfroll fly --live
    halfroll view flights/first_flight-mit-vp --save replay.html
    halfroll view examples/aerobatics.toml
    """
    with errors_for_people(as_json=False):
        require_viser()
        if what == LIVE:
            if save:
                raise InputError(
                    "--save: a replay is made of a log or a plan; fly first, then halfroll view LOG --save"
                )
            _live(instance, vehicle, settings, port, dark, browser)
            return
        planning: dict[str, Any] = {"vehicle": vehicle, "mode": mode, "overrides": overrides(settings)}
        if save:
            from halfroll.viewer.notebook import view as replay_of

            replay_of(what, plan=plan, dark=dark, **planning).save(save)
            print(f"replay: {save}")
            return
        from halfroll.viewer.sources import recording_of

        recording = recording_of(what, plan=plan, **planning)
        from halfroll.viewer.page import Page, play
        from halfroll.viewer.server import LocalServer

        server = LocalServer(port)
        page = Page(server, recording.setting, live=False, dark=dark)
        with _open(server, browser) as stopped:
            play(page, recording, stopped)


def _live(instance: int, vehicle: str, settings: list[str] | None, port: int, dark: bool, browser: bool) -> None:
    from halfroll.flight import SITL_COMPANION_PORT
    from halfroll.vehicle import load_vehicle
    from halfroll.viewer.listening import Listener
    from halfroll.viewer.page import Page, watch
    from halfroll.viewer.server import LocalServer
    from halfroll.wire.told import TOLD_PORT
    from halfroll.wire.transport import LOOPBACK, UdpTransport

    os.nice(10)  # whoever flies goes first
    transport = UdpTransport.bind(0, (LOOPBACK, SITL_COMPANION_PORT + instance))
    told = UdpTransport.bind(TOLD_PORT + instance)
    flown_by = load_vehicle(vehicle, overrides(settings))
    listener = Listener(transport, told, flown_by, 1 + instance, f"live · instance {instance}")
    server = LocalServer(port)
    page = Page(server, listener.setting, live=True, dark=dark)
    with _open(server, browser) as stopped:
        watch(page, listener, stopped)


@contextlib.contextmanager
def page_beside(vehicle: Vehicle) -> Iterator[Callable[[int], tuple[int, str]]]:
    """For `halfroll fly --live`: call it with the instance that flies; it comes back, with process and address,
    when the page can be opened."""
    pages: list[subprocess.Popen[str]] = []

    def begin(instance: int) -> tuple[int, str]:
        rotor, kind = vehicle.rotor, "mit-vp" if vehicle.variable_pitch else "mit-fp"
        seen = {
            "rotor.thrust_min_N": rotor.thrust_min_N,
            "rotor.thrust_max_N": rotor.thrust_max_N,
            "arm_m": vehicle.arm_m,
        }
        numbers = [word for key, number in seen.items() for word in ("--set", f"{key}={number:.17g}")]
        words = ["view", LIVE, "--instance", str(instance), "--vehicle", kind, *numbers]
        command = [sys.executable, "-m", "halfroll", *words]
        page = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=words_of_it, text=True)
        pages.append(page)
        said = page.stdout.readline() if page.stdout else ""
        if not said:
            code = page.wait()
            words_of_it.seek(0)
            why = (words_of_it.read().strip().splitlines() or ["it said nothing"])[-1].removeprefix("error: ")
            raise LinkError(f"the page did not open (exit code {code}): {why}")
        print(said.strip(), file=sys.stderr, flush=True)
        return page.pid, said.split()[1]

    with tempfile.TemporaryFile("w+") as words_of_it:  # what it says when it is ended is nobody's concern
        try:
            yield begin
        finally:
            for page in pages:
                page.terminate()
                page.communicate()


@contextlib.contextmanager
def _open(server: LocalServer, browser: bool) -> Iterator[threading.Event]:
    print(f"page: {server.url} (Ctrl-C ends it)", flush=True)
    if browser:
        import webbrowser

        webbrowser.open(server.url)
    stopped = threading.Event()
    try:
        yield stopped
    finally:
        stopped.set()
        server.stop()


def require_viser() -> None:
    from importlib.util import find_spec

    if find_spec("viser") is None:
        raise InputError("the page is drawn by viser, which is not installed; run pip install 'halfroll[view]'")

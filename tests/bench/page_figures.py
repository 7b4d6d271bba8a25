"""What a page beside a flight costs it and what it brings: how late references are in real time without and with
somebody watching, the page's share of a core, and how many positions of the vehicle a second reach who watches.

Why: whoever watches must not disturb who flies. Figures like those of bench.py, which prints them, too. Alone:
page_figures.py [--repeats N] [nobody|reader|chromium ...], by turns, medians of N.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import viser
import zstandard
from playwright.sync_api import Page, sync_playwright
from websockets.sync.client import connect

from halfroll.cli.viewing import page_beside
from halfroll.flight import FlightResult, fly
from halfroll.vehicle import load_vehicle

MISSION = Path(__file__).parents[2] / "examples" / "first_flight.plan"
CHROMIUM = Path("/usr/bin/chromium")
ARGUMENTS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox")
COUNT_FRAMES = "() => { window.drawn = 0; const one = () => { window.drawn++; requestAnimationFrame(one) }; one() }"

Figure = dict[str, object]


# Who watches, in a process of its own, and prints a line a second: positions of the vehicle that came and, of a
# browser, pictures that it has drawn.


def positions(frame: bytes) -> int:
    """Of the vehicle in one frame of viser's websocket: sizes, then a compressed msgpack."""
    size = int.from_bytes(frame[8:16], "little")
    messages = msgspec.msgpack.decode(zstandard.decompress(frame[16 : 16 + size]))["messages"]
    return sum(each["type"] == "SetPositionMessage" and each["name"] == "/vehicle" for each in messages)


def read(url: str) -> None:
    """Takes all that it is sent and draws nothing."""
    count, due_s = 0, time.monotonic() + 1.0
    protocols = [f"viser-v{viser.__version__}"]
    with connect(url.replace("http", "ws"), origin=url, subprotocols=protocols, max_size=None) as page:  # type: ignore[arg-type]
        for frame in page:
            count += positions(frame if isinstance(frame, bytes) else b"")
            if time.monotonic() >= due_s:
                print(count, flush=True)
                count, due_s = 0, due_s + 1.0


def browse(url: str) -> None:
    """A browser that renders in software: it takes what a machine without a graphics card can spare."""
    os.nice(15)
    count = 0

    def count_in(page: Page) -> None:
        def came(frame: str | bytes) -> None:
            nonlocal count
            count += positions(frame) if isinstance(frame, bytes) else 0

        page.on("websocket", lambda socket: socket.on("framereceived", came))

    with sync_playwright() as playwright:
        page = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS).new_page()
        count_in(page)
        page.goto(url)
        page.evaluate(COUNT_FRAMES)
        before_s = time.monotonic()
        while True:
            page.wait_for_timeout(1000)
            drawn = page.evaluate("() => { const n = window.drawn; window.drawn = 0; return n }")
            now_s = time.monotonic()
            print(count / (now_s - before_s), drawn / (now_s - before_s), flush=True)
            count, before_s = 0, now_s


WATCHERS: dict[str, Callable[[str], None]] = {"reader": read, **({"chromium": browse} if CHROMIUM.exists() else {})}


# The flight that is watched.


def cpu_s(process: int) -> float:
    """Of the process and its threads so far."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def watched_by(name: str, url: str, seconds: list[list[float]]) -> Iterator[None]:
    """seconds: filled with what the watcher prints."""
    words = [sys.executable, __file__, "--watch", url, name]
    running = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    def listen() -> None:
        seconds.extend([float(word) for word in line.split()] for line in running.stdout or ())

    listening = threading.Thread(target=listen)
    listening.start()
    try:
        yield
    finally:
        running.terminate()
        running.wait()
        listening.join()


def flown(
    before: Callable[[int], None] = lambda instance: None, ended: Callable[[], None] = lambda: None
) -> FlightResult:
    with tempfile.TemporaryDirectory() as folder:
        flight = fly(MISSION, lockstep=False, log_path=Path(folder) / "flight.ulg", on_ports=before)
        ended()
    return flight


def watched(name: str) -> dict[str, float]:
    """A flight with a page that somebody looks at."""
    seconds: list[list[float]] = []
    at: dict[str, float] = {}
    with contextlib.ExitStack() as stack:
        begin = stack.enter_context(page_beside(load_vehicle("mit-vp")))

        def before(instance: int) -> None:
            page, url = begin(instance)
            stack.enter_context(watched_by(name, url, seconds))
            time.sleep(5.0)  # connected, and its first picture drawn
            at.update(page=page, began_s=time.monotonic(), cpu_s=cpu_s(page))

        def ended() -> None:
            at["share"] = (cpu_s(int(at["page"])) - at["cpu_s"]) / (time.monotonic() - at["began_s"])

        flight = flown(before, ended)
    moving = [second for second in seconds if second[0] > 0.0]  # nothing is sent before the vehicle is heard
    medians = [statistics.median(column) for column in zip(*moving, strict=True)]
    return {
        "interval_p99_ms": 1e3 * flight.interval_p99_s,
        "page_cpu_share": at["share"],
        **dict(zip(("positions_Hz", "drawn_Hz"), medians, strict=False)),
    }


UNITS = {"interval_p99_ms": "ms", "page_cpu_share": "cores", "positions_Hz": "1/s", "drawn_Hz": "1/s"}


def page_figures(repeats: int = 1, names: tuple[str, ...] = ("nobody", *WATCHERS)) -> list[Figure]:
    """Medians of `repeats` flights each, by turns, so that all see the same machine."""
    found: dict[tuple[str, str], list[float]] = defaultdict(list)
    for _ in range(repeats):
        for name in names:
            told = watched(name) if name != "nobody" else {"interval_p99_ms": 1e3 * flown().interval_p99_s}
            for what, value in told.items():
                found[name, what].append(value)
    figures: list[Figure] = [
        {"name": f"watched_by_{name}_{what}", "value": statistics.median(values), "unit": UNITS[what]}
        for (name, what), values in found.items()
    ]
    alone = found.get(("nobody", "interval_p99_ms"))
    if alone:
        figures += [
            {
                "name": f"watched_by_{name}_worsens_p99_by",
                "value": statistics.median(values) - statistics.median(alone),
                "unit": "ms",
            }
            for (name, what), values in found.items()
            if what == "interval_p99_ms" and name != "nobody"
        ]
    return figures


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--watch", metavar="URL", help=argparse.SUPPRESS)
    parser.add_argument("names", nargs="*", default=["nobody", *WATCHERS])
    given = parser.parse_args()
    if given.watch:
        WATCHERS[given.names[0]](given.watch)
    else:
        for figure in page_figures(given.repeats, tuple(given.names)):
            print(f"{figure['name']:40s} {figure['value']:12.4g} {figure['unit']}", flush=True)

"""What a page beside a flight costs it: how late references are in real time, without and with somebody watching.

Why: whoever watches must not disturb who flies. Figures like those of bench.py, which prints them, too.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from halfroll.cli.viewing import page_beside
from halfroll.flight import FlightResult, fly
from halfroll.vehicle import load_vehicle

MISSION = Path(__file__).parents[2] / "examples" / "first_flight.plan"
CHROMIUM = Path("/usr/bin/chromium")
# A viewer that takes all it is sent and draws nothing: what the page's process costs, apart from the browser.
READER = """
import sys, viser
from websockets.sync.client import connect
url = sys.argv[1]
protocols = ["viser-v" + viser.__version__]
with connect(url.replace("http", "ws"), origin=url, subprotocols=protocols, max_size=None) as page:
    for _ in page:
        pass
"""
BROWSER = """
import os, sys, time
from playwright.sync_api import sync_playwright
os.nice(15)
with sync_playwright() as playwright:
    arguments = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
    page = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=arguments).new_page()
    page.goto(sys.argv[1])
    while True:
        page.wait_for_timeout(1000)
"""

Figure = dict[str, object]


def cpu_s(process: int) -> float:
    """Of the process and its threads so far."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def watcher(program: str | None, url: str) -> Iterator[None]:
    if program is None:
        yield
        return
    running = subprocess.Popen([sys.executable, "-c", program, url], stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        running.terminate()
        running.wait()


def flown(
    before: Callable[[int], None] = lambda instance: None, ended: Callable[[], None] = lambda: None
) -> FlightResult:
    with tempfile.TemporaryDirectory() as folder:
        flight = fly(MISSION, lockstep=False, log_path=Path(folder) / "flight.ulg", on_ports=before)
        ended()
    return flight


def watched(program: str | None) -> tuple[FlightResult, float]:
    """A flight with a page, and the share of a core that the page's process took."""
    with contextlib.ExitStack() as stack:
        begin = stack.enter_context(page_beside(load_vehicle("mit-vp")))
        at: dict[str, float] = {}

        def before(instance: int) -> None:
            page, url = begin(instance)
            stack.enter_context(watcher(program, url))
            time.sleep(5.0)  # connected, and its first picture drawn
            at.update(page=page, began=time.monotonic(), cpu=cpu_s(page))

        def ended() -> None:
            at["share"] = (cpu_s(int(at["page"])) - at["cpu"]) / (time.monotonic() - at["began"])

        return flown(before, ended), at["share"]


def page_figures() -> list[Figure]:
    alone_ms = 1e3 * flown().interval_p99_s
    figures: list[Figure] = [{"name": "reference_interval_p99_alone", "value": alone_ms, "unit": "ms"}]
    watchers = {"reader": READER, **({"chromium": BROWSER} if CHROMIUM.exists() else {})}
    for name, program in watchers.items():
        flight, share = watched(program)
        p99_ms = 1e3 * flight.interval_p99_s
        figures += [
            {"name": f"reference_interval_p99_{name}", "value": p99_ms, "unit": "ms"},
            {"name": f"page_{name}_worsens_p99_by", "value": p99_ms - alone_ms, "unit": "ms"},
            {"name": f"page_{name}_cpu_share", "value": share, "unit": "cores"},
        ]
    return figures


if __name__ == "__main__":
    for figure in page_figures():
        print(f"{figure['name']:40s} {figure['value']:12.4g} {figure['unit']}", flush=True)

"""The page in a browser, beside flights of the real programs: what a person sees, clicks and is spared."""

from __future__ import annotations

import contextlib
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from system.contract.missions import RTL_ITEM, TAKEOFF_ITEM, waypoint
from system.gcs import Gcs
from system.processes import EXAMPLES, HALFROLL, MISSIONS, Running, free_instance, halfroll, simulator

pytestmark = pytest.mark.long

PICTURES = Path(__file__).parents[2] / "build" / "pictures"
CHROMIUM = "/usr/bin/chromium"  # Debian's; `make` installs it for these tests
SOFTWARE_RENDERING = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox")
LAPTOP, PHONE = {"width": 1280, "height": 720}, {"width": 844, "height": 390}
PATIENCE_S = 240.0  # rendering in software on a busy machine; nothing is judged by how long it took
SLOWLY = "0.25"  # times real time: a browser that renders in software has seen something before it is over
HOLD = 4 << 16 | 3 << 24
COLOURED_PIXELS = """canvas => {
  const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data
  let count = 0
  for (let i = 0; i < pixels.length; i += 4)
    if (pixels[i + 3] > 0 && Math.max(...pixels.slice(i, i + 3)) - Math.min(...pixels.slice(i, i + 3)) > 60) count++
  return count
}"""


class Seen:
    """A page, and every address that it or anything in it has asked for."""

    def __init__(self, browser: Browser, url: str, size: dict[str, int] = LAPTOP) -> None:
        self.page: Page = browser.new_page(viewport=size)  # type: ignore[arg-type]
        self.page.set_default_timeout(1e3 * PATIENCE_S)
        self.addresses: list[str] = []
        self.page.on("request", lambda request: self.addresses.append(request.url))
        self.page.on("websocket", lambda socket: self.addresses.append(socket.url))
        self.page.goto(url if url.startswith("file") else f"{url}/?fixedDpr=0.5")  # a software renderer is slow

    def figure(self, name: str) -> str:
        """A row of the status table, empty while there is none."""
        cell = self.page.locator(f"#halfroll-{name}")
        return cell.inner_text() if cell.count() else ""

    def number(self, name: str) -> float:
        found = re.search(r"-?\d+\.?\d*", self.figure(name))
        return float(found[0]) if found else float("nan")

    def until(self, holds: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end, f"never {what}: {self.page.inner_text('body')}"
            self.page.wait_for_timeout(100)

    def scene(self) -> bytes:
        """A picture of the space between the panels."""
        box = self.page.locator("canvas").first.bounding_box()
        assert box is not None
        middle = {"x": box["width"] * 0.35, "y": box["height"] * 0.3, "width": box["width"] * 0.35, "height": 300}
        return self.page.screenshot(clip=middle)  # type: ignore[arg-type]

    def seek(self, share: float) -> None:
        """A click on the time slider."""
        box = self.page.locator(".mantine-Slider-track").first.bounding_box()
        assert box is not None
        self.page.mouse.click(box["x"] + share * box["width"], box["y"] + 0.5 * box["height"])

    def picture(self, name: str) -> None:
        PICTURES.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=PICTURES / f"{name}.png")

    def drawn_panels(self) -> int:
        """Panels with a line in them."""
        canvases = self.page.locator(".uplot canvas")
        return sum(canvases.nth(i).evaluate(COLOURED_PIXELS) > 50 for i in range(canvases.count()))


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=CHROMIUM, args=list(SOFTWARE_RENDERING))
        yield running
        running.close()


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a flight that turns over."""
    folder = tmp_path_factory.mktemp("flown") / "flight"
    ended = halfroll("fly", EXAMPLES / "aerobatics.toml", "--replay", "--out", folder)
    assert ended.code == 0, ended.err
    return folder


def url_of(running: Running) -> str:
    running.until_it_says("page: http")
    found = re.search(r"page: (http://\S+)", running.said)
    assert found
    return found[1]


def only_from(url: str, addresses: list[str]) -> bool:
    host = url.split("//")[1]
    mine = (f"http://{host}", f"ws://{host}", "blob:", "data:", "file:///")
    return bool(addresses) and all(address.startswith(mine) for address in addresses)


def test_a_flight_is_started_seen_and_held_from_the_page(browser: Browser) -> None:
    instance = free_instance()
    number = ("--instance", str(instance))
    with contextlib.ExitStack() as stack:
        ground = stack.enter_context(Running(HALFROLL, "ground", *number))
        ground.until_it_says("waiting for an autopilot")
        stack.enter_context(simulator("--speed", SLOWLY, instance=instance))
        gcs = stack.enter_context(Gcs(instance))
        gcs.upload([TAKEOFF_ITEM, waypoint(40.0), waypoint(40.0, 40.0), waypoint(0.0, 40.0), RTL_ITEM])
        ground.until_it_says("plan ready")
        url = url_of(stack.enter_context(Running(HALFROLL, "view", "live", *number)))
        seen = Seen(browser, url)
        seen.until(lambda: seen.figure("mode") == "HOLD, disarmed", "connected")
        seen.page.get_by_role("button", name="Start").click()
        seen.until(lambda: seen.number("speed") > 1.0, "in the air")
        place, clock, before = seen.figure("position"), seen.number("time"), seen.scene()
        seen.until(lambda: seen.figure("position") != place and seen.number("time") > clock, "moving")
        seen.until(lambda: seen.scene() != before, "drawn elsewhere")
        seen.until(lambda: seen.figure("mode") == "OFFBOARD" and seen.figure("error") != "–", "beside its reference")
        seen.until(lambda: seen.drawn_panels() >= 5, "drawn in five panels")
        seen.picture("page_live")
        seen.page.get_by_role("button", name="Hold").click()
        gcs.until(lambda m: m.get_type() == "HEARTBEAT" and m.get_srcComponent() == 1 and m.custom_mode == HOLD)
        seen.until(lambda: seen.figure("mode") == "HOLD", "in HOLD")
        seen.until(lambda: seen.number("speed") < 0.2, "at rest")
        assert only_from(url, seen.addresses), seen.addresses
        seen.page.close()


def test_gust_and_cut_reach_the_simulated_world(browser: Browser) -> None:
    with (
        Running(HALFROLL, "sitl", "--instance", "7") as sitl,
        Running(HALFROLL, "view", "live", "--instance", "7") as page,
    ):
        sitl.until_it_says("ready")
        seen = Seen(browser, url_of(page))
        seen.until(lambda: seen.figure("mode") == "HOLD, disarmed", "connected")
        for name, answer in (("Wind gust", "gust: done"), ("Cut the link", "cut: done")):
            seen.page.get_by_role("button", name=name).click()
            seen.page.get_by_text(answer).wait_for()
        seen.page.close()


def test_a_log_is_sought_played_followed_and_seen_in_the_dark(browser: Browser, flown: Path) -> None:
    with Running(HALFROLL, "view", flown) as shown:
        url = url_of(shown)
        seen = Seen(browser, url)
        seen.until(lambda: seen.figure("mode") != "", "shown")
        clock = seen.number("time")
        seen.until(lambda: seen.number("time") > clock, "playing")
        seen.page.get_by_label("Play").uncheck()
        seen.seek(0.02)
        seen.until(lambda: seen.number("time") < 5.0, "at its beginning")
        start, before = seen.number("time"), seen.scene()
        seen.seek(0.5)
        seen.until(lambda: seen.number("time") > start + 10.0, "in the middle")
        seen.until(lambda: seen.figure("mode") == "OFFBOARD" and seen.figure("error") != "–", "beside its plan")
        seen.until(lambda: seen.scene() != before, "drawn elsewhere")
        seen.until(lambda: seen.drawn_panels() >= 4, "drawn in four panels")
        seen.picture("page_log")
        seen.page.get_by_label("Follow").check()
        seen.page.get_by_label("Dark", exact=True).check()
        seen.page.wait_for_timeout(3000)
        seen.seek(0.52)
        seen.page.wait_for_timeout(3000)
        seen.picture("page_log_dark_follow")
        assert only_from(url, seen.addresses), seen.addresses
        seen.page.set_viewport_size(PHONE)  # type: ignore[arg-type]
        seen.page.wait_for_timeout(3000)
        seen.picture("page_phone")
        seen.page.close()


def test_a_replay_opens_from_the_disk_plays_and_asks_nobody(browser: Browser, flown: Path) -> None:
    replay = flown / "replay.html"
    assert 'href="replay.html"' in (flown / "report.html").read_text()
    seen = Seen(browser, replay.as_uri())
    seen.page.locator("canvas").first.wait_for()
    seen.page.wait_for_timeout(4000)
    before = seen.scene()
    seen.until(lambda: seen.scene() != before, "moving")
    seen.picture("page_replay")
    assert only_from("http://nobody", seen.addresses), seen.addresses
    seen.page.close()


def test_a_mission_is_seen_before_it_flies(browser: Browser) -> None:
    with Running(HALFROLL, "view", MISSIONS / "box.plan") as shown:
        seen = Seen(browser, url_of(shown))
        seen.until(lambda: seen.figure("mode") == "PLAN", "shown")
        seen.page.close()

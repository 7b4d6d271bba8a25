"""The page's server: who may talk to it, what it draws, and what it writes into a file."""

from __future__ import annotations

import json
import re
import urllib.request
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from halfroll.viewer.moments import Gate, Moment, Recording, Setting
from halfroll.viewer.notebook import Replay
from halfroll.viewer.replay import replay_html
from halfroll.viewer.server import LocalServer

PROTOCOL = "viser-v1.1.1"


@pytest.fixture(scope="module")
def server() -> Iterator[LocalServer]:
    running = LocalServer(port=0)
    yield running
    running.stop()


def origin_answers(server: LocalServer, origin: str | None) -> int:
    """Status of the websocket's handshake; 101 when it is open."""
    address = server.url.replace("http", "ws")
    try:
        with connect(address, origin=origin, subprotocols=[PROTOCOL]):  # type: ignore[arg-type, list-item]
            return 101
    except InvalidStatus as refused:
        return refused.response.status_code


def test_the_page_is_served_on_loopback_alone(server):
    assert server.get_host() == "127.0.0.1"
    with urllib.request.urlopen(server.url) as page:
        assert b"<html" in page.read()[:2000].lower()


def test_only_the_pages_own_origin_may_open_its_websocket(server):
    port = server.get_port()
    assert origin_answers(server, f"http://127.0.0.1:{port}") == 101
    assert origin_answers(server, f"http://localhost:{port}") == 101
    for stranger in ("http://evil.example", f"http://127.0.0.1:{port + 1}", f"https://127.0.0.1:{port}", "null", None):
        assert origin_answers(server, stranger) == 403, stranger


def test_the_page_is_never_shared_through_another_machine(server):
    assert server.request_share_url() is None


def wild_flight(seconds: float, rate_Hz: float) -> Recording:
    """One that compresses badly: everything turns and shakes all the time."""
    rng, count = np.random.default_rng(1), int(seconds * rate_Hz)
    q = rng.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    p, f = rng.uniform(-20.0, 20.0, (count, 3)), rng.uniform(-3.0, 3.0, (count, 4))
    moments = [
        Moment(
            i / rate_Hz,
            p[i],
            q[i],
            5.0 * q[i, :3],
            q[i, :3],
            rotor_N=f[i],
            reference_p=p[i],
            reference_q=q[i],
            mode="M",
        )
        for i in range(count)
    ]
    gates = (Gate(np.zeros(3)), Gate(np.ones(3), q[0]))
    return Recording.of(Setting("wild", (-3.0, 3.0), 0.2, p[:200], gates), moments)


def test_a_minute_of_the_wildest_flight_is_a_file_of_less_than_8_megabytes():
    page = replay_html(wild_flight(60.0, 50.0))
    assert len(page.encode()) < 8e6
    assert "__VISER_EMBED_DATA__" in page


def test_a_replay_draws_error_and_rotors_between_their_limits_and_no_figure_of_what_is_not_known():
    def figures(recording: Recording) -> dict[str, Any]:
        return json.loads(re.search(r"const flight = (.*)", replay_html(recording))[1])

    wild = figures(wild_flight(2.0, 25.0))
    assert [panel["title"] for panel in wild["panels"]] == ["rotor command, N"]  # it is where it should be
    assert wild["panels"][0]["limits"] == [-3.0, 3.0]
    assert {len(line["y"]) for line in wild["panels"][0]["lines"]} == {len(wild["t"])} == {len(wild["words"])}
    still = Moment(0.0, np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(3), np.zeros(3), mode="</script>")
    off = replace(still, t_s=0.04, reference_p=np.array([0.0, 0.003, 0.0]))
    lost = figures(Recording.of(Setting("", (0.0, 3.0), 0.2), [still, off]))
    assert [panel["title"] for panel in lost["panels"]] == ["position error, mm"]
    assert lost["panels"][0]["lines"][0]["y"] == [None, 3.0]
    assert lost["words"][0] == "0.0 s · </script> · 0.0 m/s"


def test_a_replay_in_a_notebook_is_a_frame_that_needs_nothing_else(tmp_path):
    replay = Replay('<html title="a & b"></html>', height_px=300)
    page = "&lt;html title=&quot;a &amp; b&quot;&gt;&lt;/html&gt;"
    assert replay._repr_html_() == f'<iframe srcdoc="{page}" style="width:100%;height:300px;border:0"></iframe>'
    replay.save(tmp_path / "r.html")
    assert (tmp_path / "r.html").read_text() == replay.page

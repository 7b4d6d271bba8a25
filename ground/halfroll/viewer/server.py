"""A page that this machine alone sees. Why: a page with a button that lands a vehicle answers to nobody but who opened
it: it is bound to loopback, its websocket takes pages of its own only, and nothing of it goes out to be shared.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from functools import partial
from typing import Any

import viser
from rich import get_console
from websockets.asyncio import server as websocket_server

from halfroll.errors import LinkError

LOOPBACK = "127.0.0.1"
DEFAULT_PORT = 8090


class LocalServer(viser.ViserServer):
    """A viser server on loopback. port: the first free one from there on. Raises LinkError."""

    def __init__(self, port: int = DEFAULT_PORT, label: str = "halfroll") -> None:
        origins: list[str] = []
        try:
            with _only(origins), _silent():
                super().__init__(host=LOOPBACK, port=port, label=label, verbose=False)
        except OSError as error:
            raise LinkError(f"no page at port {port}: {error.strerror}; choose another with --port") from error
        origins += [f"http://{host}:{self.get_port()}" for host in (LOOPBACK, "localhost")]

    @property
    def url(self) -> str:
        return f"http://{LOOPBACK}:{self.get_port()}"

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Nothing is shared: viser would tunnel the page through a machine of its authors."""
        return None

    def stop(self) -> None:
        with _silent():
            super().stop()


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """viser prints a box of addresses, and that it has stopped, in notebooks even as figures of their own."""
    out = get_console()
    before, out.quiet = out.quiet, True
    try:
        yield
    finally:
        out.quiet = before


@contextlib.contextmanager
def _only(origins: list[str]) -> Iterator[None]:
    """Websockets opened meanwhile take handshakes of these origins alone, which may be filled in later: viser has no
    word for it, and a browser lets any page of the internet talk to loopback."""
    serve: Any = websocket_server.serve
    websocket_server.serve = partial(serve, origins=origins)  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        websocket_server.serve = serve  # type: ignore[misc]

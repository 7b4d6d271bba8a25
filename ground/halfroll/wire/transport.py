"""Bytes to and from an autopilot, and the wall clock.

Why: sockets and clocks are arguments everywhere else, so a test flies without either. The wall clock serves only what
happens on the wall: repeating what was lost, heartbeats, and the measured rate; the vehicle's time comes by link.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import socket
import termios
import time
from collections import deque
from collections.abc import Sequence
from typing import Protocol

from halfroll.errors import InputError, LinkError, PortInUse

LOOPBACK = "127.0.0.1"
DEFAULT_BAUD = 921600
_LARGEST_DATAGRAM = 65535


class Transport(Protocol):
    """Where a link's bytes go: a datagram may hold several frames, and may be lost."""

    def send(self, datagram: bytes) -> None: ...

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        """Every datagram that is there, after waiting at most timeout_s for the first."""
        ...


class Clock(Protocol):
    def __call__(self) -> float: ...


def wall_s() -> float:
    """Monotonic wall clock [s]."""
    return time.monotonic()


def bound_socket(port: int) -> socket.socket:
    """A UDP socket bound to the loopback interface; port 0 takes any free one. Raises PortInUse."""
    sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        sock.bind((LOOPBACK, port))
    except OSError as error:
        sock.close()
        if error.errno != errno.EADDRINUSE:
            raise LinkError(f"UDP port {port} cannot be opened: {error.strerror}; choose another port") from error
        raise PortInUse(
            f"UDP port {port} is taken by another program (a ground station or another flight?); end that one, "
            "or choose other ports with --instance"
        ) from error
    return sock


class UdpTransport:
    """One UDP socket on the loopback interface, talking to one peer: a given one, or the first that sends something."""

    def __init__(self, sock: socket.socket, peer: tuple[str, int] | None = None) -> None:
        self._socket = sock
        self._socket.setblocking(False)
        self._peer = peer

    @classmethod
    def bind(cls, port: int, peer: tuple[str, int] | None = None) -> UdpTransport:
        """Raises PortInUse."""
        return cls(bound_socket(port), peer)

    @property
    def port(self) -> int:
        return int(self._socket.getsockname()[1])

    @property
    def name(self) -> str:
        return f"UDP port {self.port}"

    def forget_peer(self) -> None:
        """Talk to whoever sends next."""
        self._peer = None

    def fileno(self) -> int:
        return self._socket.fileno()

    def send(self, datagram: bytes) -> None:
        """Lost without a word, as any datagram may be, while there is no peer or its port is closed."""
        if self._peer is not None:
            try:
                self._socket.sendto(datagram, self._peer)
            except (ConnectionRefusedError, BlockingIOError):
                return

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        if timeout_s > 0.0:
            select.select([self._socket], [], [], timeout_s)
        datagrams: list[bytes] = []
        while True:
            try:
                datagram, sender = self._socket.recvfrom(_LARGEST_DATAGRAM)
            except BlockingIOError:
                return datagrams
            except ConnectionRefusedError:  # an earlier send met a closed port
                continue
            if self._peer is None:
                self._peer = sender
            if sender == self._peer:
                datagrams.append(datagram)

    def close(self) -> None:
        self._socket.close()


class SerialTransport:
    """A serial line, to the one autopilot at its end."""

    def __init__(self, port: str) -> None:
        """port: DEVICE or DEVICE:BAUD, 921600 by default. Raises InputError for a rate there is not, LinkError."""
        device, _, baud = port.partition(":")
        speed = getattr(termios, f"B{baud or DEFAULT_BAUD}", None)
        if speed is None:
            raise InputError(f"serial port {port}: {baud} is no baud rate of this machine; try {DEFAULT_BAUD}")
        try:
            self._file = os.open(device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            mode = termios.tcgetattr(self._file)
            mode[0] = mode[1] = mode[3] = 0  # raw: no byte means anything
            mode[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
            mode[4] = mode[5] = speed
            termios.tcsetattr(self._file, termios.TCSANOW, mode)
        except (OSError, termios.error) as error:
            raise LinkError(f"serial port {device} cannot be opened ({error}); is it there, and yours?") from error
        self.name = f"serial port {device}"

    def forget_peer(self) -> None:
        """There is only one."""

    def fileno(self) -> int:
        return self._file

    def send(self, datagram: bytes) -> None:
        """Lost without a word where the line cannot take it at once."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._file, datagram)

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        if timeout_s > 0.0:
            select.select([self._file], [], [], timeout_s)
        try:
            received = os.read(self._file, _LARGEST_DATAGRAM)
        except BlockingIOError:
            return []
        return [received] if received else []

    def close(self) -> None:
        os.close(self._file)


def wait_for_any(transports: Sequence[UdpTransport | SerialTransport], timeout_s: float) -> None:
    """Sleep until one of them has something to read, at most timeout_s."""
    select.select(transports, [], [], timeout_s)


class MemoryTransport:
    """One end of a pair inside one process: what one sends the other receives, at once and in order."""

    def __init__(self, inbox: deque[bytes], outbox: deque[bytes]) -> None:
        self._inbox, self._outbox = inbox, outbox

    @classmethod
    def pair(cls) -> tuple[MemoryTransport, MemoryTransport]:
        here: deque[bytes] = deque()
        there: deque[bytes] = deque()
        return cls(here, there), cls(there, here)

    def send(self, datagram: bytes) -> None:
        self._outbox.append(datagram)

    def receive(self, timeout_s: float = 0.0) -> list[bytes]:
        datagrams = list(self._inbox)
        self._inbox.clear()
        return datagrams

"""Where one MAVLink frame ends and the next begins. Why: the link's quick way and the recording cut alike."""

from __future__ import annotations

from collections.abc import Iterator

HEADER, CHECKSUM = 10, 2  # bytes of a MAVLink 2 frame before and behind its payload
_MAGIC, _SIGNED, _SIGNATURE = 0xFD, 1, 13
_MAGIC_1, _HEADER_1 = 0xFE, 6


def frames(datagram: bytes) -> Iterator[bytes]:
    """The whole MAVLink frames of a datagram, in order; what is none is left out."""
    at = 0
    while at < len(datagram) - 2:
        if datagram[at] == _MAGIC:
            size = HEADER + datagram[at + 1] + CHECKSUM + (_SIGNATURE if datagram[at + 2] & _SIGNED else 0)
        elif datagram[at] == _MAGIC_1:
            size = _HEADER_1 + datagram[at + 1] + CHECKSUM
        else:
            at += 1
            continue
        if at + size <= len(datagram):
            yield datagram[at : at + size]
        at += size


def only_plain(datagram: bytes) -> list[bytes] | None:
    """The frames of a datagram that is whole unsigned MAVLink 2 frames and nothing else; None for any other."""
    found = list(frames(datagram))
    plain = all(frame[0] == _MAGIC and frame[2] == 0 for frame in found)
    return found if plain and sum(map(len, found)) == len(datagram) else None

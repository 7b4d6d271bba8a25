"""Datagrams on the loopback interface."""

from __future__ import annotations

import pytest

from halfroll.errors import PortInUse
from halfroll.wire.transport import LOOPBACK, MemoryTransport, UdpTransport


@pytest.fixture
def listener():
    with_any_port = UdpTransport.bind(0)
    yield with_any_port
    with_any_port.close()


@pytest.fixture
def caller(listener):
    transport = UdpTransport.bind(0, peer=(LOOPBACK, listener.port))
    yield transport
    transport.close()


def test_the_peer_is_whoever_sends_first(listener, caller):
    caller.send(b"hello")
    assert listener.receive(5.0) == [b"hello"]
    listener.send(b"and you")
    assert caller.receive(5.0) == [b"and you"]


def test_nobody_else_is_heard_once_the_peer_is_known(listener, caller):
    caller.send(b"first")
    assert listener.receive(5.0) == [b"first"]
    stranger = UdpTransport.bind(0, peer=(LOOPBACK, listener.port))
    stranger.send(b"me too")
    stranger.close()
    caller.send(b"second")
    assert listener.receive(5.0) == [b"second"]


def test_everything_that_waits_is_read_at_once_and_in_order(listener, caller):
    for number in range(5):
        caller.send(bytes([number]))
    assert listener.receive(5.0) == [bytes([number]) for number in range(5)]
    assert listener.receive() == []


def test_sending_to_a_closed_port_or_to_nobody_is_no_error(listener, caller):
    listener.send(b"nobody is there yet")
    gone = UdpTransport.bind(0)
    port = gone.port
    gone.close()
    lonely = UdpTransport.bind(0, peer=(LOOPBACK, port))
    for _ in range(3):
        lonely.send(b"is there anybody?")
        assert lonely.receive() == []
    lonely.close()


def test_a_taken_port_is_named_with_a_way_out(listener):
    with pytest.raises(PortInUse, match=rf"{listener.port}.*--instance") as caught:
        UdpTransport.bind(listener.port)
    assert caught.value.exit_code == 3


def test_a_pair_in_memory_keeps_order_and_forgets_what_was_read():
    here, there = MemoryTransport.pair()
    here.send(b"a")
    here.send(b"b")
    assert there.receive() == [b"a", b"b"]
    assert there.receive() == []
    assert here.receive() == []

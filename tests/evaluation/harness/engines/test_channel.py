"""Messages arrive whole whatever way they are sent, and nobody waits for one that never does."""

import os
from multiprocessing import Pipe

import pytest

from indoor_explorers.evaluation.harness.engines.channel import Channel


@pytest.fixture
def ends():
    ours, theirs = Pipe()
    yield Channel(ours, 10_000_000), theirs
    ours.close()
    theirs.close()


def test_messages_come_and_go_as_those_of_a_connection(ends):
    channel, other = ends
    for message in (b"one", b"", b"three"):
        other.send_bytes(message)
    channel.transfer()
    assert [channel.message() for _ in range(4)] == [b"one", b"", b"three", None]
    channel.send(b"answer")
    assert other.recv_bytes() == b"answer"


def test_a_message_in_parts_is_none_until_its_end(ends):
    channel, other = ends
    for part in (b"\0\0", b"\0\3", b"ab"):
        os.write(other.fileno(), part)
        channel.transfer()
        assert channel.message() is None
    channel.transfer()  # nothing there
    os.write(other.fileno(), b"c")
    channel.transfer()
    assert channel.message() == b"abc"


def test_a_long_message_waits_until_it_is_read(ends):
    channel, other = ends
    channel.send(long := bytes(3_000_000))
    writes, read = channel.events, b""
    while len(read) < len(long) + 4:
        read += os.read(other.fileno(), 1 << 16)
        channel._write()
    assert read[4:] == long
    assert channel.events < writes


@pytest.mark.parametrize("header", [b"\x7f\xff\xff\xff", b"\xff\xff\xff\xff"])
def test_messages_that_are_too_long_are_refused(header, ends):
    channel, other = ends
    os.write(other.fileno(), header)
    channel.transfer()
    with pytest.raises(ValueError, match="expected a message of at most 10000000 bytes"):
        channel.message()


def test_the_end_is_told(ends):
    channel, other = ends
    other.close()
    channel.send(b"to nobody")
    with pytest.raises(EOFError):
        channel.transfer()

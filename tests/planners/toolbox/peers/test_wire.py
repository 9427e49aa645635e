"""A message comes back as it was, and bytes that are none are refused."""

import json
from typing import Any

import numpy as np
import pytest

from indoor_explorers.planners.toolbox.peers import wire


def _back(message: bytes) -> dict[str, Any]:
    head, body = wire.lengths(message[: wire.PREFIX.size])
    rest = message[wire.PREFIX.size :]
    assert len(rest) == head + body
    return wire.unpacked(rest[:head], rest[head:])


def test_values_and_arrays_come_back_at_any_depth() -> None:
    arrays = [
        np.arange(6, dtype=np.uint8).reshape(2, 3)[:, ::-1],
        np.array([[1.5, np.inf]]),
        np.empty((0, 2), np.int64),
    ]
    back = _back(wire.packed({"map": arrays[0], "deep": [{"nodes": arrays[1]}, arrays[2]], "cell": (np.int64(3), 4.5)}))
    assert back["cell"] == [3, 4.5]
    for got, sent in zip((back["map"], back["deep"][0]["nodes"], back["deep"][1]), arrays, strict=True):
        assert (got.dtype, got.shape) == (sent.dtype, sent.shape)
        assert np.array_equal(got, sent)
        assert not got.flags.writeable


@pytest.mark.parametrize("value", [{1, 2}, np.array([None])], ids=["a set", "an array of objects"])
def test_what_cannot_be_sent_is_refused(value) -> None:
    with pytest.raises(TypeError, match="expected a JSON value or an array of numbers, got a"):
        wire.packed({"value": value})


@pytest.mark.parametrize(
    "prefix", [b"Traceback (most ", wire.PREFIX.pack(wire.MAGIC, 2, wire.LONGEST + 1)], ids=["text", "too long"]
)
def test_bytes_that_begin_no_message_are_refused(prefix: bytes) -> None:
    with pytest.raises(ValueError, match="expected a message that begins with b'IXP1'"):
        wire.lengths(prefix)


@pytest.mark.parametrize("array", [["|u1", [3], 0], ["|O", [1], 0], ["u1"], ["u1", [-1], 0], ["zzz", [1], 0], None])
def test_an_array_that_does_not_fit_its_bytes_is_refused(array) -> None:
    with pytest.raises(ValueError, match=r"."):
        wire.unpacked(json.dumps({"a": {"__array__": array}}).encode(), b"12")

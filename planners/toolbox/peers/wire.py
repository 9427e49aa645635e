"""Messages between two processes: a head in JSON, then the bytes of its arrays.

The process of a peer loads this file too, so it needs nothing but Python (3.8 or newer) and, once there are arrays,
numpy of any version. A message is, in this order:

- :data:`MAGIC`, 4 bytes;
- the length of the head, 4 bytes, and that of the body, 8 bytes, both big-endian and unsigned;
- the head: a JSON object in UTF-8, in which ``{"__array__": [dtype, shape, start]}`` stands for an array whose bytes
  begin at ``start`` of the body;
- the body: the arrays one after the other, in C order.
"""

from __future__ import annotations

import json
import struct
from typing import Any

#: What every message begins with; the digit is the version of the format.
MAGIC = b"IXP1"
#: The most bytes of a head or a body.
LONGEST = 1 << 30
PREFIX = struct.Struct("!4sIQ")
_KEY = "__array__"


def packed(values: dict[str, Any]) -> bytes:
    """Return the message of a dictionary of JSON values and numpy arrays, at any depth.

    Raises:
        TypeError: a value is neither.

    """
    body = bytearray()

    def replaced(value: Any) -> Any:
        if hasattr(value, "item") and getattr(value, "shape", None) == ():
            return value.item()
        if not hasattr(value, "tobytes") or value.dtype.hasobject:
            raise TypeError(f"expected a JSON value or an array of numbers, got a {type(value).__name__}")
        start = len(body)
        body.extend(value.tobytes())
        return {_KEY: [value.dtype.str, list(value.shape), start]}

    head = json.dumps(values, default=replaced).encode()
    return PREFIX.pack(MAGIC, len(head), len(body)) + head + bytes(body)


def lengths(prefix: bytes) -> tuple[int, int]:
    """Return the lengths of head and body from the first :attr:`PREFIX.size` bytes of a message.

    Raises:
        ValueError: they do not begin a message.

    """
    magic, head, body = PREFIX.unpack(prefix)
    if magic != MAGIC or max(head, body) > LONGEST:
        raise ValueError(f"expected a message that begins with {MAGIC!r}, got {prefix!r}")
    return head, body


def unpacked(head: bytes, body: bytes) -> dict[str, Any]:
    """Return the dictionary of a message; its arrays are read-only.

    Raises:
        ValueError: head and body do not fit each other, or are no message.

    """

    def restored(value: dict[str, Any]) -> Any:
        if _KEY not in value:
            return value
        import numpy as np

        kind, shape, start = value[_KEY]
        count = int(np.prod(shape))
        if count < 0:
            raise ValueError(f"expected lengths of 0 or more, got {shape}")
        return np.frombuffer(body, kind, count, start).reshape(shape)

    try:
        values = json.loads(head, object_hook=restored)
    except (TypeError, OverflowError, RecursionError) as error:
        raise ValueError(f"expected a message, got one with a damaged array: {error}") from error
    if not isinstance(values, dict):
        raise ValueError(f"expected an object, got a {type(values).__name__}")
    return values

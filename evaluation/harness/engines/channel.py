"""One end of a connection to a process that may send anything, slowly, in part or without end: it never blocks."""

from __future__ import annotations

import os
import select
import struct
from multiprocessing.connection import Connection

#: Bytes that are read at once.
CHUNK = 1 << 20
_SIZE = struct.Struct("!i")


class Channel:
    """Sends and receives messages, framed as the other end, a plain connection of multiprocessing, does below 2 GB."""

    def __init__(self, connection: Connection, longest: int) -> None:
        """Take over a connection; messages of more than ``longest`` bytes are refused."""
        self._connection, self._longest = connection, longest
        self._read, self._unsent = bytearray(), memoryview(b"")
        os.set_blocking(connection.fileno(), False)

    @property
    def events(self) -> int:
        """What there is to wait for."""
        return select.POLLIN | (select.POLLOUT if self._unsent else 0)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._connection.fileno()

    def send(self, message: bytes) -> None:
        """Send what can be sent at once, and the rest in :meth:`transfer`; nothing where nobody reads any more."""
        self._unsent = memoryview(bytes(self._unsent) + _SIZE.pack(len(message)) + message)
        self._write()

    def transfer(self) -> None:
        """Write and read what can be at once.

        Raises:
            EOFError: the other end is closed.

        """
        self._write()
        try:
            chunk = os.read(self.fileno(), CHUNK)
        except BlockingIOError:
            return
        except ConnectionResetError:
            chunk = b""
        if not chunk:
            raise EOFError
        self._read += chunk

    def message(self) -> bytes | None:
        """Return the next message, None while it is not complete.

        Raises:
            ValueError: it would be too long.

        """
        if len(self._read) < _SIZE.size:
            return None
        (size,) = _SIZE.unpack_from(self._read)
        if not 0 <= size <= self._longest:
            raise ValueError(f"expected a message of at most {self._longest} bytes, got one of {size}")
        end = _SIZE.size + size
        if len(self._read) < end:
            return None
        message = bytes(self._read[_SIZE.size : end])
        del self._read[:end]
        return message

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()

    def _write(self) -> None:
        try:
            while self._unsent:
                self._unsent = self._unsent[os.write(self.fileno(), self._unsent) :]
        except BlockingIOError:
            pass
        except (BrokenPipeError, ConnectionResetError):
            self._unsent = memoryview(b"")

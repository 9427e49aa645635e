"""A connection to an untrusted process that never blocks, whatever that sends, however slowly or incompletely."""

from __future__ import annotations

import os
import select
import struct
from multiprocessing.connection import Connection

#: Bytes that are read at once.
CHUNK = 1 << 20
_SIZE = struct.Struct("!i")


class Channel:
    """Sends and receives messages in the format of multiprocessing's connections for less than 2 GB."""

    def __init__(self, connection: Connection, longest: int) -> None:
        """Take over a connection; messages of more than ``longest`` bytes are refused."""
        self._connection, self._longest = connection, longest
        self._read, self._unsent = bytearray(), memoryview(b"")
        os.set_blocking(connection.fileno(), False)

    @property
    def events(self) -> int:
        """The poll events to wait for."""
        return select.POLLIN | (select.POLLOUT if self._unsent else 0)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._connection.fileno()

    def send(self, message: bytes) -> None:
        """Send as much as possible at once, and the rest in :meth:`transfer`; nothing if the other end is closed."""
        self._unsent = memoryview(bytes(self._unsent) + _SIZE.pack(len(message)) + message)
        self._write()

    def transfer(self) -> None:
        """Write and read as much as possible without waiting.

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
            ValueError: its length exceeds the limit.

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

"""ROS 2 bags: a folder with an SQLite file, or a packed ``.mcap``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from numpy.typing import NDArray
from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from indoor_explorers.evaluation.exports.episodes.messages import STORE

#: The version of the metadata. From 9 on they name qualities of service, which Humble cannot read.
VERSION: Literal[8, 9] = 8
#: No limit of time.
UNLIMITED = QosTime(0, 0)


def _qos(latched: bool) -> Qos:
    """Return how a topic is offered: reliable, and with its last message for those who come later if ``latched``."""
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if latched else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=UNLIMITED,
        lifespan=UNLIMITED,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=UNLIMITED,
        avoid_ros_namespace_conventions=False,
    )


class Bag:
    """A bag that is being written; a topic begins with its first message."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._connections: dict[str, Connection] = {}
        self._latest: dict[str, bytes] = {}

    def put(self, stamp: int, topic: str, message: Any, *, latched: bool = False) -> None:
        """Write a message at ``stamp`` nanoseconds."""
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic, message.__msgtype__, typestore=STORE, offered_qos_profiles=[_qos(latched)]
            )
        self._writer.write(self._connections[topic], stamp, STORE.serialize_cdr(message, message.__msgtype__))

    def is_new(self, topic: str, content: NDArray[Any]) -> bool:
        """Tell whether an array of any shape differs from that of the last call for this topic."""
        data = content.tobytes()
        new = self._latest.get(topic) != data
        self._latest[topic] = data
        return new


@contextmanager
def new_bag(folder: Path, facts: str, *, mcap: bool) -> Iterator[Bag]:
    """Give a bag to write to in ``folder``, which must not be there yet; ``facts`` go into its metadata."""
    writer = Writer(folder, version=VERSION, storage_plugin=StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3)
    if mcap:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    writer.set_custom_data("episode", facts)
    with writer:
        yield Bag(writer)

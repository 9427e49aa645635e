"""Topics of ROS 2 over DDS: mangled names and the quality of service of ROS, without a ROS installation."""

from __future__ import annotations

import os
import secrets
from typing import Any

from indoor_explorers.env.errors import InputError
from indoor_explorers.evaluation.robot.messages import new, type_of

try:
    from cyclonedds.core import DDSException, Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.internal import InvalidSample
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic
except ImportError as error:  # messages.py has told what to install
    raise InputError(str(error)) from error

#: Environment variable with the number of the DDS domain, as ROS reads it.
DOMAIN = "ROS_DOMAIN_ID"
#: Nanoseconds that a reliable writer waits for room.
_BLOCKED = 1_000_000_000


def quality(depth: int, *, latched: bool = False, reliable: bool = True, facts: bytes = b"") -> Qos:
    """Return a quality of service of ROS: keep the last ``depth`` messages; ``latched`` is transient local."""
    return Qos(
        Policy.Reliability.Reliable(_BLOCKED) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        Policy.DurabilityService(0, Policy.History.KeepLast(depth), -1, -1, -1),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.WriterDataLifecycle(autodispose=False),
        Policy.Userdata(facts),
    )


def taken(reader: DataReader[Any], most: int = 16) -> list[Any]:
    """Return the messages that have arrived on a topic, the oldest first."""
    return [message for message in reader.take(most) if not isinstance(message, InvalidSample)]


class Node:
    """Make the readers and writers of one process."""

    def __init__(self, namespace: str = "") -> None:
        """Join the domain of the environment; relative names get a namespace."""
        self._namespace = namespace
        number = os.environ.get(DOMAIN) or "0"
        if not number.isdigit() or int(number) > 232:
            raise InputError(f"expected {DOMAIN} from 0 to 232, got {number!r}")
        try:
            self.participant = DomainParticipant(int(number))
        except DDSException as error:
            raise InputError(f"expected to join DDS domain {number}, got {error}; see CYCLONEDDS_URI") from error

    def full(self, name: str) -> str:
        """Return a name with its namespace; one that begins with a slash has its own."""
        return name if name.startswith("/") else f"/{self._namespace}/{name}".replace("//", "/")

    def reader(self, kind: str, name: str, quality: Qos, prefix: str = "rt", suffix: str = "") -> DataReader[Any]:
        """Return a reader of a topic; ``prefix`` and ``suffix`` are ``rt``, or ``rq`` and ``Request`` and the like."""
        return DataReader(self.participant, self._topic(kind, prefix + self.full(name) + suffix), qos=quality)

    def writer(self, kind: str, name: str, quality: Qos, prefix: str = "rt", suffix: str = "") -> DataWriter[Any]:
        """Return a writer of a topic."""
        return DataWriter(self.participant, self._topic(kind, prefix + self.full(name) + suffix), qos=quality)

    def _topic(self, kind: str, name: str) -> Topic[Any]:
        return Topic(self.participant, name, type_of(kind))


class Client:
    """Call a service without waiting for its answers."""

    def __init__(self, node: Node, kind: str, name: str) -> None:
        self._kind = kind
        self._guid, self._number = secrets.randbits(64), 0
        facts = quality(10, facts=f"clientid={self._guid:x};".encode())
        self._out = node.writer(f"{kind}_Request", name, facts, "rq", "Request")
        self._in = node.reader(f"{kind}_Response", name, facts, "rr", "Reply")

    @property
    def is_matched(self) -> bool:
        """Whether a server is there, both ways."""
        return bool(self._out.get_matched_subscriptions() and self._in.get_matched_publications())

    def call(self, **fields: Any) -> int:
        """Send a request; return its number."""
        self._number += 1
        self._out.write(new(f"{self._kind}_Request", guid=self._guid, seq=self._number, **fields))
        return self._number

    def answers(self) -> list[Any]:
        """Return the answers to this client that have arrived."""
        return [answer for answer in taken(self._in) if answer.guid == self._guid]


class Server:
    """Answer the requests of a service."""

    def __init__(self, node: Node, kind: str, name: str) -> None:
        self._kind = kind
        facts = quality(10, facts=f"serviceid={secrets.token_hex(8)};".encode())
        self._in = node.reader(f"{kind}_Request", name, facts, "rq", "Request")
        self._out = node.writer(f"{kind}_Response", name, facts, "rr", "Reply")

    def requests(self) -> list[Any]:
        """Return the requests that have arrived."""
        return taken(self._in)

    def answer(self, request: Any, **fields: Any) -> None:
        """Answer a request."""
        self._out.write(new(f"{self._kind}_Response", guid=request.guid, seq=request.seq, **fields))

"""Bags read back by a library that did not write them, and the episodes that they are of."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation import Record, Results
from indoor_explorers.evaluation.harness.episodes.resimulate import recorded_scenario

POLICIES = ("frontier-nearest", "frontier")
#: Metres a cell of the map "hall", and its cells.
RESOLUTION, SHAPE = 0.5, (18, 27)
SECOND = 1_000_000_000


class Message(NamedTuple):
    """A message of a bag."""

    topic: str
    kind: str
    stamp: int
    data: bytes
    content: Any


def record_of(results: Results, policy: str, map: str, seed: int) -> tuple[Record, Scenario]:
    """The episode, and its scenario."""
    (record,) = (
        each for each in results.records if (each.policy, each.floorplan.name, each.task.seed) == (policy, map, seed)
    )
    return record, recorded_scenario(results.scenarios[record.task.scenario])


def messages(path: Path) -> Iterator[Message]:
    """The messages of an .mcap file, or of a folder with a .db3, in their order."""
    decoders: dict[str, Any] = {}
    for topic, kind, definition, stamp, data in _raw_mcap(path) if path.is_file() else _raw_sqlite(path):
        if kind not in decoders:
            schema = Schema(id=1, name=kind, encoding="ros2msg", data=definition)
            decoders[kind] = DecoderFactory().decoder_for("cdr", schema)
        yield Message(topic, kind, stamp, data, decoders[kind](data))


def _raw_mcap(path: Path) -> Iterator[tuple[str, str, bytes, int, bytes]]:
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            yield channel.topic, schema.name, schema.data, message.log_time, message.data


def _raw_sqlite(path: Path) -> Iterator[tuple[str, str, bytes, int, bytes]]:
    (file,) = path.glob("*.db3")
    query = (
        "SELECT name, type, encoded_message_definition, timestamp, data FROM messages"
        " JOIN topics ON topics.id = topic_id JOIN message_definitions ON topic_type = type ORDER BY messages.id"
    )
    with closing(sqlite3.connect(file)) as database:
        for topic, kind, definition, stamp, data in database.execute(query):
            yield topic, kind, definition.encode(), stamp, data


def by_step(found: list[Message], seconds: float = 1.0) -> dict[str, dict[int, Any]]:
    """The contents by topic and step; every episode starts at one second."""
    topics: dict[str, dict[int, Any]] = defaultdict(dict)
    for message in found:
        step = (message.stamp - SECOND) / (seconds * SECOND)
        assert abs(step - round(step)) < 1e-6
        assert round(step) not in topics[message.topic]
        topics[message.topic][round(step)] = message.content
    return topics


def latest(held: dict[int, Any], step: int) -> Any:
    """The last content up to a step."""
    return held[max(when for when in held if when <= step)]

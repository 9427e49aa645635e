"""Results to export from, and bags read back by a library that did not write them."""

from __future__ import annotations

import sqlite3
from collections import defaultdict
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from PIL import Image

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation import Record, Results, compare, exports
from indoor_explorers.evaluation.episodes.resimulate import recorded_scenario

POLICIES = ("frontier-nearest", "frontier")
#: Metres a cell of the map, and its cells.
RESOLUTION, SHAPE = 0.5, (18, 27)
#: A team that is in contact now and then.
SETTINGS = {"radio.model": "disc", "radio.range": 6.0, "radio.loss": 0.2, "lidar.range": 4.0, "spawn": "clustered"}
SECOND = 1_000_000_000


class Message(NamedTuple):
    """A message of a bag."""

    topic: str
    kind: str
    stamp: int
    data: bytes
    content: Any


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Results of two policies, two seeds and two maps, of which one says how large its cells are."""
    here = tmp_path_factory.mktemp("episodes")
    free = np.full(SHAPE, 254, np.uint8)
    free[[0, -1]] = free[:, [0, -1]] = free[4:14, 8] = free[11, 8:20] = free[6:8, 22:24] = 0
    Image.fromarray(free).save(here / "hall.png")
    (here / "hall.yaml").write_text(
        f"image: hall.png\nresolution: {RESOLUTION}\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    Image.fromarray(free[:, :15]).save(here / "room.png")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exports, "write_figures", lambda results, folder: [])
        maps = [here / "hall.yaml", here / "room.png"]
        options = {"policies": POLICIES, "maps": maps, "team": 3, "episodes": 2, "workers": 0, "settings": SETTINGS}
        compare(here / "results", **options)
    return here / "results"


@pytest.fixture(scope="session")
def results(folder):
    return Results.load(folder)


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

"""Which message of an episode goes to which topic, and when.

Poses, frames, scans and coverage are written at every step; grids, frontiers and links when they change; paths, each of
which repeats the one before, about a hundred times. UAVs that have ended are silent.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from indoor_explorers.env import Scenario
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.interfaces.ros import CUBE_LIST, LINE_LIST
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.rendering.palette import INK, uav_colours
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.env.sensing.rays import first_hits
from indoor_explorers.evaluation.exports.episodes.messages import NANOSECONDS, STORE, Messages, uav_frame
from indoor_explorers.evaluation.exports.episodes.moments import Moment, facts_of, frame_of, moments
from indoor_explorers.evaluation.harness.episodes.flight import Told
from indoor_explorers.evaluation.harness.episodes.record import Record

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


#: Nanoseconds at which every episode starts: time 0 means "the latest" in tf.
START = NANOSECONDS
#: Directions of the rays of a scan, in the frame of the UAV.
RAYS = np.linspace(-math.pi, math.pi, 360, endpoint=False)
#: Approximate number of paths of a UAV.
PATHS = 100


def write_bag(
    record: Record, scenario: Scenario, folder: Path, step_seconds: float, *, mcap: bool, told: Told | None = None
) -> None:
    """Write an episode as a bag into ``folder``, which is made, with what is ``told`` about its moves."""
    with new_bag(folder, json.dumps(facts_of(record, step_seconds)), mcap=mcap) as bag:
        topics = _Topics(bag, record, scenario, step_seconds)
        for moment in moments(record, scenario):
            topics.write(moment)
            if told is not None and moment.step:
                topics.explain(moment, next(told))


class _Topics:
    """The topics of one episode."""

    def __init__(self, bag: Bag, record: Record, scenario: Scenario, step_seconds: float) -> None:
        self._bag, self._record, self._lidar_range = bag, record, scenario.lidar.range
        self._frame, self._step_seconds = frame_of(record), step_seconds
        self._stamp, self._messages = START, Messages(self._frame, START)
        self._poses: list[list[Any]] = [[] for _ in range(record.team)]
        self._ranges: dict[Cell, NDArray[np.float64]] = {}
        self._told: list[Explanation | None] = [None] * record.team

    def write(self, moment: Moment) -> None:
        """Write the messages of a moment."""
        self._stamp = START + round(moment.step * self._step_seconds * NANOSECONDS)
        messages = self._messages = Messages(self._frame, self._stamp)
        flying = np.flatnonzero(moment.flew).tolist()
        if moment.step == 0:
            self._keep("/true_map", messages.map(self._record.floorplan.truth))
        self._put("/tf", messages.frames({uav: moment.believed[uav].tolist() for uav in flying}))
        self._put("/coverage", messages.number(moment.coverage))
        if self._bag.is_new("/map", moment.team):
            self._keep("/map", messages.map(moment.team))
        ends = moment.cells[np.argwhere(np.triu(moment.linked))].reshape(-1, 2)
        if self._bag.is_new("/links", ends):
            self._keep("/links", messages.markers("links", LINE_LIST, ends, np.array(INK, np.uint8)))
        for uav in flying:
            self._write_uav(moment, uav)
        for uav in range(self._record.team):
            self._write_path(moment, uav)

    def explain(self, moment: Moment, told: list[Explanation | None]) -> None:
        """Write why the UAVs that flew fly where they do, where it has changed."""
        colours = uav_colours(self._record.team)
        for uav in np.flatnonzero(moment.flew).tolist():
            if told[uav] != self._told[uav]:
                self._keep(f"/{uav_frame(uav)}/explanation", self._messages.explanation(told[uav], colours[uav]))
                self._told[uav] = told[uav]

    def _write_uav(self, moment: Moment, uav: int) -> None:
        """Write where a UAV is, whom it hears, what its lidar measures and what it knows."""
        messages, name, belief = self._messages, f"/{uav_frame(uav)}", moment.beliefs[uav]
        row, col = moment.cells[uav].tolist()
        self._put(f"{name}/pose", messages.pose(moment.believed[uav].tolist()))
        for mate in np.flatnonzero(moment.heard[uav]).tolist():
            self._put(f"{name}/heard/{uav_frame(mate)}", messages.pose(moment.believed[mate].tolist()))
        ranges = self._scanned((row, col))
        self._put(f"{name}/scan", messages.scan(uav, ranges, self._lidar_range, self._step_seconds))
        if self._bag.is_new(f"{name}/map", belief):
            self._keep(f"{name}/map", messages.map(belief))
            cells = np.argwhere(frontier_mask(belief, self._frame.levels.rise))
            colour = uav_colours(self._record.team)[uav]
            self._keep(f"{name}/frontiers", messages.markers("frontiers", CUBE_LIST, cells, colour))

    def _write_path(self, moment: Moment, uav: int) -> None:
        """Write the path so far now and then, and at the end of the episode."""
        name, steps = f"/{uav_frame(uav)}/path", self._record.steps
        if self._bag.is_new(name, moment.believed[uav]):
            self._poses[uav].append(self._messages.pose(moment.believed[uav].tolist()))
        if moment.step % (1 + steps // PATHS) == 0 or moment.step == steps:
            self._keep(name, self._messages.path(self._poses[uav]))

    def _scanned(self, cell: Cell) -> NDArray[np.float64]:
        """Return (RAYS,) ranges in cells that a lidar in a cell measures on its level."""
        if cell not in self._ranges:
            level, *place = self._frame.levels.voxels(np.array(cell)).tolist()
            truth = np.ascontiguousarray(self._frame.levels.volume(self._record.floorplan.truth)[level])
            self._ranges[cell] = first_hits(truth, (place[0], place[1]), self._lidar_range, RAYS)
        return self._ranges[cell]

    def _put(self, topic: str, message: Any) -> None:
        self._bag.put(self._stamp, topic, message)

    def _keep(self, topic: str, message: Any) -> None:
        """Write a message that those who listen later are to have as well."""
        self._bag.put(self._stamp, topic, message, latched=True)

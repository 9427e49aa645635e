"""Simulates a recorded episode again and packs it for the replay.

A replay needs moves, radio contacts and new cells. Linked UAVs merge their maps, so that the map of each UAV follows
from what its group discovered and from the contacts; the page repeats that merging. A home base takes part like another
UAV that stays where it is. What the team knows is what those know together that have not stopped. Where sensors or
poses err, the replay has the team's map alone, and which of its cells are right and wrong.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from indoor_explorers.env import UNKNOWN, Scenario, World
from indoor_explorers.env.grid.arrays import Belief, Cell
from indoor_explorers.env.rendering.scene import base_links, with_base
from indoor_explorers.env.simulation.state import End
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.resimulate import ended_as_recorded, resimulate
from indoor_explorers.evaluation.report.packing import Keyed, folded, packed, runs


class Revisions:
    """The changes of some (H * W,) masks over time; every mask is empty before the first step."""

    def __init__(self, size: int, masks: int) -> None:
        self._now = np.zeros((masks, size), np.bool_)
        self._steps: list[list[NDArray[np.int64]]] = [[] for _ in range(masks)]

    def add(self, masks: list[NDArray[np.bool_]]) -> None:
        """Note the masks after one step more."""
        for place, mask in enumerate(masks):
            self._steps[place].append(np.flatnonzero(self._now[place] != mask))
            self._now[place] = mask

    def by_frame(self, shown: NDArray[np.int64]) -> list[Keyed]:
        """Return for each mask the cells that changed since the frame before, as runs; frames are steps (F,)."""
        listed = np.arange(len(shown))
        return [self._runs(changes, shown, listed) for changes in self._steps]

    def _runs(self, changes: list[NDArray[np.int64]], shown: NDArray[np.int64], listed: NDArray[np.int64]) -> Keyed:
        lengths = [len(cells) for cells in changes]
        frames = np.repeat(np.searchsorted(shown, np.arange(len(changes))), lengths)
        size = self._now.shape[1]
        keys, times = np.unique(frames * size + np.concatenate(changes), return_counts=True)
        keys = keys[times % 2 == 1]  # what changed there and back between two frames did not change
        return runs(keys // size, keys % size, listed)


def masks_of(world: World) -> list[NDArray[np.bool_]]:
    """Return what the team's map shows rightly and wrongly in place 0, and what the base's map shows rightly."""
    state, truth = world.state, world.state.truth[0]
    team = state.union[0]
    masks = [team == truth, (team != truth) & (team != UNKNOWN)]
    return [mask.ravel() for mask in (*masks, *([state.base_belief[0] == truth] if world.scenario.base.exists else []))]


#: Step of cells that never become known, and of UAVs that never stop.
NEVER = np.iinfo(np.int32).max


@dataclass(frozen=True, eq=False)
class ReplayEpisode:
    """What each of N UAVs, and the home base, knew at each of S steps of an episode on H x W cells.

    M is N, or N + 1 with a base, which comes last.
    """

    record: Record
    counted: NDArray[np.bool_]
    """(H * W,) the cells that coverage counts."""
    known: NDArray[np.int32]
    """(M, H * W) the step from which each own map held each cell, ``NEVER`` for those it never held."""
    linked: NDArray[np.bool_]
    """(S + 1, M, M) which were in radio contact after each step; the base is with the nearest UAV of each group."""
    stopped: NDArray[np.int32]
    """(M,) the step at which a failure stopped each, ``NEVER`` for those that it did not."""
    base: Cell | None
    """The home base's (row, column); None where there is none."""
    prior: Belief | None
    """(H, W) the prior map; None where there is none."""
    revisions: Revisions | None
    """What the team's map shows rightly and wrongly, and the base's rightly, where maps can be wrong."""
    faithful: bool
    """Whether it ended as recorded; it may not if another version of the world recorded it."""


def resimulated(record: Record, scenario: Scenario) -> ReplayEpisode:
    """Simulate a record's episode again and note when cells became known."""
    team, count = record.team, record.team + scenario.base.exists
    known = np.full((count, record.floorplan.truth.size), NEVER, np.int32)
    linked = np.zeros((record.steps + 1, count, count), np.bool_)
    stopped = np.full(count, NEVER, np.int32)
    read = [0] * count
    revisions = Revisions(known.shape[1], 2 + scenario.base.exists) if scenario.uncertain else None
    for step, world in enumerate(resimulate(record, scenario)):
        linked[step] = _links(world)
        stopped[:team][(world.state.end[0] == End.STOPPED) & (stopped[:team] == NEVER)] = step
        if revisions is not None:
            revisions.add(masks_of(world))
        for place, (log, length) in enumerate(_logs(world)):
            known[place, log[read[place] : length]] = step
            read[place] = length
    return ReplayEpisode(
        record=record,
        counted=world.state.counts[0].ravel().copy(),
        known=known,
        linked=linked,
        stopped=stopped,
        base=world.briefing(0, 0).base,
        prior=world.prior(0),
        revisions=revisions,
        faithful=ended_as_recorded(record, world),
    )


def _links(world: World) -> NDArray[np.bool_]:
    """Return (M, M) which UAVs are in radio contact, and with a base which of them lead to it."""
    state = world.state
    if not world.scenario.base.exists:
        return np.asarray(state.linked[0])
    voxels = world.briefing(0, 0).levels.voxels
    leads = base_links(state.linked[0], state.base_contact[0], voxels(state.cell[0]), voxels(state.base_cell[0]))
    return with_base(state.linked[0], leads)


def _logs(world: World) -> Iterator[tuple[NDArray[np.int32], int]]:
    """Yield the discovery log of each UAV, and of the base, with its length."""
    state = world.state
    yield from zip(state.discovery_log[0], state.known[0].tolist(), strict=True)
    if world.scenario.base.exists:
        yield state.base_log[0], int(state.base_known[0])


def frame_steps(steps: int, stride: int) -> list[int]:
    """Return the steps that are shown: every ``stride``-th and the last."""
    return [*range(0, steps, stride), steps]


def pack_episode(flight: ReplayEpisode, stride: int, *, own: bool = True) -> bytes:
    """Pack an episode frame by frame, with each UAV's ``own`` map, or only with the maps of the team and the base.

    A frame is a list of whole numbers: the moves of each UAV (row, column; folded), the cells flown and the bytes sent
    since the frame before, the contacts that began or ended, and for each group of those linked, ordered by its first
    one, the cells that none of it knew before. Without ``own`` the whole team is one group and the base another, and in
    frames in which a UAV stops the cells that the team loses come before. Where maps can be wrong there are instead the
    cells that change whether the team's map shows them rightly, or wrongly, or the base's map rightly.
    """
    shown = np.array(frame_steps(flight.record.steps, stride))
    linked = flight.linked[shown]
    known, stopped = np.searchsorted(shown, flight.known), np.searchsorted(shown, flight.stopped)
    parts = [_contacts(linked)]
    if flight.revisions is not None:
        parts += flight.revisions.by_frame(shown)
    elif own:
        parts.append(_discoveries(known, first_of_group(linked)))
    else:
        parts += _of_team(known, stopped, len(shown))
        if flight.base is not None:
            parts.append(_discoveries(known[-1:], np.zeros((len(shown), 1), np.int64)))
    return packed(_spent(flight.record, shown).then(*parts).numbers)


def _spent(record: Record, shown: NDArray[np.int64]) -> Keyed:
    """Return by frame the moves, the cells flown and the bytes sent since the frame before."""
    cells = record.cells.astype(np.int64)[shown].reshape(len(shown), -1)
    moves = folded(np.diff(cells, axis=0, prepend=0))
    spent = np.diff(np.column_stack((record.distance, record.sent))[shown], axis=0, prepend=0)
    numbers = np.column_stack((moves, spent))
    return Keyed(np.repeat(np.arange(len(shown)), numbers.shape[1]), numbers.ravel())


def _contacts(linked: NDArray[np.bool_]) -> Keyed:
    """Return by frame the pairs whose contact began or ended, as runs over the upper triangle."""
    rows, columns = np.triu_indices(linked.shape[1], 1)
    changed = np.diff(linked[:, rows, columns], axis=0, prepend=False)
    frames, pairs = np.nonzero(changed)
    return runs(frames, pairs, np.arange(len(linked)))


def _discoveries(frames: NDArray[np.int64], firsts: NDArray[np.int64]) -> Keyed:
    """Return by frame, for each group, the cells that none of it knew before, as runs.

    Args:
        frames: (M, H * W) the frame from which each knows each cell; beyond the last for never.
        firsts: (F, M) the first one of each one's group.

    """
    count, team = firsts.shape
    speakers = firsts == np.arange(team)
    keys, places = [], []
    for uav in range(team):
        cells = np.flatnonzero(frames[uav] < count)
        when = frames[uav, cells]
        news = (firsts[when] != uav) | (when[:, None] <= frames[:, cells].T)
        sent = speakers[when, uav] & news.all(axis=1)
        keys.append(when[sent] * team + uav)
        places.append(cells[sent])
    found = runs(np.concatenate(keys), np.concatenate(places), np.flatnonzero(speakers))
    return Keyed(found.keys // team, found.numbers)


def _of_team(frames: NDArray[np.int64], stopped: NDArray[np.int64], count: int) -> list[Keyed]:
    """Return by frame the cells that the team loses, where a UAV stops, and those that it newly knows, as runs.

    Args:
        frames: (M, H * W) the frame from which each knows each cell; beyond the last for never.
        stopped: (M,) the frame in which each stopped; beyond the last for never.
        count: number of frames.

    """
    stops = np.unique(stopped[stopped < count])
    lost, gained = [], []
    before = np.zeros(frames.shape[1], np.bool_)
    for first, end in zip([0, *stops], [*stops, count], strict=True):
        union = frames[stopped > first].min(axis=0, initial=count)  # of those that go on
        here = union <= first
        lost.append((np.flatnonzero(before & ~here), first))
        gained.append((np.flatnonzero(here & ~before), first))
        later = np.flatnonzero((union > first) & (union < end))
        gained.append((later, union[later]))
        before = union < end
    return [_runs_of(lost[1:], stops), _runs_of(gained, np.arange(count))]


def _runs_of(parts: list[tuple[NDArray[np.int64], Any]], listed: NDArray[np.int64]) -> Keyed:
    """Return cells, given with their frames, as runs by frame."""
    places = [cells for cells, _ in parts]
    keys = [np.broadcast_to(frame, cells.shape) for cells, frame in parts]
    nothing = np.zeros(0, np.int64)
    return runs(np.concatenate([nothing, *keys]), np.concatenate([nothing, *places]), listed)


def first_of_group(linked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return (F, M) for each the first one of the group that contacts (F, M, M) put it into."""
    patterns, places = np.unique(linked.reshape(len(linked), -1), axis=0, return_inverse=True)
    team = linked.shape[1]
    labels = (connected_components(pattern.reshape(team, team), directed=False)[1] for pattern in patterns)
    firsts = [np.unique(each, return_index=True)[1][each] for each in labels]
    return np.asarray(firsts, np.int64)[places]

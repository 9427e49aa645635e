"""Simulates a recorded episode again and packs it for the replay.

A replay needs moves, radio contacts and new cells. Linked UAVs merge their maps, so that the map of each UAV follows
from what its group discovered and from the contacts; the page repeats that merging.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation.episodes.record import Record
from indoor_explorers.evaluation.episodes.resimulate import ended_as_recorded, resimulate
from indoor_explorers.evaluation.report.style.packing import Keyed, folded, packed, runs

#: Step of cells that never become known.
NEVER = np.iinfo(np.int32).max


@dataclass(frozen=True, eq=False)
class ReplayEpisode:
    """What each of N UAVs knew at each of S steps of an episode on H x W cells."""

    record: Record
    counted: NDArray[np.bool_]
    """(H * W,) the cells that coverage counts."""
    known: NDArray[np.int32]
    """(N, H * W) the step from which each UAV's own map held each cell, ``NEVER`` for those it never held."""
    linked: NDArray[np.bool_]
    """(S + 1, N, N) which UAVs were in direct radio contact after each step."""
    faithful: bool
    """Whether it ended as recorded; it may not if another version of the world recorded it."""


def resimulated(record: Record, scenario: Scenario) -> ReplayEpisode:
    """Simulate a record's episode again and note when cells became known."""
    known = np.full((record.team, record.floorplan.truth.size), NEVER, np.int32)
    linked = np.zeros((record.steps + 1, record.team, record.team), np.bool_)
    read = [0] * record.team
    for step, world in enumerate(resimulate(record, scenario)):
        state = world.state
        linked[step] = state.linked[0] | np.outer(state.base_contact[0], state.base_contact[0])
        for agent, length in enumerate(state.known[0].tolist()):
            known[agent, state.discovery_log[0, agent, read[agent] : length]] = step
            read[agent] = length
    return ReplayEpisode(record, state.counts[0].ravel().copy(), known, linked, ended_as_recorded(record, world))


def frame_steps(steps: int, stride: int) -> list[int]:
    """Return the steps that are shown: every ``stride``-th and the last."""
    return [*range(0, steps, stride), steps]


def pack_episode(flight: ReplayEpisode, stride: int, *, own: bool = True) -> bytes:
    """Pack an episode frame by frame, with each UAV's ``own`` map or with the team's alone.

    A frame is a list of whole numbers: the moves of each UAV (row, column; folded), the cells flown and the bytes sent
    since the frame before, the radio contacts that began or ended, and for each group of linked UAVs, ordered by its
    first UAV, the cells that none of it knew before. Without ``own`` the whole team is one group.
    """
    shown = np.array(frame_steps(flight.record.steps, stride))
    linked = flight.linked[shown]
    known = flight.known if own else flight.known.min(axis=0, keepdims=True)
    firsts = first_of_group(linked) if own else np.zeros((len(shown), 1), np.int64)
    parts = _contacts(linked), _discoveries(np.searchsorted(shown, known), firsts)
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
        frames: (N, H * W) the frame from which each UAV knows each cell; beyond the last for never.
        firsts: (F, N) the first UAV of each one's group.

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


def first_of_group(linked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return (F, N) for each UAV the first one of the group that radio contacts (F, N, N) put it into."""
    patterns, places = np.unique(linked.reshape(len(linked), -1), axis=0, return_inverse=True)
    team = linked.shape[1]
    labels = (connected_components(pattern.reshape(team, team), directed=False)[1] for pattern in patterns)
    firsts = [np.unique(each, return_index=True)[1][each] for each in labels]
    return np.asarray(firsts, np.int64)[places]

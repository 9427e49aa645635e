"""The policies ``ariadne``, ``ir2`` and ``marvel``: published networks of a user's clone, flown in this world."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE, UNREACHABLE
from indoor_explorers.env.policies.policy import TRAINED_GOAL, Policy
from indoor_explorers.env.policies.view import Briefing, Message, View
from indoor_explorers.learners.attention.network import Weights
from indoor_explorers.learners.attention.pilot import PATIENCE, NodePilot
from indoor_explorers.learners.published import ariadne, ir2, marvel
from indoor_explorers.learners.published.checkpoint import Published
from indoor_explorers.learners.published.lattice import walks
from indoor_explorers.learners.published.network import scores
from indoor_explorers.learners.published.sighted import Observation
from indoor_explorers.learners.sessions.record import digest_of
from indoor_explorers.planners.toolbox.navigation.teammates import claims, linked, remembered
from indoor_explorers.planners.toolbox.networks.weights_file import read_once

#: The last nodes of its way that an IR2 pilot tells the others, with its goal: a message has at most 16 numbers.
TOLD = 7


class PublishedPilot(NodePilot):
    """Fly to the node of highest score among the neighbours of the UAV's node, and choose again there."""

    def __init__(self, briefing: Briefing, policy: PublishedPolicy) -> None:
        super().__init__(briefing, patience=policy.PATIENCE if policy.guard else inf)
        self._weights, self._sizes = policy.weights(), policy.NETWORK.sizes
        self._graph = policy.GRAPH(briefing.shape, briefing.lidar_range)
        self._left = 0

    @abstractmethod
    def observe(self, view: View) -> Observation:
        """Return what the network sees."""

    def chosen_node(self, view: View) -> Cell | None:
        """Return the legal node of highest score; None if no useful node is reachable over the edges."""
        seen = self.observe(view)
        length, _ = walks(seen.cells, seen.near, seen.own)
        worth = seen.useful & np.isfinite(length) & (np.arange(len(length)) != seen.own)
        flat = seen.cells[np.maximum(seen.options, 0)] @ (self.paths.width, 1)
        near = self.steps_from(view, view.cell).ravel()[flat] < UNREACHABLE
        legal = seen.legal & near & ~self.near_banned(view, flat.astype(np.int32))
        if not worth.any() or not legal.any():
            self._left += 1
            return None
        found = scores(seen, self._weights, self._sizes).reshape(len(legal), -1).max(axis=1)
        among = np.where(legal, found, -np.inf)
        self.consider(flat, "network's score", among)
        return divmod(int(flat[among.argmax()]), self.paths.width)

    def tally(self) -> dict[str, float]:
        """Return the tally of every such pilot, and how often the network had nothing to choose."""
        return super().tally() | {"choices_without_a_node": float(self._left)}


class AriadnePilot(PublishedPilot):
    """Explore alone, with the teammates' maps: ARiADNE has one robot."""

    def observe(self, view: View) -> Observation:
        """Return the informative graph."""
        seen: Observation = self._graph.observe(view.belief, view.cell)
        return seen


class MarvelPilot(PublishedPilot):
    """Explore with teammates, whose places the network sees and whose goals the choice leaves to them."""

    def observe(self, view: View) -> Observation:
        """Return the graph with teammates' places."""
        mates = [mate.cell for mate in remembered(view, self.briefing)]
        goals = [(int(row), int(col)) for row, col in claims(view, self.briefing)]
        seen: Observation = self._graph.observe(view.belief, view.cell, mates, goals)
        return seen


class Ir2Pilot(PublishedPilot):
    """Explore in a team, tell the way flown so far, and meet teammates again who lack much of the map."""

    def __init__(self, briefing: Briefing, policy: PublishedPolicy) -> None:
        super().__init__(briefing, policy)
        self._known_since: NDArray[np.int32] = np.full(briefing.shape, -1, np.int32)
        self._way: list[Cell] = []

    def act(self, view: View) -> int:
        """Follow the path to the chosen node; tell the teammates which, and the latest nodes of the way."""
        action = super().act(view)
        self._graph.routes.add([cell for mate in linked(view) for cell in _told(mate.message)])
        numbers = [*(self.goal or (-1, -1)), *(number for cell in self._way[-TOLD:] for number in cell)]
        self.message = tuple(map(float, numbers))
        return action

    def on_map_growth(self, view: View) -> None:
        """Store since when cells are known to be free."""
        super().on_map_growth(view)
        self._known_since[(view.belief == FREE) & (self._known_since < 0)] = view.step

    def observe(self, view: View) -> Observation:
        """Return the graph with teammates' places, and what those out of contact do not know."""
        self._way += [view.cell] if self._way[-1:] != [view.cell] else []
        mates = {
            mate.cell: float(np.mean(self._known_since > view.step - mate.age)) if mate.age else 0.0
            for mate in remembered(view, self.briefing)
        }
        seen: Observation = self._graph.observe(view.belief, view.cell, mates)
        return seen


def _told(message: Message) -> list[Cell]:
    """Return the nodes of the way in a teammate's message."""
    numbers = list(map(int, message or ()))[2:]
    return list(zip(numbers[::2], numbers[1::2], strict=False))


@dataclass(frozen=True, kw_only=True)
class PublishedPolicy(Policy):
    """A published network, read from a clone of its repository and flown by modules of this package.

    Nothing of the clone is executed: the files that the modules were written from are compared with those of the
    commit, and the checkpoint is read as data.

    Raises:
        InputError: ``clone`` is no clone at the commit, or its checkpoint is missing or holds another network.

    """

    plans_for: ClassVar[str] = TRAINED_GOAL
    NETWORK: ClassVar[Published]
    GRAPH: ClassVar[Any]
    PILOT: ClassVar[type[PublishedPilot]]
    PATIENCE: ClassVar[float] = PATIENCE

    path: str
    """Path of the clone."""
    guard: bool = True
    """Fly to the nearest frontier after a flight of six lidar ranges without new cells, of twelve for IR2."""

    def __post_init__(self) -> None:
        code = self.NETWORK.code
        if not self.path:
            raise InputError(f"expected a clone, as in NAME:DIR, got none; fetch it with `{code.how_to_fetch}`")
        code.checked(self.path)
        self.weights()

    @property
    def checkpoint(self) -> Path:
        """The path of the checkpoint."""
        return expanded(self.path) / self.NETWORK.checkpoint

    def weights(self) -> Weights:
        """Return the weights; a process reads the checkpoint once."""
        return _reader(type(self))(self.checkpoint)

    def pilot(self, briefing: Briefing) -> PublishedPilot:
        """Make the pilot of one UAV for one episode."""
        return self.PILOT(briefing, self)

    def provenance(self) -> dict[str, str]:
        """Return the repository, its commit and the hash of the checkpoint."""
        code = self.NETWORK.code
        return {"clone": f"{code.url}@{code.commit[:7]}", "weights_sha256": digest_of(self.checkpoint)}


class Ariadne(PublishedPolicy):
    """Fly ARiADNE's released network: ``ariadne:DIR`` (Cao et al., ICRA 2023, arXiv:2301.11575)."""

    NETWORK, GRAPH, PILOT = ariadne.NETWORK, ariadne.AriadneGraph, AriadnePilot


class Ir2(PublishedPolicy):
    """Fly IR2's released network: ``ir2:DIR`` (Tan et al., IROS 2024, arXiv:2409.04730)."""

    NETWORK, GRAPH, PILOT, PATIENCE = ir2.NETWORK, ir2.Ir2Graph, Ir2Pilot, 2 * PATIENCE  # ways to teammates are long


class Marvel(PublishedPolicy):
    """Fly MARVEL's released network: ``marvel:DIR`` (Chiun et al., ICRA 2025, arXiv:2502.20217)."""

    NETWORK, GRAPH, PILOT = marvel.NETWORK, marvel.MarvelGraph, MarvelPilot


@lru_cache
def _reader(kind: type[PublishedPolicy]) -> Callable[[Path], Weights]:
    """Return the function that reads the checkpoints of a policy."""
    return read_once(kind.NETWORK.read)

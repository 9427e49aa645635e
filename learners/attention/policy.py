"""The policy ``attention-sac``, and its pilot, which flies from node to node of the graph of viewpoints."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Cell, Mask
from indoor_explorers.env.policies.policy import TRAINED_GOAL, Policy
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.learners.attention.graph import USEFUL, Graph, Surroundings, known_graph, unknown_in_view
from indoor_explorers.learners.attention.network import Loaded, load_weights, scores
from indoor_explorers.learners.attention.pilot import PATIENCE, NodePilot
from indoor_explorers.learners.sessions.record import RecordedWeights, digest_of
from indoor_explorers.planners.toolbox.navigation.teammates import claims, remembered
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS
from indoor_explorers.planners.toolbox.networks.weights_file import weights_path

#: The weights that ship, by the seed of their training.
SHIPPED = {seed: Path(__file__).parent / "weights" / f"attention-{seed}.safetensors" for seed in (1, 2, 3)}


class AttentionPilot(NodePilot):
    """Choose among the neighbours of the UAV's node, fly to the chosen one, and choose again there.

    Args:
        briefing: Briefing of the UAV.
        loaded: The network.
        guard: Whether to choose no node twice while the map does not grow, and to fly to the nearest frontier where the
            UAV oscillates and after a long flight without new cells.

    """

    def __init__(self, briefing: Briefing, loaded: Loaded, *, guard: bool) -> None:
        super().__init__(briefing, patience=PATIENCE if guard else inf)
        self._loaded, self._guard = loaded, guard
        self._chosen: list[int] = []
        """Cells of the nodes that were chosen since the map last grew."""

    def on_map_growth(self, view: View) -> None:
        """Forget which nodes were chosen."""
        super().on_map_growth(view)
        self._chosen = []

    def chosen_node(self, view: View) -> Cell | None:
        """Return the neighbour with the highest score; with the guard, one that was not chosen since the map grew.

        The guard leaves a UAV that oscillates without a choice.
        """
        if self._guard and self.navigator.oscillates:
            return None
        graph = self.observe(view)
        options = graph.neighbours[0]
        allowed = (options >= 0) & ~self.near_banned(view, graph.cells[options])
        if self._guard:
            allowed &= ~np.isin(graph.cells[options], self._chosen)
        if not allowed.any() or not graph.features[:, USEFUL].any():
            return None
        self._chosen.append(int(graph.cells[options[self.pick(view, graph, allowed)]]))
        return divmod(self._chosen[-1], self.paths.width)

    def is_spent(self, view: View, goal: Cell) -> bool:
        """Tell whether the goal is reached, or the map has grown and no unknown cell is in view of it any more."""
        return super().is_spent(view, goal) or (self.map_grew and not self.shows_unknown(view, goal))

    def shows_unknown(self, view: View, cell: Cell) -> bool:
        """Tell whether unknown cells are in view of a cell."""
        node = np.array([cell[0] * self.paths.width + cell[1]], np.int32)
        return bool(unknown_in_view(view.belief, node, float(self.briefing.lidar_range))[0])

    def surroundings(self, view: View) -> Surroundings:
        """Return what the graph tells of teammates."""
        mates = tuple(mate.cell for mate in remembered(view, self.briefing))
        goals = tuple((row, col) for row, col in claims(view, self.briefing).tolist())
        return Surroundings(float(self.briefing.lidar_range), view.visited, mates, goals)

    def observe(self, view: View) -> Graph:
        """Return the graph of the known map."""
        steps = self.steps_from(view, view.cell)
        return known_graph(view.belief, view.cell, steps, self.surroundings(view), self._loaded.graph)

    def pick(self, view: View, graph: Graph, allowed: Mask) -> int:
        """Return which neighbour of node 0 has the highest score, among those ``allowed`` (K,)."""
        found = np.where(allowed, scores(graph, self._loaded), -np.inf)
        self.consider(graph.cells[graph.neighbours[0]], "network's score", found)
        return int(found.argmax())


def probabilities(found: NDArray[np.float32], allowed: Mask) -> NDArray[np.float64]:
    """Return the probabilities (K,) of a stochastic policy with scores (K,), among those ``allowed`` (K,)."""
    shares = np.exp(np.where(allowed, found, -np.inf).astype(np.float64) - found[allowed].max())
    return np.asarray(shares / shares.sum())


@dataclass(frozen=True, kw_only=True)
class AttentionSac(RecordedWeights, Policy):
    """Fly from node to node of a graph of viewpoints, as a graph attention network chooses.

    ARiADNE: Cao et al., ICRA 2023, arXiv:2301.11575; trained by discrete soft actor-critic (Christodoulou 2019,
    arXiv:1910.07207) with a privileged critic (Cao et al., RA-L 2024, arXiv:2403.10833). One and more UAVs, each by its
    own map, with the same weights. Only the draws among equally near frontier cells and of deadlocks are random.

    Raises:
        InputError: ``weights`` is missing or not a file of this network, or no weights ship of that ``training``.

    """

    plans_for: ClassVar[str] = TRAINED_GOAL

    weights: str | None = None
    """Path of a training's folder or weights; None: shipped ones."""
    training: int = 1
    """Seed of the training whose weights ship: 1, 2 or 3."""
    guard: bool = True
    """Choose no node twice while the map does not grow, and fly to the nearest frontier when oscillating between two
    cells, and after a flight of six lidar ranges without new cells."""

    def __post_init__(self) -> None:
        if self.training not in SHIPPED:
            known = ", ".join(map(str, SHIPPED))
            raise InputError(f"AttentionSac: expected training to be one of {known}, got {self.training!r}")
        load_weights(self.path)

    @property
    def path(self) -> Path:
        """The path of the weights."""
        return weights_path(self.weights, SHIPPED[self.training], WEIGHTS)

    def pilot(self, briefing: Briefing) -> AttentionPilot:
        """Make the pilot of one UAV for one episode."""
        return AttentionPilot(briefing, load_weights(self.path), guard=self.guard)

    def provenance(self) -> dict[str, str]:
        """Return the hash of the weights."""
        return {"weights_sha256": digest_of(self.path)}

    def weights_paths(self) -> list[Path]:
        """Return the path of the weights."""
        return [self.path]


def opened(path: str, **parameters: Any) -> AttentionSac:
    """Return the policy of a trained network, ``attention:DIR``."""
    return AttentionSac(weights=path, **parameters)

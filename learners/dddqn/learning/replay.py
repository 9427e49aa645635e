"""Experience replay (Mnih et al. 2015): a ring buffer of time slots, with one column for each UAV in training.

Transitions are sampled uniformly, or by the priority of their latest TD error (Schaul et al. 2016, arXiv:1511.05952).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.learners.dddqn.learning.sum_tree import SumTree
from indoor_explorers.learners.dddqn.learning.targets import look_forward
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import (
    SYMMETRIES,
    ObservationLayout,
    observation_layout,
    symmetries,
)

#: Added to absolute errors, so that a transition with none keeps a priority above zero.
LEAST_ERROR = 1e-3
#: Largest episode age that is stored.
MOST_AGE = 2**16 - 1
Places = NDArray[np.int64]


class Tick(NamedTuple):
    """One tick of all C UAVs in training; the ring buffer holds T ticks, (T, C, ...)."""

    scene: NDArray[np.uint8]
    """(C, S) latest scene of the state, without the stacked earlier ones."""
    moves: NDArray[np.floating[Any]]
    """(C, 4, F) move features of the state; the ring buffer stores them in half precision."""
    action: NDArray[np.integer[Any]]
    """(C,) move made in the state."""
    reward: NDArray[np.floating[Any]]
    """(C,) reward of the move."""
    terminal: Mask
    """(C,) whether the move terminated the episode."""
    explored: Mask
    """(C,) whether the move was drawn at random."""
    over: Mask
    """(C,) whether the episode had ended before: the state is its final one, and no move was made."""
    age: NDArray[np.integer[Any]]
    """(C,) ticks since the episode began."""


class Batch(NamedTuple):
    """B sampled transitions, each under a random symmetry of the grid if that is enabled."""

    scenes_BI: Tensor
    moves_BAF: Tensor
    action_B: Tensor
    return_B: Tensor
    discount_B: Tensor
    next_scenes_BI: Tensor
    next_moves_BAF: Tensor
    weight_B: Tensor
    """Importance-sampling weights; 1 with uniform replay."""
    place: Places
    """(B,) slot * C + column of each, slots counted from the first one ever; for :meth:`Replay.reprioritise`."""


def _empty(slots: int, columns: int, layout: ObservationLayout) -> Tick:
    place = (slots, columns)
    return Tick(
        scene=np.zeros((*place, layout.scene), np.uint8),
        moves=np.zeros((*place, 4, layout.features), np.float16),
        action=np.zeros(place, np.uint8),
        reward=np.zeros(place, np.float32),
        terminal=np.zeros(place, np.bool_),
        explored=np.zeros(place, np.bool_),
        over=np.zeros(place, np.bool_),
        age=np.zeros(place, np.uint16),
    )


@kernel()
def _stacked_scenes(
    scene: np.ndarray,
    age: np.ndarray,
    slot: np.ndarray,
    column: np.ndarray,
    table: np.ndarray,
    turn: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write the stacked scenes of each state, latest first; early in an episode its first scene is repeated."""
    slots, size = scene.shape[0], scene.shape[2]
    for i in range(slot.shape[0]):
        c, order = column[i], table[turn[i]]
        for frame in range(out.shape[1] // size):
            source = scene[(slot[i] - min(frame, np.int64(age[slot[i], c]))) % slots, c]
            for k in range(size):
                out[i, frame * size + k] = source[order[k]] * np.float32(1.0 / 255.0)


class Replay:
    """Keep the latest ``slots`` ticks of ``columns`` UAVs and sample transitions from them.

    ``prioritised`` is the exponent of the TD error in a transition's priority; 0 is uniform replay. A state whose
    stacked scenes have been overwritten in part is not sampled.
    """

    def __init__(
        self, slots: int, columns: int, observation: ObservationConfig, *, prioritised: float, symmetries: bool
    ) -> None:
        self.data = _empty(slots, columns, observation_layout(observation))
        self.written = 0
        self._observation, self._alpha, self._turns = observation, prioritised, SYMMETRIES if symmetries else 1
        self._tree = SumTree(slots * columns) if prioritised else None
        self._top = 1.0
        self._admitted = 0

    @property
    def filled(self) -> int:
        """Number of slots in use."""
        return min(self.written, len(self.data.action))

    @property
    def _first(self) -> int:
        """Number of the oldest slot, counted from the first one ever, whose states have all their stacked scenes."""
        return max(self.written - len(self.data.action) + self._observation.frames - 1, 0)

    def ready(self, steps: int) -> int:
        """Return the number of slots that transitions of ``steps`` steps can begin in."""
        return max(self.written - steps - self._first, 0)

    def add(self, tick: Tick) -> None:
        """Write one tick over the oldest one."""
        at = self.written % len(self.data.action)
        new = tick._replace(age=np.minimum(tick.age, MOST_AGE))
        for name, kept in self.data._asdict().items():
            kept[at] = getattr(new, name)
        self.written += 1
        if self._tree is not None:
            self._prioritise(self._tree, self._first - 1, 0.0)

    def _prioritise(self, tree: SumTree, index: int, value: float) -> None:
        """Set the priority of all moves of the ``index``-th slot ever written; that of final states is 0."""
        slots, columns = self.data.action.shape
        at = index % slots
        tree.write(at * columns + np.arange(columns), np.where(self.data.over[at], 0.0, value))

    def _admit(self, tree: SumTree, last: int) -> None:
        """Give the highest priority to new slots before ``last``, whose n-step transitions are now complete."""
        for index in range(max(min(self._admitted, last), self._first), max(self._admitted, last)):
            self._prioritise(tree, index, self._top if index < last else 0.0)
        self._admitted = last

    def _uniform(self, size: int, steps: int, rng: np.random.Generator) -> Places:
        """Draw places of moves whose next ``steps`` slots are in the ring buffer."""
        slots, columns = self.data.action.shape
        slot, column = np.empty(size, np.int64), np.empty(size, np.int64)
        todo = np.arange(size)
        while len(todo):
            slot[todo] = self._first + rng.integers(self.ready(steps), size=len(todo))
            column[todo] = rng.integers(columns, size=len(todo))
            todo = todo[self.data.over[slot[todo] % slots, column[todo]]]
        place: Places = slot * columns + column
        return place

    def _prioritised(
        self, tree: SumTree, size: int, steps: int, importance: float, rng: np.random.Generator
    ) -> tuple[Places, NDArray[np.float32]]:
        """Draw places by priority; return them and their importance-sampling weights."""
        self._admit(tree, self.written - steps)
        places = tree.draw(size, rng)
        weights = tree.values[places] ** -importance
        slots, columns = self.data.action.shape
        slot, column = np.divmod(places, columns)
        latest = self.written - 1
        return (latest - (latest - slot) % slots) * columns + column, (weights / weights.max()).astype(np.float32)

    def sample(
        self, size: int, steps: int, gamma: float, rng: np.random.Generator, *, importance: float = 0.0
    ) -> Batch:
        """Sample ``size`` transitions of up to ``steps`` steps, each under a random symmetry.

        ``importance`` is the exponent of the importance-sampling weights (beta of Schaul et al. 2016, section 3.4); the
        largest weight of a batch is 1. At least one slot must be :meth:`ready`.
        """
        if self._tree is None:
            place, weight = self._uniform(size, steps, rng), np.ones(size, np.float32)
        else:
            place, weight = self._prioritised(self._tree, size, steps, importance, rng)
        slots, columns = self.data.action.shape
        slot, column = place // columns % slots, place % columns
        turn = rng.integers(self._turns, size=size)
        returns, discount = np.empty(size, np.float32), np.empty(size, np.float32)
        after = np.empty(size, np.int64)
        data = self.data
        look_forward(
            data.reward, data.terminal, data.over, data.explored, slot, column, steps, gamma, returns, discount, after
        )
        action = symmetries(self._observation).action[turn, data.action[slot, column]]
        scenes_BI, moves_BAF = self._states(slot, column, turn)
        next_scenes_BI, next_moves_BAF = self._states(after, column, turn)
        return Batch(
            scenes_BI=scenes_BI,
            moves_BAF=moves_BAF,
            action_B=torch.from_numpy(action),
            return_B=torch.from_numpy(returns),
            discount_B=torch.from_numpy(discount),
            next_scenes_BI=next_scenes_BI,
            next_moves_BAF=next_moves_BAF,
            weight_B=torch.from_numpy(weight),
            place=place,
        )

    def _states(
        self, slot: NDArray[np.int64], column: NDArray[np.int64], turn: NDArray[np.int64]
    ) -> tuple[Tensor, Tensor]:
        tables = symmetries(self._observation)
        scenes = np.empty((len(slot), observation_layout(self._observation).inputs), np.float32)
        _stacked_scenes(self.data.scene, self.data.age, slot, column, tables.scene, turn, scenes)
        moves = self.data.moves[slot[:, None], column[:, None], tables.moves[turn]].astype(np.float32)
        return torch.from_numpy(scenes), torch.from_numpy(moves)

    def reprioritise(self, place: Places, errors: NDArray[np.floating[Any]]) -> None:
        """Set the priorities of sampled transitions by their TD errors (B,); does nothing in uniform replay."""
        if self._tree is None:
            return
        slots, columns = self.data.action.shape
        slot, column = np.divmod(place, columns)
        values = (np.abs(errors.astype(np.float64)) + LEAST_ERROR) ** self._alpha
        kept = (slot >= self._first) & (slot < self._admitted)
        self._tree.write((slot % slots * columns + column)[kept], values[kept])
        self._top = max(self._top, float(values.max()))

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        found = {f"replay/{name}": array[: self.filled] for name, array in self.data._asdict().items()}
        found["replay/counts"] = np.array([self.written, self._admitted])
        if self._tree is not None:
            found |= {"replay/priority": self._tree.values, "replay/top": np.array(self._top)}
        return found

    def restore(self, tensors: dict[str, NDArray[Any]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        self.written, self._admitted = tensors["replay/counts"].tolist()
        for name, array in self.data._asdict().items():
            array[: self.filled] = tensors[f"replay/{name}"]
        if self._tree is not None:
            self._tree.write(np.arange(self._tree.size), tensors["replay/priority"])
            self._top = float(tensors["replay/top"].item())

"""Experience replay (Mnih et al. 2015): a ring of time slots, one column for each UAV in training.

Transitions are drawn uniformly, or in proportion to their last error (Schaul et al. 2016, arXiv:1511.05952).
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

#: Added to errors, so that a transition without one may be drawn again.
LEAST_ERROR = 1e-3
#: Older episodes are kept as being this old.
MOST_AGE = 2**16 - 1
Places = NDArray[np.int64]


class Tick(NamedTuple):
    """One tick of all C UAVs in training; the ring holds T of them, (T, C, ...)."""

    scene: NDArray[np.uint8]
    """(C, S) the state's scene, alone."""
    moves: NDArray[np.floating[Any]]
    """(C, 4, F) its move features; the ring stores them in half precision."""
    action: NDArray[np.integer[Any]]
    """(C,) the move made there."""
    reward: NDArray[np.floating[Any]]
    """(C,) what it paid."""
    terminal: Mask
    """(C,) the reward ended the episode for good."""
    explored: Mask
    """(C,) the move was drawn at random."""
    over: Mask
    """(C,) the episode had ended before: the state is its final one and no move was made."""
    age: NDArray[np.integer[Any]]
    """(C,) ticks since the episode began."""


class Batch(NamedTuple):
    """B sampled transitions, each turned by a random symmetry of the world where that is switched on."""

    scenes_BI: Tensor
    moves_BAF: Tensor
    action_B: Tensor
    return_B: Tensor
    discount_B: Tensor
    next_scenes_BI: Tensor
    next_moves_BAF: Tensor
    weight_B: Tensor
    """How much each counts: 1, or less where it is drawn more often than others."""
    place: Places
    """(B,) where each is kept, counted from the first ever; for :meth:`Replay.reprioritise`."""


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
    """Write the latest scenes of each state, latest first; a young episode repeats its first."""
    slots, size = scene.shape[0], scene.shape[2]
    for i in range(slot.shape[0]):
        c, order = column[i], table[turn[i]]
        for frame in range(out.shape[1] // size):
            source = scene[(slot[i] - min(frame, np.int64(age[slot[i], c]))) % slots, c]
            for k in range(size):
                out[i, frame * size + k] = source[order[k]] * np.float32(1.0 / 255.0)


class Replay:
    """Keep the last ``slots`` ticks of ``columns`` UAVs and sample transitions from them.

    ``prioritised`` is the exponent of the error in a transition's priority; at 0 all are drawn alike. A state whose
    earlier scenes have been overwritten is not drawn.
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
        """Slots that hold something."""
        return min(self.written, len(self.data.action))

    @property
    def _first(self) -> int:
        """The first slot ever written whose state still has all its scenes."""
        return max(self.written - len(self.data.action) + self._observation.frames - 1, 0)

    def ready(self, steps: int) -> int:
        """Return how many slots can be drawn from when transitions take ``steps`` steps."""
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
        """Give all moves of the ``index``-th slot ever written one priority; final states have none."""
        slots, columns = self.data.action.shape
        at = index % slots
        tree.write(at * columns + np.arange(columns), np.where(self.data.over[at], 0.0, value))

    def _admit(self, tree: SumTree, last: int) -> None:
        """Give the slots before ``last`` that are new, whose transitions have become whole, the highest priority."""
        for index in range(max(min(self._admitted, last), self._first), max(self._admitted, last)):
            self._prioritise(tree, index, self._top if index < last else 0.0)
        self._admitted = last

    def _uniform(self, size: int, steps: int, rng: np.random.Generator) -> Places:
        """Draw places of moves whose next ``steps`` slots are in the ring."""
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
        """Draw places by priority; return them and their weights."""
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
        """Draw ``size`` transitions of up to ``steps`` steps, each turned at random.

        ``importance`` is the exponent that corrects for priorities (Schaul et al. 2016, section 3.4, beta); the largest
        weight of a batch is 1. At least one slot must be :meth:`ready`.
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
        """Set the priorities of sampled transitions by their errors (B,); without priorities, nothing happens."""
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
        """Go on exactly where :meth:`tensors` was taken."""
        self.written, self._admitted = tensors["replay/counts"].tolist()
        for name, array in self.data._asdict().items():
            array[: self.filled] = tensors[f"replay/{name}"]
        if self._tree is not None:
            self._tree.write(np.arange(self._tree.size), tensors["replay/priority"])
            self._top = float(tensors["replay/top"].item())

"""Uniform experience replay (Mnih et al. 2015): a ring of time slots, one column for each UAV in training."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from indoor_explorers.env.compiled import kernel
from indoor_explorers.learners.dddqn.observation import MOVE_FEATURES, SCENE
from indoor_explorers.learners.dddqn.symmetry import SYMMETRIES, symmetries
from indoor_explorers.learners.dddqn.targets import look_forward


class Slots(NamedTuple):
    """What the ring holds, T slots by C columns. One slot is one tick of all UAVs in training."""

    scene: NDArray[np.uint8]
    """(T, C, 696) the state's scene."""
    moves: NDArray[np.float16]
    """(T, C, 4, 8) its move features."""
    action: NDArray[np.uint8]
    """(T, C) the move made there."""
    reward: NDArray[np.float32]
    """(T, C) what it paid."""
    terminal: NDArray[np.bool_]
    """(T, C) the reward ended the episode for good."""
    explored: NDArray[np.bool_]
    """(T, C) the move was drawn at random."""
    over: NDArray[np.bool_]
    """(T, C) the episode had ended before: the state is its final one and no move was made."""


class Batch(NamedTuple):
    """B sampled transitions, each turned by a random symmetry of the world."""

    scene_BS: Tensor
    moves_BAF: Tensor
    action_B: Tensor
    return_B: Tensor
    discount_B: Tensor
    next_scene_BS: Tensor
    next_moves_BAF: Tensor


def empty_slots(slots: int, columns: int) -> Slots:
    """Allocate a ring."""
    place = (slots, columns)
    return Slots(
        scene=np.zeros((*place, SCENE), np.uint8),
        moves=np.zeros((*place, 4, len(MOVE_FEATURES)), np.float16),
        action=np.zeros(place, np.uint8),
        reward=np.zeros(place, np.float32),
        terminal=np.zeros(place, np.bool_),
        explored=np.zeros(place, np.bool_),
        over=np.zeros(place, np.bool_),
    )


@kernel()
def _turned_scenes(
    scene: np.ndarray, slot: np.ndarray, column: np.ndarray, table: np.ndarray, turn: np.ndarray, out: np.ndarray
) -> None:
    for i in range(slot.shape[0]):
        source, order = scene[slot[i], column[i]], table[turn[i]]
        for k in range(out.shape[1]):
            out[i, k] = source[order[k]] * np.float32(1.0 / 255.0)


class Replay:
    """Keep the last ``slots`` ticks of ``columns`` UAVs and sample transitions from them."""

    def __init__(self, slots: int, columns: int) -> None:
        self.data = empty_slots(slots, columns)
        self.written = 0

    @property
    def filled(self) -> int:
        """Slots that hold something."""
        return min(self.written, len(self.data.action))

    def add(
        self,
        scene: NDArray[np.uint8],
        moves: NDArray[np.float32],
        action: NDArray[np.int64],
        reward: NDArray[np.float64],
        terminal: NDArray[np.bool_],
        explored: NDArray[np.bool_],
        over: NDArray[np.bool_],
    ) -> None:
        """Write one tick of all columns over the oldest one."""
        at = self.written % len(self.data.action)
        slot = {"scene": scene, "moves": moves, "action": action, "reward": reward}
        slot |= {"terminal": terminal, "explored": explored, "over": over}
        for name, store in self.data._asdict().items():
            store[at] = slot[name]
        self.written += 1

    def _places(self, size: int, steps: int, rng: np.random.Generator) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Draw (slot, column) of ``size`` moves whose next ``steps`` slots are in the ring."""
        slots, columns = self.data.action.shape
        oldest, ready = self.written - self.filled, self.filled - steps
        slot, column = np.empty(size, np.int64), np.empty(size, np.int64)
        todo = np.arange(size)
        while len(todo):
            slot[todo] = (oldest + rng.integers(ready, size=len(todo))) % slots
            column[todo] = rng.integers(columns, size=len(todo))
            todo = todo[self.data.over[slot[todo], column[todo]]]
        return slot, column

    def sample(self, size: int, steps: int, gamma: float, rng: np.random.Generator) -> Batch:
        """Draw ``size`` transitions of up to ``steps`` steps uniformly, each turned at random."""
        slot, column = self._places(size, steps, rng)
        turn = rng.integers(SYMMETRIES, size=size)
        returns, discount = np.empty(size, np.float32), np.empty(size, np.float32)
        after = np.empty(size, np.int64)
        data = self.data
        look_forward(
            data.reward, data.terminal, data.over, data.explored, slot, column, steps, gamma, returns, discount, after
        )
        action = symmetries().action[turn, data.action[slot, column]]
        return Batch(
            *self._states(slot, column, turn),
            torch.from_numpy(action),
            torch.from_numpy(returns),
            torch.from_numpy(discount),
            *self._states(after, column, turn),
        )

    def _states(
        self, slot: NDArray[np.int64], column: NDArray[np.int64], turn: NDArray[np.int64]
    ) -> tuple[Tensor, Tensor]:
        tables = symmetries()
        scene = np.empty((len(slot), SCENE), np.float32)
        _turned_scenes(self.data.scene, slot, column, tables.scene, turn, scene)
        moves = self.data.moves[slot[:, None], column[:, None], tables.moves[turn]].astype(np.float32)
        return torch.from_numpy(scene), torch.from_numpy(moves)

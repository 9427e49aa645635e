"""The dueling network (Wang et al. 2016) over the observation."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from indoor_explorers.learners.dddqn.observation import MOVE_FEATURES, SCENE

#: Units of both hidden layers, and of the small net that every move shares.
WIDTH, MOVE_WIDTH = 256, 16


class DuelingNetwork(nn.Module):
    """Map scenes and move features to the values of the four moves.

    The scene is encoded first; the move features join it in the second layer. A small network shared by
    the moves adds what each move's own features say to its advantage.
    """

    def __init__(self) -> None:
        super().__init__()
        features = len(MOVE_FEATURES)
        self.look = nn.Linear(SCENE, WIDTH)
        self.look_norm = nn.LayerNorm(WIDTH)
        self.think = nn.Linear(WIDTH + 4 * features, WIDTH)
        self.think_norm = nn.LayerNorm(WIDTH)
        self.value = nn.Linear(WIDTH, 1)
        self.advantage = nn.Linear(WIDTH, 4)
        self.move_hidden = nn.Linear(features, MOVE_WIDTH)
        self.move_out = nn.Linear(MOVE_WIDTH, 1)

    def forward(self, scene_BS: Tensor, moves_BAF: Tensor) -> Tensor:
        """Return q_BA for ``scene_BS`` (B, 696) and ``moves_BAF`` (B, 4, 8), both float32."""
        look_BW = torch.relu(self.look_norm(self.look(scene_BS)))
        think_BW = torch.relu(self.think_norm(self.think(torch.cat([look_BW, moves_BAF.flatten(1)], dim=1))))
        own_BA = self.move_out(torch.relu(self.move_hidden(moves_BAF))).squeeze(2)
        return duel(self.value(think_BW), self.advantage(think_BW) + own_BA)


def duel(value_B1: Tensor, advantage_BA: Tensor) -> Tensor:
    """Return q_BA = V + A - mean over the actions of A (Wang et al. 2016, eq. 9)."""
    return value_B1 + advantage_BA - advantage_BA.mean(dim=1, keepdim=True)


def new_network(seed: int) -> DuelingNetwork:
    """Return a network initialised from ``seed`` alone; torch's global generator is left as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return DuelingNetwork()

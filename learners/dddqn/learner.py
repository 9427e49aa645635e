"""One update of the dueling double deep Q-network."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from indoor_explorers.learners.dddqn.network import DuelingNetwork, new_network
from indoor_explorers.learners.dddqn.replay import Batch
from indoor_explorers.learners.dddqn.targets import double_q_target, masked

#: Place of the feature that says a move is blocked.
BLOCKED = 0


class Learner:
    """Hold the online, target, averaged and best networks and the optimiser."""

    def __init__(self, seed: int, learning_rate: float) -> None:
        self.online = new_network(seed)
        self.target = copy.deepcopy(self.online).requires_grad_(False)
        self.average = copy.deepcopy(self.target)
        self.best = copy.deepcopy(self.target)
        self.optimiser = torch.optim.Adam(self.online.parameters(), lr=learning_rate, fused=True)

    def update(self, batch: Batch, *, rate: float, clip: float, target_rate: float, average_rate: float) -> Tensor:
        """Learn from one batch with the step size ``rate``; return the loss, a scalar."""
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        loss = td_loss(self.online, self.target, batch)
        self.optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(self.online.parameters(), clip)
        self.optimiser.step()
        follow(self.target, self.online, target_rate)
        follow(self.average, self.online, average_rate)
        return loss.detach()

    def networks(self) -> dict[str, DuelingNetwork]:
        """Return the four networks by name."""
        return {"online": self.online, "target": self.target, "average": self.average, "best": self.best}

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        found: dict[str, NDArray[Any]] = {}
        for name, network in self.networks().items():
            found |= {f"{name}/{key}": value.numpy() for key, value in network.state_dict().items()}
        for place, entries in self.optimiser.state_dict()["state"].items():
            found |= {f"adam/{place}/{key}": value.numpy() for key, value in entries.items()}
        return found

    def restore(self, tensors: dict[str, NDArray[Any]]) -> None:
        """Go on exactly where :meth:`tensors` was taken."""
        for name, network in self.networks().items():
            network.load_state_dict({key: torch.from_numpy(tensors[f"{name}/{key}"]) for key in network.state_dict()})
        state: dict[int, dict[str, Tensor]] = {}
        for name, array in tensors.items():
            if name.startswith("adam/"):
                _, place, key = name.split("/")
                state.setdefault(int(place), {})[key] = torch.from_numpy(array)
        self.optimiser.load_state_dict(self.optimiser.state_dict() | {"state": state})


def td_loss(online: DuelingNetwork, target: DuelingNetwork, batch: Batch) -> Tensor:
    """Return the mean Huber loss of the chosen moves' values against their double-Q targets."""
    q_BA = online(batch.scene_BS, batch.moves_BAF)
    with torch.no_grad():
        next_state = batch.next_scene_BS, batch.next_moves_BAF
        blocked_BA = batch.next_moves_BAF[:, :, BLOCKED] > 0.5
        target_B = double_q_target(
            batch.return_B, batch.discount_B, online(*next_state), target(*next_state), blocked_BA
        )
    q_B = q_BA.gather(1, batch.action_B[:, None]).squeeze(1)
    return nn.functional.smooth_l1_loss(q_B, target_B)


@torch.no_grad()
def follow(network: DuelingNetwork, leader: DuelingNetwork, rate: float) -> None:
    """Move the weights of ``network`` a share ``rate`` of the way to those of ``leader``."""
    for own, other in zip(network.parameters(), leader.parameters(), strict=True):
        own.lerp_(other, rate)


@torch.no_grad()
def greedy(network: DuelingNetwork, scene: NDArray[np.uint8], moves: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the best legal moves (B,) for scenes (B, 696) and move features (B, 4, 8)."""
    moves_BAF = torch.from_numpy(moves)
    q_BA = network(torch.from_numpy(scene).float().mul_(1.0 / 255.0), moves_BAF)
    return np.asarray(masked(q_BA, moves_BAF[:, :, BLOCKED] > 0.5).argmax(dim=1).numpy())

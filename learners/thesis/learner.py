"""The thesis's dueling network and its updates, with the two mistakes in the targets.

Section 3.3 of the thesis gives the outline of the network; the sizes are those of its code.
"""

from __future__ import annotations

import copy
from typing import Any, Literal

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from indoor_explorers.learners.dddqn.learning.targets import q_target
from indoor_explorers.learners.sessions.networks import learner_tensors, restore_learner
from indoor_explorers.learners.thesis.config import TrainingConfig
from indoor_explorers.learners.thesis.inference import CONVOLUTIONS, DENSE, MOVES, ImageFormat
from indoor_explorers.learners.thesis.observation import LEVELS
from indoor_explorers.learners.thesis.replay import ThesisBatch


class ThesisNetwork(nn.Module):
    """Map images to the values of the four moves; 665,765 parameters for one image of 16x16 cells."""

    def __init__(self, image_format: ImageFormat, advantage_mean: Literal["batch", "actions"]) -> None:
        super().__init__()
        self.advantage_mean = advantage_mean
        rows, cols = image_format.view()
        layers, channels = [], image_format.frames
        for filters, side, stride in CONVOLUTIONS:
            layers.append(nn.Conv2d(channels, filters, side, stride))
            channels = filters
        self.convolutions = nn.ModuleList(layers)
        self.first = nn.Linear(channels * rows * cols, DENSE[0])
        self.second = nn.Linear(*DENSE)
        self.value = nn.Linear(DENSE[1], 1)
        self.advantage = nn.Linear(DENSE[1], MOVES)
        self._draw()

    def _draw(self) -> None:
        """Initialise as the thesis's library does: He-uniform before its dense ReLUs, else Glorot-uniform."""
        for layer in self.modules():
            if isinstance(layer, nn.Conv2d | nn.Linear):
                nn.init.zeros_(layer.bias)  # type: ignore[arg-type]  # all of them have one
                if layer in (self.first, self.second):
                    nn.init.kaiming_uniform_(layer.weight, nonlinearity="relu")
                else:
                    nn.init.xavier_uniform_(layer.weight)

    def forward(self, image_BKHW: Tensor) -> Tensor:
        """Return q_BA (B, 4) for images (B, K, H, W) of grey levels, both float32."""
        x = image_BKHW
        for layer in self.convolutions:
            x = torch.relu(layer(x))
        x = torch.relu(self.first(x.flatten(1)))
        x = torch.relu(self.second(x))
        return duel(self.value(x), self.advantage(x), self.advantage_mean)


def duel(value_B1: Tensor, advantage_BA: Tensor, mean: Literal["batch", "actions"]) -> Tensor:
    """Return q_BA (B, 4) = V (B, 1) + A (B, 4) - mean A.

    The mean is over the actions (Wang et al. 2016, eq. 9), or over the whole batch (a mistake).
    """
    if mean == "batch":
        return value_B1 + advantage_BA - advantage_BA.mean()
    return value_B1 + advantage_BA - advantage_BA.mean(dim=1, keepdim=True)


def new_network(image_format: ImageFormat, advantage_mean: Literal["batch", "actions"], seed: int) -> ThesisNetwork:
    """Return a network initialised from ``seed``; torch's global generator keeps its state."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return ThesisNetwork(image_format, advantage_mean)


#: Adam's epsilon in the thesis's library; torch's default is 1e-8.
ADAM_EPSILON = 1e-7


class ThesisLearner:
    """Hold the network, the target network and the optimiser."""

    def __init__(self, config: TrainingConfig, image_format: ImageFormat, seed: int) -> None:
        self.config = config
        self.online = new_network(image_format, config.advantage_mean, seed)
        self.target = copy.deepcopy(self.online).requires_grad_(False)
        parameters, rate = self.online.parameters(), config.learning_rate
        self.optimiser = torch.optim.Adam(parameters, lr=rate, eps=ADAM_EPSILON, fused=True)

    def start_from(self, arrays: dict[str, NDArray[np.float32]]) -> None:
        """Load the weights of another training, with the shapes of the network's format, into both networks."""
        state = {name: torch.from_numpy(array) for name, array in arrays.items()}
        self.online.load_state_dict(state)
        self.target.load_state_dict(state)

    def update(self, batch: ThesisBatch) -> Tensor:
        """Learn from one batch; return the loss, a scalar."""
        scaled = batch._replace(reward_B=batch.reward_B * self.config.reward_scale)
        config = self.config
        loss = td_loss(self.online, self.target, scaled, config.gamma, config.terminal_target, config.loss)
        self.optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        self.optimiser.step()
        return loss.detach()

    def copy_target(self) -> None:
        """Copy the online network to the target network."""
        self.target.load_state_dict(self.online.state_dict())

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        return learner_tensors(self._networks(), self.optimiser)

    def restore(self, tensors: dict[str, NDArray[Any]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        restore_learner(tensors, self._networks(), self.optimiser)

    def _networks(self) -> dict[str, ThesisNetwork]:
        return {"online": self.online, "target": self.target}


def td_targets(
    online: ThesisNetwork,
    target: ThesisNetwork,
    batch: ThesisBatch,
    gamma: float,
    terminal_target: Literal["zero", "reward"],
) -> Tensor:
    """Return target_B = r + gamma Q_target(s', argmax Q_online(s', .)); for a terminal move r, or 0 (a mistake)."""
    over_B = batch.terminal_B
    return_B = batch.reward_B.masked_fill(over_B, 0.0) if terminal_target == "zero" else batch.reward_B
    online_BA, target_BA = online(batch.next_image_BKHW), target(batch.next_image_BKHW)
    return q_target(return_B, gamma * (~over_B).float(), online_BA, target_BA)


def td_loss(
    online: ThesisNetwork,
    target: ThesisNetwork,
    batch: ThesisBatch,
    gamma: float,
    terminal_target: Literal["zero", "reward"],
    loss: Literal["squared", "huber"] = "squared",
) -> Tensor:
    """Return the mean loss over the values of all moves; only the chosen move's error is not zero."""
    q_BA = online(batch.image_BKHW)
    with torch.no_grad():
        target_B = td_targets(online, target, batch, gamma, terminal_target)
        goal_BA = q_BA.detach().scatter(1, batch.action_B[:, None], target_B[:, None])
    return (nn.functional.mse_loss if loss == "squared" else nn.functional.huber_loss)(q_BA, goal_BA)


@torch.no_grad()
def greedy(network: ThesisNetwork, images: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the moves of highest value (B,) for images (B, K, H, W) of codes."""
    return np.asarray(network(torch.from_numpy(LEVELS[images])).argmax(dim=1).numpy())

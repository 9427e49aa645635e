"""The dueling network (Wang et al. 2016) over the observation."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout, tour_costs

#: Noise in each weight at the beginning, in units of the reciprocal root of its layer's inputs.
SIGMA = 0.5


class NoisyLinear(nn.Linear):
    """A linear layer with factorised Gaussian noise in training and none in evaluation.

    Fortunato et al. 2018, section 3, arXiv:1706.10295. The noise is zero until it is drawn, and stays the same
    until it is drawn again.
    """

    noise_in: Tensor
    noise_out: Tensor

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__(inputs, outputs)
        self.weight_sigma = nn.Parameter(torch.full((outputs, inputs), SIGMA / inputs**0.5))
        self.bias_sigma = nn.Parameter(torch.full((outputs,), SIGMA / inputs**0.5))
        self.register_buffer("noise_in", torch.zeros(inputs), persistent=False)
        self.register_buffer("noise_out", torch.zeros(outputs), persistent=False)

    def draw_noise(self, generator: torch.Generator) -> None:
        """Draw new noise, on the CPU, so that it is the same on any device."""
        normal = torch.randn(self.in_features + self.out_features, generator=generator)
        noise = (normal.sign() * normal.abs().sqrt()).to(self.noise_in.device)
        self.noise_in.copy_(noise[: self.in_features])
        self.noise_out.copy_(noise[self.in_features :])

    def forward(self, x: Tensor) -> Tensor:
        """Return x W + b, with noise in W and b while training."""
        if not self.training:
            return super().forward(x)
        weight = torch.addcmul(self.weight, self.weight_sigma, torch.outer(self.noise_out, self.noise_in))
        return nn.functional.linear(x, weight, torch.addcmul(self.bias, self.bias_sigma, self.noise_out))


class DuelingNetwork(nn.Module):
    """Map scenes and move features to the values of the four moves.

    The scenes are encoded first; the move features join them in the second layer. A small network shared by
    the moves adds what each move's own features say to its advantage. Where tours are seen, so does a weighted sum of
    these features that begins as the cost of longer tours, while all other advantages begin at 0: at first the network
    flies the tours, and it learns what to put right. Runs under autocast as well.
    """

    def __init__(self, layout: ObservationLayout, config: NetworkConfig) -> None:
        super().__init__()
        width, features = config.width, layout.features
        last = NoisyLinear if config.noisy else nn.Linear
        norm = nn.LayerNorm if config.layer_norm else nn.Identity
        self.look = nn.Linear(layout.inputs, width)
        self.look_norm = norm(width)
        self.think = last(width + 4 * features, width)
        self.think_norm = norm(width)
        self.value = last(width, 1) if config.dueling else None
        self.advantage = last(width, 4)
        self.move_hidden = nn.Linear(features, config.move_width)
        self.move_out = nn.Linear(config.move_width, 1)
        costs = tour_costs(layout, config.tour_cost, config.tour_cost)
        self.tours: nn.Linear | None = None
        if costs is not None:
            self.tours = nn.Linear(features, 1, bias=False)
            self.tours.weight.data[0] = torch.from_numpy(costs)
            for layer in (self.advantage, self.move_out):
                nn.init.zeros_(layer.weight)
                nn.init.zeros_(layer.bias)

    def forward(self, scenes_BI: Tensor, moves_BAF: Tensor) -> Tensor:
        """Return q_BA float32 for ``scenes_BI`` (B, inputs) and ``moves_BAF`` (B, 4, features), both float32."""
        look_BW = torch.relu(self.look_norm(self.look(scenes_BI)))
        joined_BJ = torch.cat([look_BW, moves_BAF.flatten(1).to(look_BW.dtype)], dim=1)
        think_BW = torch.relu(self.think_norm(self.think(joined_BJ)))
        own_BA = self.move_out(torch.relu(self.move_hidden(moves_BAF))).squeeze(2)
        q_BA: Tensor = self.advantage(think_BW).float() + own_BA.float()
        if self.tours is not None:
            q_BA = q_BA + self.tours(moves_BAF).squeeze(2).float()
        return q_BA if self.value is None else duel(self.value(think_BW).float(), q_BA)

    def draw_noise(self, generator: torch.Generator) -> None:
        """Draw new noise for every noisy layer; a network without them draws nothing."""
        for layer in self.modules():
            if isinstance(layer, NoisyLinear):
                layer.draw_noise(generator)


def duel(value_B1: Tensor, advantage_BA: Tensor) -> Tensor:
    """Return q_BA = V + A - mean over the actions of A (Wang et al. 2016, eq. 9)."""
    return value_B1 + advantage_BA - advantage_BA.mean(dim=1, keepdim=True)


def new_network(layout: ObservationLayout, config: NetworkConfig, seed: int) -> DuelingNetwork:
    """Return a network initialised from ``seed`` alone; torch's global generator is left as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return DuelingNetwork(layout, config)


def arrays(network: DuelingNetwork) -> dict[str, NDArray[np.float32]]:
    """Return what acting needs, by name: every weight, or its mean where it is noisy."""
    state = network.state_dict().items()
    return {name: value.float().cpu().numpy().copy() for name, value in state if not name.endswith("_sigma")}

"""The dueling network (Wang et al. 2016) as a torch model."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.encoders import ResidualBlock, encoder
from indoor_explorers.learners.dddqn.network.encoding import encoded_size
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout, tour_costs
from indoor_explorers.learners.sessions.networks import network_arrays

#: Initial noise of each weight, times the square root of its layer's inputs (Fortunato et al. 2018, section 3.2).
SIGMA = 0.5


class NoisyLinear(nn.Linear):
    """A linear layer with factorised Gaussian noise in training mode and none in evaluation mode.

    Fortunato et al. 2018, section 3, arXiv:1706.10295. The noise is zero until :meth:`draw_noise` is called, and stays
    the same until the next call.
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
        """Draw new noise on the CPU, so that it is the same for all devices."""
        normal = torch.randn(self.in_features + self.out_features, generator=generator)
        noise = (normal.sign() * normal.abs().sqrt()).to(self.noise_in.device)
        self.noise_in.copy_(noise[: self.in_features])
        self.noise_out.copy_(noise[self.in_features :])

    def forward(self, x: Tensor) -> Tensor:
        """Return x W + b (B, outputs) for x (B, inputs), with noise in W and b in training mode."""
        if not self.training:
            return super().forward(x)
        weight = torch.addcmul(self.weight, self.weight_sigma, torch.outer(self.noise_out, self.noise_in))
        return nn.functional.linear(x, weight, torch.addcmul(self.bias, self.bias_sigma, self.noise_out))


class DuelingNetwork(nn.Module):
    """Map scenes and move features to the values of the four moves.

    An encoder, if there is one, and the first layer encode the scenes; the move features enter in the second layer. A
    small network that the moves share maps each move's own features to a term of its advantage. With tour features, a
    skip connection adds a weighted sum of them, whose initial weights are the cost of longer tours, while all other
    advantages start at 0: the untrained network follows the tours, and training corrects it. Autocast is supported.
    """

    def __init__(self, layout: ObservationLayout, config: NetworkConfig) -> None:
        super().__init__()
        width, features = config.width, layout.features
        last = NoisyLinear if config.noisy else nn.Linear
        norm = nn.LayerNorm if config.layer_norm else nn.Identity
        self.encoder = encoder(layout, config)
        self.look = nn.Linear(encoded_size(layout, config), width)
        self.blocks = nn.Sequential(*(ResidualBlock(width) for _ in range(config.residual_blocks)))
        self.look_norm = norm(width)
        self.think = last(width + 4 * features, width)
        self.think_norm = norm(width)
        self.value = last(width, 1) if config.dueling else None
        self.advantage = last(width, 4)
        self.move_hidden = nn.Linear(features, config.move_width)
        self.move_out = nn.Linear(config.move_width, 1)
        costs = tour_costs(layout, config.tour_cost, config.tour_cost, kinds=config.kinds)
        self.tours: nn.Linear | None = None
        if costs is not None:
            self.tours = nn.Linear(features, 1, bias=False)
            self.tours.weight.data[0] = torch.from_numpy(costs)
            for layer in (self.advantage, self.move_out):
                nn.init.zeros_(layer.weight)
                nn.init.zeros_(layer.bias)

    def forward(self, scenes_BI: Tensor, moves_BAF: Tensor) -> Tensor:
        """Return q_BA float32 for ``scenes_BI`` (B, inputs) and ``moves_BAF`` (B, 4, features), both float32."""
        look_BW = torch.relu(self.look_norm(self.blocks(self.look(self.encoder(scenes_BI)))))
        joined_BJ = torch.cat([look_BW, moves_BAF.flatten(1).to(look_BW.dtype)], dim=1)
        think_BW = torch.relu(self.think_norm(self.think(joined_BJ)))
        own_BA = self.move_out(torch.relu(self.move_hidden(moves_BAF))).squeeze(2)
        q_BA: Tensor = self.advantage(think_BW).float() + own_BA.float()
        if self.tours is not None:
            q_BA = q_BA + self.tours(moves_BAF).squeeze(2).float()
        return q_BA if self.value is None else duel(self.value(think_BW).float(), q_BA)

    def draw_noise(self, generator: torch.Generator) -> None:
        """Draw new noise for every noisy layer; without noisy layers the generator is not used."""
        for layer in self.modules():
            if isinstance(layer, NoisyLinear):
                layer.draw_noise(generator)


def duel(value_B1: Tensor, advantage_BA: Tensor) -> Tensor:
    """Return q_BA (B, 4) = V (B, 1) + A (B, 4) - mean over the actions of A (Wang et al. 2016, eq. 9)."""
    return value_B1 + advantage_BA - advantage_BA.mean(dim=1, keepdim=True)


def new_network(layout: ObservationLayout, config: NetworkConfig, seed: int) -> DuelingNetwork:
    """Return a network initialised from ``seed``; torch's global generator keeps its state."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return DuelingNetwork(layout, config)


def arrays(network: DuelingNetwork) -> dict[str, NDArray[np.float32]]:
    """Return the arrays for acting by name, shaped as in ``inference.shapes``: every weight, without the noise."""
    return {name: array for name, array in network_arrays(network).items() if not name.endswith("_sigma")}

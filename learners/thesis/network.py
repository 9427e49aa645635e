"""The thesis's dueling network: three convolutions, two dense layers, a value and four advantages.

Section 3.3 of the thesis gives the outline; the sizes are those of its code.
"""

from __future__ import annotations

from typing import Literal

import torch
from torch import Tensor, nn

from indoor_explorers.learners.thesis.sizes import CONVOLUTIONS, DENSE, MOVES, ImageFormat


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

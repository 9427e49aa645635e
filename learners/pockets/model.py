"""The pocket network in torch, for training: see :mod:`indoor_explorers.planners.toolbox.pockets.network`."""

from __future__ import annotations

from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from indoor_explorers.planners.toolbox.pockets.features import COARSE_LAYERS, FINE_LAYERS, SIDE
from indoor_explorers.planners.toolbox.pockets.network import (
    CHANNELS,
    COARSE_SCALES,
    FINE_SCALES,
    HIDDEN,
    KERNELS,
    OUTPUTS,
    STRIDES,
    side_after,
)


class PocketNet(nn.Module):
    """Two stacks of convolutions, one for each picture, and a hidden layer that joins them with the two numbers."""

    def __init__(self) -> None:
        super().__init__()
        for name, layers in (("fine", FINE_LAYERS), ("coarse", COARSE_LAYERS)):
            for k, (channels, size, stride) in enumerate(zip(CHANNELS, KERNELS, STRIDES, strict=True), start=1):
                setattr(self, f"{name}{k}", nn.Conv2d(layers, channels, size, stride))
                layers = channels
        self.hidden = nn.Linear(2 * CHANNELS[-1] * side_after(SIDE) ** 2 + 2, HIDDEN)
        self.out = nn.Linear(HIDDEN, OUTPUTS)
        self.scales = {"fine": FINE_SCALES, "coarse": COARSE_SCALES}

    def forward(self, fine: Tensor, coarse: Tensor, numbers: Tensor) -> Tensor:
        """Return the outputs (K, OUTPUTS) for uint8 pictures (K, layers, SIDE, SIDE) and numbers (K, 2)."""
        flat = []
        for name, picture in (("fine", fine), ("coarse", coarse)):
            x = picture * torch.from_numpy(self.scales[name])[:, None, None]
            for k in range(1, len(CHANNELS) + 1):
                x = torch.relu(getattr(self, f"{name}{k}")(x))
            flat.append(x.permute(0, 2, 3, 1).flatten(1))  # row, column, channel: the order of the compiled network
        joined = torch.relu(self.hidden(torch.cat([*flat, numbers], dim=1)))
        return cast(Tensor, self.out(joined))


def arrays(network: PocketNet) -> dict[str, NDArray[np.float32]]:
    """Return the weights by name, as the file that flies has them, float32."""
    return {name: value.detach().cpu().numpy() for name, value in network.state_dict().items()}

"""Encoders of the fine map and residual blocks, as torch models; :mod:`.encoding` has them compiled.

Without an encoder the first hidden layer has a weight for each pixel. An encoder shares weights among pixels, and
leaves the rest of the scene (coarse map, sides and numbers) as it is.
"""

from __future__ import annotations

from abc import abstractmethod

import torch
from torch import Tensor, nn

from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.encoding import FILTERS, PATCH, STRIDE, TOKEN, fine_layers
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout


class Encoder(nn.Module):
    """Encode the fine map of each scene; the rest of the scene follows it unchanged."""

    def __init__(self, layout: ObservationLayout) -> None:
        super().__init__()
        self._layout, self._pixels = layout, fine_layers(layout) * layout.crop**2
        self.layers = layout.frames * fine_layers(layout)

    def forward(self, scenes_BI: Tensor) -> Tensor:
        """Return the encoded scenes (B, E) for ``scenes_BI`` (B, inputs); E is ``encoded_size``."""
        layout, pixels = self._layout, self._pixels
        scenes_BFS = scenes_BI.view(-1, layout.frames, layout.scene)
        image_BCHW = scenes_BFS[:, :, :pixels].reshape(-1, self.layers, layout.crop, layout.crop)
        code_BE = self.encode(image_BCHW).flatten(1)
        return torch.cat([code_BE, scenes_BFS[:, :, pixels:].flatten(1).to(code_BE.dtype)], dim=1)

    @abstractmethod
    def encode(self, image_BCHW: Tensor) -> Tensor:
        """Return the codes of images (B, layers, crop, crop), of any shape (B, ...)."""


class Convolution(Encoder):
    """Two layers of convolutions without padding, the second one with a stride (Mnih et al. 2015)."""

    def __init__(self, layout: ObservationLayout) -> None:
        super().__init__(layout)
        self.near = nn.Conv2d(self.layers, FILTERS[0], PATCH)
        self.far = nn.Conv2d(FILTERS[0], FILTERS[1], PATCH, stride=STRIDE)

    def encode(self, image_BCHW: Tensor) -> Tensor:
        """Return (B, rows, columns, filters) after both layers."""
        image_BCHW = image_BCHW.contiguous(memory_format=torch.channels_last)
        return torch.relu(self.far(torch.relu(self.near(image_BCHW)))).permute(0, 2, 3, 1)


class Attention(Encoder):
    """A layer of self-attention among patches of the map, and a residual block for each (Dosovitskiy et al. 2021).

    Shares are ReLU(q k / sqrt(units)) / N for N patches in place of a softmax (Wortsman et al. 2023, arXiv:2309.08586):
    they need no exponential function, whose last bits differ between machines.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        super().__init__(layout)
        self._side = layout.crop // PATCH
        self.patch = nn.Linear(PATCH**2 * self.layers, TOKEN)
        self.position = nn.Parameter(0.1 * torch.randn(self._side**2, TOKEN))
        self.before = nn.LayerNorm(TOKEN)
        self.triple = nn.Linear(TOKEN, 3 * TOKEN)
        self.mix = nn.Linear(TOKEN, TOKEN)
        self.block = ResidualBlock(TOKEN)

    def encode(self, image_BCHW: Tensor) -> Tensor:
        """Return the tokens (B, N, units) after attention."""
        side = self._side
        patches = image_BCHW.reshape(-1, self.layers, side, PATCH, side, PATCH).permute(0, 2, 4, 1, 3, 5)
        token_BND: Tensor = self.patch(patches.reshape(-1, side**2, PATCH**2 * self.layers)) + self.position
        query_BND, key_BND, value_BND = self.triple(self.before(token_BND)).chunk(3, dim=2)
        share_BNN = torch.relu(query_BND @ key_BND.mT) / (TOKEN**0.5 * side**2)
        attended_BND: Tensor = self.block(token_BND + self.mix(share_BNN @ value_BND))
        return attended_BND


class ResidualBlock(nn.Module):
    """x + W ReLU(V norm(x)), twice as wide inside (SimBa, Lee et al. 2025, arXiv:2410.09754, section 4)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(width)
        self.wide, self.narrow = nn.Linear(width, 2 * width), nn.Linear(2 * width, width)

    def forward(self, x_BW: Tensor) -> Tensor:
        """Return the sum (..., width)."""
        change_BW: Tensor = self.narrow(torch.relu(self.wide(self.norm(x_BW))))
        return x_BW + change_BW


def encoder(layout: ObservationLayout, config: NetworkConfig) -> nn.Module:
    """Return the encoder of a configuration, whose output has ``encoded_size`` numbers."""
    if config.encoder == "none":
        return nn.Identity()
    return Convolution(layout) if config.encoder == "convolution" else Attention(layout)

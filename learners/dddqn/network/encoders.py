"""Encoders of the fine map and residual blocks, as torch models; :mod:`.encoding` has them compiled.

Without an encoder the first hidden layer has a weight for each pixel. An encoder shares weights among pixels, and
leaves the rest of the scene (coarse map, sides and numbers) as it is.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.encoding import FILTERS, PATCH, STRIDE, TOKEN, encoded_size, fine_layers
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout


class Encoder(nn.Module):
    """Encode the fine map of each scene; the rest of the scene follows it unchanged."""

    def __init__(self, layout: ObservationLayout) -> None:
        super().__init__()
        self._layout, self.layers = layout, fine_layers(layout)

    def forward(self, scenes_BI: Tensor) -> Tensor:
        """Return the encoded scenes (B, E) for ``scenes_BI`` (B, inputs); E is ``encoded_size``."""
        layout = self._layout
        pixels = self.layers * layout.crop**2 // layout.frames
        scenes_BFS = scenes_BI.view(-1, layout.frames, layout.scene)
        image_BCHW = scenes_BFS[:, :, :pixels].reshape(-1, self.layers, layout.crop, layout.crop)
        code_BE = self.encode(image_BCHW).flatten(1)
        return torch.cat([code_BE, scenes_BFS[:, :, pixels:].flatten(1).to(code_BE.dtype)], dim=1)

    def encode(self, image_BCHW: Tensor) -> Tensor:
        """Return the codes (B, places, units) of images; the base class leaves them as they are."""
        raise NotImplementedError


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
    """A layer of self-attention among patches of the map, and two linear layers for each (Dosovitskiy et al. 2021).

    Shares are ReLU(q k / sqrt(units)) / N for N patches in place of a softmax (Wortsman et al. 2023, arXiv:2309.08586):
    they need no exponential function, whose last bits differ between machines.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        super().__init__(layout)
        self._side = layout.crop // PATCH
        self.patch = nn.Linear(PATCH**2 * self.layers, TOKEN)
        self.position = nn.Parameter(0.1 * torch.randn(self._side**2, TOKEN))
        self.before, self.between = nn.LayerNorm(TOKEN), nn.LayerNorm(TOKEN)
        self.triple = nn.Linear(TOKEN, 3 * TOKEN)
        self.mix = nn.Linear(TOKEN, TOKEN)
        self.wide, self.narrow = nn.Linear(TOKEN, 2 * TOKEN), nn.Linear(2 * TOKEN, TOKEN)

    def encode(self, image_BCHW: Tensor) -> Tensor:
        """Return the tokens (B, N, units) after attention."""
        side = self._side
        patches = image_BCHW.reshape(-1, self.layers, side, PATCH, side, PATCH).permute(0, 2, 4, 1, 3, 5)
        token_BND: Tensor = self.patch(patches.reshape(-1, side**2, PATCH**2 * self.layers)) + self.position
        query_BND, key_BND, value_BND = self.triple(self.before(token_BND)).chunk(3, dim=2)
        share_BNN = torch.relu(query_BND @ key_BND.mT) / (TOKEN**0.5 * side**2)
        token_BND = token_BND + self.mix(share_BNN @ value_BND)
        token_BND = token_BND + self.narrow(torch.relu(self.wide(self.between(token_BND))))
        return token_BND


class ResidualBlock(nn.Module):
    """x + W ReLU(V norm(x)), twice as wide inside (SimBa, Lee et al. 2025, arXiv:2410.09754, section 4)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.norm, self.wide, self.narrow = (
            nn.LayerNorm(width),
            nn.Linear(width, 2 * width),
            nn.Linear(2 * width, width),
        )

    def forward(self, x_BW: Tensor) -> Tensor:
        """Return the sum (B, width)."""
        change_BW: Tensor = self.narrow(torch.relu(self.wide(self.norm(x_BW))))
        return x_BW + change_BW


def encoder(layout: ObservationLayout, config: NetworkConfig) -> nn.Module:
    """Return the encoder of a configuration. Raises :class:`InputError` if the fine map does not fit it."""
    encoded_size(layout, config)
    if config.encoder == "none":
        return nn.Identity()
    return Convolution(layout) if config.encoder == "convolution" else Attention(layout)

"""The thesis's network without torch: its sizes, its compiled forward pass and its weights files.

The forward pass takes one image at a time, with a fixed order of additions. Decisions are therefore the same, bit for
bit, in any batch, process and engine, and acting needs no torch. Tests compare it with
:class:`indoor_explorers.learners.thesis.learner.ThesisNetwork`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.networks.layers import as_layer, convolved, linear, relu
from indoor_explorers.planners.toolbox.networks.weights_file import read_once, read_weights_file, write_weights_file

#: Filters, side and stride of the three convolutions; no padding.
CONVOLUTIONS = ((32, 8, 1), (64, 4, 2), (64, 3, 4))
#: Units of the two dense layers.
DENSE = (1024, 512)
#: The moves; the thesis's network never stays.
MOVES = 4


class ImageFormat(NamedTuple):
    """Format of a network's images; a network fits one format only."""

    height: int
    """Rows of the image."""
    width: int
    """Columns of the image."""
    frames: int
    """Stacked images."""
    identity: bool
    """Whether a UAV sees itself as 1 and every teammate as 2, or all by their numbers."""
    centred: bool = False
    """Whether the image is centred on the UAV, (2 H - 1, 2 W - 1) for a map of (H, W)."""

    def view(self) -> tuple[int, int]:
        """Return rows and columns after the convolutions, at least 1 x 1.

        Raises :class:`InputError` if the map is too small for them.
        """
        rows, cols = self.height, self.width
        for _, side, stride in CONVOLUTIONS:
            rows, cols = (rows - side) // stride + 1, (cols - side) // stride + 1
            if rows < 1 or cols < 1:
                raise InputError(
                    f"expected a map of at least 15 x 15 cells, got {self.height} x {self.width}, which the thesis's "
                    "convolutions do not fit into; train on a larger one"
                )
        return rows, cols

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Return names and shapes of the network's arrays, as torch stores them."""
        rows, cols = self.view()
        found: dict[str, tuple[int, ...]] = {}
        channels = self.frames
        for place, (filters, side, _) in enumerate(CONVOLUTIONS):
            found[f"convolutions.{place}.weight"] = (filters, channels, side, side)
            found[f"convolutions.{place}.bias"] = (filters,)
            channels = filters
        sizes = (channels * rows * cols, *DENSE)
        layers = (("first", *sizes[:2]), ("second", *sizes[1:]), ("value", DENSE[1], 1), ("advantage", DENSE[1], MOVES))
        for name, inputs, outputs in layers:
            found[f"{name}.weight"], found[f"{name}.bias"] = (outputs, inputs), (outputs,)
        return found


Array = NDArray[np.float32]


class ThesisWeights(NamedTuple):
    """The network's arrays; kernels are (rows, columns, inputs, filters), matrices (inputs, outputs)."""

    near: Array
    near_bias: Array
    middle: Array
    middle_bias: Array
    far: Array
    far_bias: Array
    first: Array
    first_bias: Array
    second: Array
    second_bias: Array
    value: Array
    value_bias: Array
    advantage: Array
    advantage_bias: Array


def weights_from(arrays: Mapping[str, NDArray[Any]], view: tuple[int, int]) -> ThesisWeights:
    """Arrange a torch network's arrays (outputs, inputs, ...) for acting.

    ``view`` are the rows and columns after its convolutions.
    """
    found = []
    for layer in ("convolutions.0", "convolutions.1", "convolutions.2", "first", "second", "value", "advantage"):
        weight, bias = arrays[f"{layer}.weight"], arrays[f"{layer}.bias"]
        if layer == "first":  # torch orders its inputs by filter, we order them by cell
            weight = weight.reshape(len(weight), -1, *view).transpose(0, 2, 3, 1).reshape(len(weight), -1)
        found += [as_layer(weight), as_layer(bias)]
    return ThesisWeights(*found)


@kernel()
def q_values(images: np.ndarray, levels: np.ndarray, weights: ThesisWeights, q: np.ndarray) -> None:
    """Write the values ``q`` (B, 4) of images (B, K, H, W) of codes; ``levels`` (256,) are the codes' grey levels.

    The mean advantage is over the actions, even if the network was trained with the mean over a batch: the best action
    is the same.
    """
    frames, height, width = images.shape[1:]
    x = np.empty((height, width, frames), np.float32)
    first, second = np.empty_like(weights.first_bias), np.empty_like(weights.second_bias)
    value, advantage = np.empty(1, np.float32), np.empty(4, np.float32)
    for b in range(images.shape[0]):
        for k in range(frames):
            for r in range(height):
                for c in range(width):
                    x[r, c, k] = levels[images[b, k, r, c]]
        near = convolved(x, weights.near, weights.near_bias, 1)
        middle = convolved(near, weights.middle, weights.middle_bias, 2)
        far = convolved(middle, weights.far, weights.far_bias, 4)
        linear(far.ravel(), weights.first, weights.first_bias, first)
        relu(first)
        linear(first, weights.second, weights.second_bias, second)
        relu(second)
        linear(second, weights.value, weights.value_bias, value)
        linear(second, weights.advantage, weights.advantage_bias, advantage)
        mean = (advantage[0] + advantage[1] + advantage[2] + advantage[3]) / np.float32(4.0)
        for k in range(4):
            q[b, k] = value[0] + advantage[k] - mean


#: The weights that ship: 4,000 episodes of training with the thesis's best setting, reward scenario 1 and stuck rule 2.
SHIPPED = Path(__file__).parent / "weights" / "rewards-1-stuck-2.safetensors"


class TrainedNetwork(NamedTuple):
    """A network arranged for acting."""

    image_format: ImageFormat
    weights: ThesisWeights


def write_weights(path: Path, arrays: Mapping[str, NDArray[Any]], image_format: ImageFormat) -> None:
    """Write a network's arrays, shaped as ``image_format.shapes()``, in half precision, rounded to three digits."""
    write_weights_file(path, arrays, image_format._asdict(), half=True)


def load_weights(path: Path) -> tuple[ImageFormat, dict[str, NDArray[np.float32]]]:
    """Return a network's image format and its arrays by name, as torch stores them, float32.

    Raises :class:`InputError` if the file is missing, too large, not a safetensors file, or holds another network.
    """
    file = read_weights_file(path, "dddqn-thesis")
    image_format, shapes = file.described(_image_format)
    return image_format, file.checked(shapes)


def _image_format(about: Mapping[str, Any]) -> tuple[ImageFormat, dict[str, tuple[int, ...]]]:
    image_format = ImageFormat(**about)
    return image_format, image_format.shapes()


@read_once
def trained(path: Path) -> TrainedNetwork:
    """Return a network arranged for acting; a process reads the file once, and again when it changes.

    Raises :class:`InputError` as :func:`load_weights`.
    """
    image_format, arrays = load_weights(path)
    return TrainedNetwork(image_format, weights_from(arrays, image_format.view()))

"""The network that estimates pocket sizes, compiled: cell by cell, with a fixed order of additions.

Estimates are the same, bit for bit, in any batch, process and engine, and flying needs no torch. The layers are those
of :class:`indoor_explorers.learners.pockets.learning.PocketNet`; tests compare the two.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.planners.toolbox.networks.layers import as_layer, convolved, linear, relu
from indoor_explorers.planners.toolbox.pockets.features import COARSE_LAYERS, FINE_LAYERS, PLAIN, SIDE, Kind

Array = NDArray[np.float32]

#: Numbers of cells t for which the network estimates the probability of more than t unknown free cells.
THRESHOLDS = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 400)
#: Channels of the three convolutions of each picture, their kernel sizes and strides.
CHANNELS, KERNELS, STRIDES = (16, 24, 32), (5, 3, 3), (2, 2, 1)
#: Units of the hidden layer.
HIDDEN = 64
#: Outputs: a logit for each threshold, and log(1 + depth).
OUTPUTS = len(THRESHOLDS) + 1


class Convolution(NamedTuple):
    """Weights (kernel, kernel, in, out), bias (out,), and stride."""

    weight: Array
    bias: Array
    stride: int


class NetworkWeights(NamedTuple):
    """The network's arrays; matrices are (inputs, outputs)."""

    fine1: Convolution
    fine2: Convolution
    fine3: Convolution
    coarse1: Convolution
    coarse2: Convolution
    coarse3: Convolution
    hidden: Array
    hidden_bias: Array
    out: Array
    out_bias: Array


def side_after(side: int) -> int:
    """Return the side of a picture after the convolutions, which use whole kernels only."""
    for size, stride in zip(KERNELS, STRIDES, strict=True):
        side = (side - size) // stride + 1
    return side


def shapes(kind: Kind = PLAIN) -> dict[str, tuple[int, ...]]:
    """Return names and shapes of the network's arrays as torch stores them: (outputs, inputs, ...)."""
    found: dict[str, tuple[int, ...]] = {}
    for name, layers in (("fine", kind.levels * FINE_LAYERS), ("coarse", kind.levels * COARSE_LAYERS)):
        for k, (channels, size) in enumerate(zip(CHANNELS, KERNELS, strict=True), start=1):
            found |= {f"{name}{k}.weight": (channels, layers, size, size), f"{name}{k}.bias": (channels,)}
            layers = channels
    inputs = 2 * CHANNELS[-1] * side_after(SIDE) ** 2 + kind.numbers
    found |= {"hidden.weight": (HIDDEN, inputs), "hidden.bias": (HIDDEN,)}
    return found | {"out.weight": (OUTPUTS, HIDDEN), "out.bias": (OUTPUTS,)}


def weights_from(arrays: Mapping[str, NDArray[Any]]) -> NetworkWeights:
    """Arrange the arrays of :func:`shapes` for the compiled network."""
    layers = {name: as_layer(array) for name, array in arrays.items()}
    convolutions = (
        Convolution(layers[f"{name}{k}.weight"], layers[f"{name}{k}.bias"], stride)
        for name in ("fine", "coarse")
        for k, stride in enumerate(STRIDES, start=1)
    )
    dense = (layers[f"{name}.{part}"] for name in ("hidden", "out") for part in ("weight", "bias"))
    return NetworkWeights._make([*convolutions, *dense])


@kernel(entry=False)
def _features(picture: np.ndarray, scales: np.ndarray, first: tuple, second: tuple, third: tuple) -> np.ndarray:  # type: ignore[type-arg]
    """Return the third convolution of a picture (layers, side, side) uint8; ``scales`` are of one level's layers."""
    x = np.empty((picture.shape[1], picture.shape[2], picture.shape[0]), np.float32)
    for layer in range(picture.shape[0]):
        scale = scales[layer % scales.shape[0]]
        for row in range(picture.shape[1]):
            for col in range(picture.shape[2]):
                x[row, col, layer] = picture[layer, row, col] * scale
    x = convolved(x, first[0], first[1], first[2])
    x = convolved(x, second[0], second[1], second[2])
    return convolved(x, third[0], third[1], third[2])


@kernel()
def _outputs(
    fine: np.ndarray,
    coarse: np.ndarray,
    numbers: np.ndarray,
    fine_scales: np.ndarray,
    coarse_scales: np.ndarray,
    weights: NetworkWeights,
) -> np.ndarray:
    out = np.empty((fine.shape[0], weights.out.shape[1]), np.float32)
    hidden = np.empty(weights.hidden.shape[1], np.float32)
    for k in range(fine.shape[0]):
        near = _features(fine[k], fine_scales, weights.fine1, weights.fine2, weights.fine3).ravel()
        far = _features(coarse[k], coarse_scales, weights.coarse1, weights.coarse2, weights.coarse3).ravel()
        joined = np.concatenate((near, far, numbers[k]))
        linear(joined, weights.hidden, weights.hidden_bias, hidden)
        relu(hidden)
        linear(hidden, weights.out, weights.out_bias, out[k])
    return out


#: Factors that bring the layers of a level of the pictures to 0 to 1.
FINE_SCALES = np.array([1.0, 1.0, 1.0, 1.0, 1.0 / 255.0], np.float32)
COARSE_SCALES = np.full(COARSE_LAYERS, 1.0 / 9.0, np.float32)


def outputs(
    fine: NDArray[np.uint8], coarse: NDArray[np.uint8], numbers: Array, weights: NetworkWeights
) -> NDArray[np.float32]:
    """Return the network's outputs for K clusters, (K, OUTPUTS), from :class:`~.features.Pictures`."""
    return np.asarray(_outputs(fine, coarse, numbers, FINE_SCALES, COARSE_SCALES, weights))

"""Encoders of the fine map and residual blocks for acting, compiled; :mod:`.encoders` has them in torch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.observation.layout import ObservationLayout
from indoor_explorers.planners.toolbox.networks.layers import as_layer, convolved, layer_norm, linear, relu

Array = NDArray[np.float32]
#: Side of a convolution's kernel and of a patch for attention, in pixels.
PATCH = 3
#: Filters of both convolutions, and the stride of the second.
FILTERS, STRIDE = (16, 32), 2
#: Units of a patch in attention.
TOKEN = 32


class ConvolutionWeights(NamedTuple):
    """Kernels (rows, columns, inputs, filters) and biases (filters,); empty for another encoder."""

    near: Array
    near_bias: Array
    far: Array
    far_bias: Array


class BlockWeights(NamedTuple):
    """K residual blocks: (K, width, 2 width), (K, 2 width, width) and vectors (K, ...)."""

    norm: Array
    norm_shift: Array
    wide: Array
    wide_bias: Array
    narrow: Array
    narrow_bias: Array


class AttentionWeights(NamedTuple):
    """Matrices (inputs, outputs) and the positions (N, units) of N patches; empty for another encoder."""

    patch: Array
    patch_bias: Array
    position: Array
    before: Array
    before_shift: Array
    triple: Array
    triple_bias: Array
    mix: Array
    mix_bias: Array
    block: BlockWeights


def fine_layers(layout: ObservationLayout) -> int:
    """Return the layers of the fine map in one scene."""
    return int((layout.layers >= 0).sum())


def _grid(layout: ObservationLayout, config: NetworkConfig) -> tuple[int, int]:
    """Return the places of the encoded map, and the units of each.

    Raises :class:`InputError` if the fine map does not fit the encoder.
    """
    crop = layout.crop
    if config.encoder == "convolution":
        side = (crop - 2 * PATCH + 1) // STRIDE + 1
        if side < 1:
            raise InputError(f"expected observation.crop of at least {2 * PATCH - 1} for convolutions, got {crop}")
        return side * side, FILTERS[1]
    if crop % PATCH:
        raise InputError(f"expected observation.crop to be a multiple of {PATCH} for attention, such as 15, got {crop}")
    return (crop // PATCH) ** 2, TOKEN


def encoded_size(layout: ObservationLayout, config: NetworkConfig) -> int:
    """Return the inputs of the first hidden layer.

    Raises :class:`InputError` if the fine map does not fit the encoder.
    """
    if config.encoder == "none":
        return layout.inputs
    places, units = _grid(layout, config)
    return layout.inputs - layout.frames * fine_layers(layout) * layout.crop**2 + places * units


def encoder_shapes(layout: ObservationLayout, config: NetworkConfig) -> dict[str, tuple[int, ...]]:
    """Return names and shapes of the arrays of the encoder and the residual blocks, as torch stores them."""
    found: dict[str, tuple[int, ...]] = {}
    linears: dict[str, tuple[int, ...]] = {}
    layers = layout.frames * fine_layers(layout)
    blocks = {f"blocks.{k}": config.width for k in range(config.residual_blocks)}
    if config.encoder == "convolution":
        linears |= {"encoder.near": (FILTERS[0], layers, PATCH, PATCH), "encoder.far": (*FILTERS[::-1], PATCH, PATCH)}
    elif config.encoder == "attention":
        found["encoder.position"] = _grid(layout, config)
        linears |= {
            "encoder.patch": (TOKEN, PATCH**2 * layers),
            "encoder.before": (TOKEN,),
            "encoder.triple": (3 * TOKEN, TOKEN),
            "encoder.mix": (TOKEN, TOKEN),
        }
        blocks["encoder.block"] = TOKEN
    for at, width in blocks.items():
        linears |= {f"{at}.norm": (width,), f"{at}.wide": (2 * width, width), f"{at}.narrow": (width, 2 * width)}
    for name, shape in linears.items():
        found |= {f"{name}.weight": shape, f"{name}.bias": shape[:1]}
    return found


def encoder_weights(
    arrays: Mapping[str, NDArray[Any]], config: NetworkConfig
) -> tuple[ConvolutionWeights, AttentionWeights, BlockWeights]:
    """Arrange the arrays of :func:`encoder_shapes` for acting; those of parts that are left out are empty."""

    def pair(name: str, axes: int) -> list[Array]:
        if f"{name}.weight" not in arrays:
            return [np.zeros((0,) * axes, np.float32), np.zeros(0, np.float32)]
        return [as_layer(arrays[f"{name}.{part}"]) for part in ("weight", "bias")]

    def blocks(names: Sequence[str]) -> BlockWeights:
        found: list[Array] = []
        for layer, axes in (("norm", 1), ("wide", 2), ("narrow", 2)):
            pairs = [pair(f"{name}.{layer}", axes) for name in names]
            empty = [np.zeros((0,) * n, np.float32) for n in (axes + 1, 2)]
            found += [np.stack(parts) for parts in zip(*pairs, strict=True)] if pairs else empty
        return BlockWeights(*found)

    position = np.ascontiguousarray(arrays.get("encoder.position", np.zeros((0, 0))), np.float32)
    attention: list[Any] = [*pair("encoder.patch", 2), position, *pair("encoder.before", 1)]
    attention += [*pair("encoder.triple", 2), *pair("encoder.mix", 2)]
    attention.append(blocks(["encoder.block"] if config.encoder == "attention" else []))
    return (
        ConvolutionWeights(*pair("encoder.near", 4), *pair("encoder.far", 4)),
        AttentionWeights._make(attention),
        blocks([f"blocks.{k}" for k in range(config.residual_blocks)]),
    )


@kernel(entry=False)
def apply_blocks(x: np.ndarray, blocks: BlockWeights) -> None:
    """Apply the residual blocks to x (width,) float32 in place."""
    if blocks.norm.shape[0] == 0:
        return
    near, wide = np.empty_like(x), np.empty(2 * x.shape[0], np.float32)
    for k in range(blocks.norm.shape[0]):
        near[:] = x
        layer_norm(near, blocks.norm[k], blocks.norm_shift[k])
        linear(near, blocks.wide[k], blocks.wide_bias[k], wide)
        relu(wide)
        linear(wide, blocks.narrow[k], blocks.narrow_bias[k], near)
        for j in range(x.shape[0]):
            x[j] += near[j]


@kernel(entry=False)
def _attended(image: np.ndarray, weights: AttentionWeights, tokens: np.ndarray) -> None:
    """Write the ``tokens`` (N, units) of an image (rows, columns, layers) after self-attention."""
    count, units = tokens.shape
    side, layers = image.shape[0] // PATCH, image.shape[2]
    pixels = np.empty(weights.patch.shape[0], np.float32)
    triples = np.empty((count, 3 * units), np.float32)
    near, mixed = np.empty(units, np.float32), np.empty(units, np.float32)
    for n in range(count):
        row, col = n // side * PATCH, n % side * PATCH
        for layer in range(layers):
            for k in range(PATCH * PATCH):
                pixels[layer * PATCH * PATCH + k] = image[row + k // PATCH, col + k % PATCH, layer]
        linear(pixels, weights.patch, weights.patch_bias, tokens[n])
        for j in range(units):
            tokens[n, j] += weights.position[n, j]
            near[j] = tokens[n, j]
        layer_norm(near, weights.before, weights.before_shift)
        linear(near, weights.triple, weights.triple_bias, triples[n])
    scale = np.float32(1.0 / (np.sqrt(units) * count))
    for n in range(count):
        mixed[:] = 0.0
        for m in range(count):
            share = np.float32(0.0)
            for j in range(units):
                share += triples[n, j] * triples[m, units + j]
            if share > 0.0:
                for j in range(units):
                    mixed[j] += share * scale * triples[m, 2 * units + j]
        linear(mixed, weights.mix, weights.mix_bias, near)
        for j in range(units):
            tokens[n, j] += near[j]
        apply_blocks(tokens[n], weights.block)


@kernel(entry=False)
def encode(
    pixels: np.ndarray,
    crop: int,
    frames: int,
    convolution: ConvolutionWeights,
    attention: AttentionWeights,
    code: np.ndarray,
) -> None:
    """Write the ``code`` (E,) of a scene's ``pixels`` (inputs,): the encoded fine map, then the rest of the scene.

    ``crop`` is the side of the fine map, ``frames`` the number of stacked scenes.
    """
    attending = attention.position.shape[0] > 0
    scene = pixels.shape[0] // frames
    layers = attention.patch.shape[0] // (PATCH * PATCH) if attending else convolution.near.shape[2]
    image, own = np.empty((crop, crop, layers), np.float32), layers // frames
    at = code.shape[0] - frames * (scene - own * crop * crop)
    for frame in range(frames):
        for layer in range(own):
            for k in range(crop * crop):
                image[k // crop, k % crop, frame * own + layer] = pixels[frame * scene + layer * crop * crop + k]
        for k in range(own * crop * crop, scene):
            code[at] = pixels[frame * scene + k]
            at += 1
    if attending:
        _attended(image, attention, code[: attention.position.size].reshape(attention.position.shape))
    else:
        near = convolved(image, convolution.near, convolution.near_bias, 1)
        far = convolved(near, convolution.far, convolution.far_bias, STRIDE)
        code[: far.size] = far.reshape(far.size)

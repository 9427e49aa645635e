"""The checkpoints of ARiADNE, IR2 and MARVEL, read as data: their policies under the names of our own network.

All three have the same encoder, decoder and pointer (:mod:`indoor_explorers.learners.attention.network`), with a matrix
for each head and no bias in the attention. MARVEL has layers for the directions of frontiers and of its camera too.
"""

from __future__ import annotations

import pickle
import warnings
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.attention.network import Array, Weights
from indoor_explorers.planners.toolbox.peers.clone import PublishedCode

#: Entry of a checkpoint that holds the policy; the others are critics and optimisers.
POLICY = "policy_model"
#: Names of the parts of an attention layer, there and here.
_PARTS = {
    "normalization1.normalizer": "before",
    "normalization2.normalizer": "between",
    "feedForward.0": "wide",
    "feedForward.2": "narrow",
}


class Sizes(NamedTuple):
    """The sizes of a published policy network; ``headings``: bins of directions, 0 for a network without them."""

    inputs: int
    heads: int
    headings: int = 0
    units: int = 128
    hidden: int = 512
    layers: int = 6

    @property
    def blocks(self) -> dict[str, str]:
        """The attention layers: names there by names here."""
        found = {f"layers.{k}": f"encoder.layers.{k}" for k in range(self.layers)}
        return found | {"decoder": "decoder.layers.0"}


def shapes(sizes: Sizes) -> dict[str, tuple[int, ...]]:
    """Return the shapes of a published policy's weights, by their names in the checkpoint."""
    d, part = sizes.units, sizes.units // sizes.heads
    found: dict[str, tuple[int, ...]] = _layer("initial_embedding", d, sizes.inputs)
    for name in sizes.blocks.values():
        attention = f"{name}.multiHeadAttention"
        found |= {f"{attention}.w_{kind}": (sizes.heads, d, part) for kind in ("query", "key", "value")}
        found |= {f"{attention}.w_out": (sizes.heads, part, d)}
        found |= {f"{name}.normalization{k}.normalizer.{kind}": (d,) for k in (1, 2) for kind in ("weight", "bias")}
        found |= _layer(f"{name}.feedForward.0", sizes.hidden, d) | _layer(f"{name}.feedForward.2", d, sizes.hidden)
    found |= _layer("current_embedding", d, 2 * d) | {f"pointer.w_{kind}": (d, d) for kind in ("query", "key")}
    if sizes.headings:
        found |= {"frontiers_embedding.weight": (d, sizes.headings, 3), "frontiers_embedding.bias": (d,)}
        found |= _layer("node_frontiers_embedding", d, 2 * d) | _layer("neighboring_node_embedding", d, 3 * d)
        for name in ("best_headings_embedding", "visited_headings_embedding"):
            found |= _layer(name, d, sizes.headings)
    return found


def _layer(name: str, outputs: int, inputs: int) -> dict[str, tuple[int, ...]]:
    return {f"{name}.weight": (outputs, inputs), f"{name}.bias": (outputs,)}


def converted(state: Mapping[str, Array], sizes: Sizes) -> Weights:
    """Return a published policy's weights under the names and in the layout of our network."""
    found = {f"embed.{kind}": state[f"initial_embedding.{kind}"] for kind in ("weight", "bias")}
    for ours, theirs in sizes.blocks.items():
        attention = f"{theirs}.multiHeadAttention"
        query, key, value = (_stacked(state[f"{attention}.w_{kind}"]) for kind in ("query", "key", "value"))
        found |= {f"{ours}.query.weight": query, f"{ours}.pair.weight": np.concatenate([key, value])}
        found[f"{ours}.out.weight"] = state[f"{attention}.w_out"].reshape(sizes.units, -1).T
        for name, count in (("query", 1), ("pair", 2), ("out", 1)):
            found[f"{ours}.{name}.bias"] = np.zeros(count * sizes.units, np.float32)
        for there, here in _PARTS.items():
            found |= {f"{ours}.{here}.{kind}": state[f"{theirs}.{there}.{kind}"] for kind in ("weight", "bias")}
    found |= {f"joined.{kind}": state[f"current_embedding.{kind}"] for kind in ("weight", "bias")}
    found |= {f"pointer_{kind}.weight": state[f"pointer.w_{kind}"].T for kind in ("query", "key")}
    extra = ("frontiers_", "node_frontiers_", "best_", "visited_", "neighboring_")
    found |= {name: array for name, array in state.items() if name.startswith(extra)}
    return {name: np.ascontiguousarray(array, np.float32) for name, array in found.items()}


def _stacked(of_heads: Array) -> Array:
    """Return the matrices (heads, inputs, outputs) of all heads as one (heads * outputs, inputs)."""
    return np.asarray(of_heads.transpose(0, 2, 1).reshape(-1, of_heads.shape[1]))


class Published(NamedTuple):
    """A published network: its repository, and where in a clone the checkpoint lies."""

    code: PublishedCode
    checkpoint: str
    sizes: Sizes

    def read(self, path: Path) -> Weights:
        """Return the policy of a checkpoint. The file is read as data: nothing in it is executed.

        Raises:
            InputError: the file is missing, damaged, needs code to be read, or holds another network.

        """
        clone = str(path).removesuffix(self.checkpoint) or "."
        mend = f"fetch it with `git -C {clone} checkout {self.code.commit} -- {self.checkpoint}`"
        state, expected = _read(path, mend), shapes(self.sizes)
        for name, shape in expected.items():
            found = getattr(state.get(name), "shape", None)
            if found is None or tuple(found) != shape:
                got = "none" if found is None else f"one of shape {tuple(found)}"
                raise _refusal(path, f"a policy with {name!r} of shape {shape}", got, mend)
        if more := sorted(state.keys() - expected.keys()):
            raise _refusal(path, f"a policy without {more[0]!r}", "one", mend)
        return converted({name: value.float().numpy() for name, value in state.items()}, self.sizes)


def _read(path: Path, mend: str) -> Mapping[str, Any]:
    """Return the tensors of a checkpoint's policy by name."""
    try:
        import torch  # imported late: listing the policies needs no torch
    except ImportError as error:
        raise InputError(f"{path} is read by torch; install it with: pip install 'indoor-explorers[rl]'") from error
    if not path.is_file():
        raise _refusal(path, "the checkpoint", "no file", mend)
    try:
        with warnings.catch_warnings(action="ignore"):  # about files that are refused
            whole = torch.load(path, map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        raise _refusal(path, "tensors alone", "objects whose reading would execute code", mend) from error
    except (RuntimeError, EOFError, ValueError, KeyError, OSError, zipfile.BadZipFile) as error:
        raise _refusal(path, "a checkpoint of torch", "a damaged file", mend) from error
    state = whole.get(POLICY) if isinstance(whole, dict) else None
    if not isinstance(state, dict):
        names = ", ".join(sorted(map(str, whole))[:3]) if isinstance(whole, dict) else type(whole).__name__
        raise _refusal(path, f"a checkpoint with the entry {POLICY!r}", names or "an empty one", mend)
    return state


def _refusal(path: Path, wanted: str, got: str, mend: str) -> InputError:
    return InputError(f"{path}: expected {wanted}, found {got}; {mend}")

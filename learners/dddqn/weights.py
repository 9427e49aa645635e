"""Weights on disk: safetensors files, which hold numbers and nothing that could run."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.learners.dddqn.inference import SHAPES, Weights, weights_from

#: The weights that ship, trained on thesis-obstacles.
SHIPPED = Path(__file__).parent / "weights" / "thesis-obstacles.safetensors"

#: The largest file that is read as weights; the network has some 255,000 numbers.
MOST_BYTES = 32_000_000


def write_tensors(path: Path, tensors: Mapping[str, NDArray[Any]], metadata: dict[str, str] | None = None) -> None:
    """Write a safetensors file in one go: a crash leaves the old file or the new one, never half of one."""
    with written_whole(path) as partial:
        save_file({name: np.ascontiguousarray(array) for name, array in tensors.items()}, partial, metadata)


def read_tensors(path: Path) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """Return the arrays of a safetensors file by name, and its metadata.

    Raises:
        InputError: the file is missing or is no safetensors file.

    """
    if not path.is_file():
        raise InputError(f"{path}: expected a safetensors file, found none; give the path of existing weights")
    try:
        with safe_open(path, framework="numpy") as file:
            return {name: file.get_tensor(name) for name in file.keys()}, file.metadata() or {}  # noqa: SIM118
    except (SafetensorError, OSError) as error:
        raise InputError(f"{path}: expected a safetensors file, got something else ({error})") from error


def load_weights(path: Path) -> dict[str, NDArray[np.float32]]:
    """Return a network's arrays, float32 by name.

    Raises:
        InputError: the file is missing, too large, no safetensors file, or holds another network.

    """
    if path.is_file() and path.stat().st_size > MOST_BYTES:
        raise InputError(
            f"{path}: expected weights of at most {MOST_BYTES // 10**6} MB, got {path.stat().st_size / 1e6:.0f} MB; "
            "give weights that train wrote, not a checkpoint"
        )
    found, _ = read_tensors(path)
    expected = dict(SHAPES)
    if missing := sorted(expected.keys() ^ found.keys()):
        raise InputError(
            f"{path}: expected exactly the arrays of the dueling network, but {missing[0]!r} is "
            f"{'missing' if missing[0] in expected else 'unknown'}; give weights that train wrote"
        )
    for name, shape in expected.items():
        if found[name].shape != shape or found[name].dtype.kind != "f":
            raise InputError(
                f"{path}: expected {name!r} to be numbers of shape {shape}, "
                f"got {found[name].dtype} of shape {found[name].shape}; train again with this version"
            )
    return {name: array.astype(np.float32) for name, array in found.items()}


def acting_weights(path: Path) -> Weights:
    """Return a network's arrays arranged for acting; read once in each process, unless the file changes.

    Raises:
        InputError: as :func:`load_weights`.

    """
    return _read_once(path, path.stat().st_mtime_ns if path.is_file() else 0)


@lru_cache(maxsize=8)
def _read_once(path: Path, changed: int) -> Weights:
    return weights_from(load_weights(path))

"""Arrays on disk: safetensors files, which hold data and no executable code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole

#: The file of the trained weights in the folder of a training.
WEIGHTS = "weights.safetensors"


def write_tensors(path: Path, tensors: Mapping[str, NDArray[Any]], metadata: dict[str, str] | None = None) -> None:
    """Write arrays of any shapes to a safetensors file, atomically: a crash leaves the old file or the new one."""
    with written_whole(path) as partial:
        save_file({name: np.ascontiguousarray(array) for name, array in tensors.items()}, partial, metadata)


def read_tensors(path: Path, most_bytes: int | None = None) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """Return the arrays of a safetensors file by name, with their stored shapes and types, and its metadata.

    Raises:
        InputError: the file is missing, larger than ``most_bytes``, or not a safetensors file.

    """
    if not path.is_file():
        raise InputError(f"{path}: expected a safetensors file, found none; give the path of existing weights")
    if most_bytes is not None and path.stat().st_size > most_bytes:
        raise InputError(
            f"{path}: expected weights of at most {most_bytes // 10**6} MB, got {path.stat().st_size / 1e6:.0f} MB; "
            "give weights that train wrote, not a checkpoint"
        )
    try:
        with safe_open(path, framework="numpy") as file:
            return {name: file.get_tensor(name) for name in file.keys()}, file.metadata() or {}  # noqa: SIM118
    except (SafetensorError, OSError) as error:
        raise InputError(f"{path}: expected a safetensors file, got something else ({error})") from error

"""The checkpoint of a training in one safetensors file: arrays by name, and all other state as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors

CHECKPOINT = "checkpoint.safetensors"
#: The entry of the metadata that holds everything but arrays.
STATE = "training"


def write_checkpoint(folder: Path, tensors: Mapping[str, NDArray[Any]], state: Mapping[str, Any]) -> None:
    """Write the checkpoint of a folder atomically."""
    write_tensors(folder / CHECKPOINT, tensors, {STATE: json.dumps(state)})


def read_checkpoint(path: Path) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return the arrays of a checkpoint by name, and its other state.

    Raises :class:`InputError` if the file is missing or damaged.
    """
    tensors, metadata = read_tensors(path)
    with reporting_damage(path):
        return tensors, json.loads(metadata[STATE])


@contextmanager
def reporting_damage(path: Path) -> Iterator[None]:
    """Report errors of the block that restores a checkpoint as errors of its file.

    Raises :class:`InputError` if something is missing from the checkpoint or has another shape.
    """
    try:
        yield
    except (KeyError, RuntimeError, TypeError, ValueError) as error:
        raise InputError(
            f"{path}: expected a checkpoint of this version, got something else ({error!r}); train again"
        ) from error

"""Weights files: one format for the networks of all planners and learners.

A file holds a network's arrays by name (safetensors, float32 or float16) and in its metadata, under ``about``, a JSON
object with the metadata for flying the network. A network declares the shapes of its arrays; a file that holds others
is refused.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors

#: Name of the metadata entry, and its name in files of ``dddqn-thesis`` up to version 0.2.0.
ABOUT, FORMER_ABOUT = "about", "eye"
#: What stands for the shipped weights where there are none by default.
AS_SHIPPED = "shipped"
#: Largest size of a weights file.
MOST_BYTES = 1_000_000_000

_T = TypeVar("_T")


def weights_path(given: str | None, shipped: Path, name: str) -> Path:
    """Return the path of weights: ``given``, in its file ``name`` if it is a training's folder, or else ``shipped``."""
    if given is None:
        return shipped
    path = expanded(given)
    return path / name if path.is_dir() else path


def optional_weights_path(given: str | None, shipped: Path, name: str) -> Path | None:
    """Return the path of weights as :func:`weights_path` does, for ``AS_SHIPPED`` that of the shipped ones.

    None stands for no weights.
    """
    return None if given is None else weights_path(None if given == AS_SHIPPED else given, shipped, name)


class WeightsFile(NamedTuple):
    """The content of a weights file, before anything but its format is checked."""

    path: Path
    network: str
    """Name of the expected network in error messages."""
    about: dict[str, Any]
    """Metadata for flying the network; empty in files without metadata."""
    arrays: dict[str, NDArray[Any]]
    """The arrays by name."""

    def described(self, by: Callable[[Mapping[str, Any]], _T]) -> _T:
        """Return ``by(about)``.

        Raises:
            InputError: ``by`` raises a KeyError, TypeError or ValueError: the file is of another network or version.

        """
        try:
            return by(self.about)
        except (KeyError, TypeError, ValueError) as error:
            got = f"a description that this version does not know ({' '.join(repr(error).split())})"
            raise self._refusal("with its description", got) from error

    def checked(self, shapes: Mapping[str, tuple[int, ...]]) -> dict[str, NDArray[np.float32]]:
        """Return the arrays as float32, in the order of ``shapes``.

        Raises:
            InputError: there are not exactly the arrays of ``shapes``, by names and shapes, or one holds no numbers.

        """
        for name, shape in shapes.items():
            array = self.arrays.get(name)
            if array is None or array.shape != shape or array.dtype.kind != "f":
                raise self._refusal(f"with {name!r} of shape {shape}", _described(array))
        if more := sorted(self.arrays.keys() - shapes.keys()):
            raise self._refusal(f"without {more[0]!r}", _described(self.arrays[more[0]]))
        return {name: np.ascontiguousarray(self.arrays[name], np.float32) for name in shapes}

    def _refusal(self, wanted: str, got: str) -> InputError:
        return InputError(
            f"{self.path}: expected weights of {self.network} {wanted}, got {got}; give weights that its training "
            "wrote, or train again with this version"
        )


def _described(array: NDArray[Any] | None) -> str:
    return "none" if array is None else f"{array.dtype} of shape {array.shape}"


def write_weights_file(
    path: Path, arrays: Mapping[str, NDArray[Any]], about: Mapping[str, Any], *, half: bool = False
) -> None:
    """Write a network's arrays and metadata atomically.

    ``half`` stores float16: half the size, numbers rounded to three digits.
    """
    kind = np.float16 if half else np.float32
    tensors = {name: array.astype(kind) for name, array in arrays.items()}
    write_tensors(path, tensors, {ABOUT: json.dumps(about)} if about else None)  # several would be in any order


def read_weights_file(path: Path, network: str) -> WeightsFile:
    """Return the content of a weights file; ``network`` is the name of the expected network in error messages.

    Raises:
        InputError: the file is missing, too large, not a safetensors file, or damaged.

    """
    arrays, metadata = read_tensors(path, MOST_BYTES)
    about = metadata.get(ABOUT, metadata.get(FORMER_ABOUT, "{}"))
    file = WeightsFile(path, network, {}, arrays)
    return file._replace(about=file.described(lambda _: dict(json.loads(about))))


def read_once(load: Callable[[Path], _T]) -> Callable[[Path], _T]:
    """Let a process read a file once, and again when it changes; ``load`` gets the path."""

    @lru_cache(maxsize=8)
    def unless_changed(path: Path, changed: int) -> _T:
        return load(path)

    @wraps(load)
    def loaded(path: Path) -> _T:
        return unless_changed(path, path.stat().st_mtime_ns if path.is_file() else 0)

    return loaded

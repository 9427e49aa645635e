"""The replay: the latest choices of training flights, in memory and as arrays for checkpoints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.learners.attention.flights import Choice

#: The fields of a choice that have as many rows as a graph has nodes, and all others.
_GRAPHS = ("features", "neighbours", "true_features", "true_neighbours")
_OTHERS = tuple(name for name in Choice._fields if name not in _GRAPHS)


class Replay:
    """Keep at most ``size`` choices, the oldest go first; those of one UAV stand one after the other."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.choices: list[Choice] = []

    def add(self, choices: Sequence[Choice]) -> None:
        """Add the choices of a flight."""
        self.choices += choices
        del self.choices[: max(0, len(self.choices) - self.size)]

    def drawn(self, count: int, rng: np.random.Generator) -> tuple[list[Choice], list[Choice]]:
        """Return ``count`` random choices of which it is known how they went on, and those that follow each."""
        usable = np.flatnonzero([choice.follows >= 0 for choice in self.choices])
        rows = rng.choice(usable, count)
        last = len(self.choices) - 1
        return [self.choices[row] for row in rows], [self.choices[min(row + 1, last)] for row in rows]

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        if not self.choices:
            return {}
        found: dict[str, NDArray[Any]] = {}
        for name in _GRAPHS:
            arrays = [getattr(choice, name) for choice in self.choices]
            found[f"replay/{name}"] = np.concatenate(arrays)
            found[f"replay/{name}.ends"] = np.cumsum([len(array) for array in arrays])
        return found | {f"replay/{name}": np.array([getattr(each, name) for each in self.choices]) for name in _OTHERS}

    def restore(self, tensors: Mapping[str, NDArray[Any]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        if "replay/chosen" not in tensors:
            return
        parts = [np.split(tensors[f"replay/{name}"], tensors[f"replay/{name}.ends"][:-1]) for name in _GRAPHS]
        stored = [tensors[f"replay/{name}"] for name in _OTHERS]
        others = [list(each) if each.ndim > 1 else each.tolist() for each in stored]  # plain numbers, as recorded
        rows = zip(*parts, *others, strict=True)
        named = (dict(zip((*_GRAPHS, *_OTHERS), row, strict=True)) for row in rows)
        self.choices = [Choice(**fields) for fields in named]

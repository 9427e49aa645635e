"""The interface of encoders, which turn one UAV's view into arrays of a Gymnasium space."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np
from gymnasium.spaces import Box, Dict, Space
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.policies.view import Briefing, View

#: An observation: an array, or named arrays.
Arrays: TypeAlias = NDArray[Any] | dict[str, NDArray[Any]]


class Views(NamedTuple):
    """Views of single UAVs in B episodes: the fields of a view with a leading axis."""

    belief: NDArray[np.uint8]
    """(B, H, W)."""
    cell: NDArray[np.int64]
    """(B, 2)."""
    legal: Mask
    """(B, 5)."""
    step: NDArray[np.int64]
    """(B,)."""
    budget: NDArray[np.int64]
    """(B,)."""
    visited: Mask
    """(B, H, W)."""
    base_age: NDArray[np.int64] | None = None
    """(B,) with -1 for never; None without a home base."""
    log_odds: NDArray[np.float32] | None = None
    """(B, H, W); None where maps are certain."""
    pose_std: NDArray[np.floating[Any]] | None = None
    """(B,); None where poses are certain."""
    heading: NDArray[np.integer[Any]] | None = None
    """(B,); None where lidars see all around."""

    def view(self, b: int) -> View:
        """Return one of them."""
        row, col = self.cell[b].tolist()
        step, budget = int(self.step[b]), int(self.budget[b])
        age = -1 if self.base_age is None else int(self.base_age[b])
        return View(
            belief=self.belief[b],
            cell=(row, col),
            legal=self.legal[b],
            step=step,
            budget=budget,
            mates=(),
            visited=self.visited[b],
            base_age=None if age < 0 else age,
            log_odds=None if self.log_odds is None else self.log_odds[b],
            pose_std=0.0 if self.pose_std is None else float(self.pose_std[b]),
            heading=None if self.heading is None else int(self.heading[b]),
        )


class Encoder(ABC):
    """Turn one UAV's view into an observation, from its view and its briefing alone.

    An encoder is called once per step, and :meth:`reset` before each episode's first view; between these calls it may
    store earlier views. With a home base or a prior map, :meth:`begin` is called instead, with the episode's briefing.
    An encoder without a memory sets ``stateless = True`` and is shared by all episodes of a batch; otherwise each
    episode has its own.
    """

    #: The space of observations, a Box or a Dict of Boxes; the same object for the encoder's whole life.
    space: Space[Any]
    #: Whether observations do not depend on earlier views.
    stateless: bool = False

    @abstractmethod
    def encode(self, view: View, out: Any) -> None:
        """Overwrite all of ``out``: an array of the space's shape and dtype, or a dict of such arrays."""

    def encode_batch(self, views: Views, out: Any) -> None:
        """Overwrite ``out``, arrays (B, ...), from B views; only for stateless encoders."""
        for b in range(len(views.cell)):
            self.encode(views.view(b), row_of(out, b))

    def reset(self) -> None:  # noqa: B027 (most have no memory)
        """Prepare for a new episode."""

    def begin(self, briefing: Briefing) -> None:
        """Prepare for a new episode of the same UAV on a map of the same shape, with the episode's briefing."""
        self.reset()

    def observation(self, view: View) -> Any:
        """Return the encoded view in new arrays."""
        out = empty(self.space)
        self.encode(view, out)
        return out


#: An observation: its name, or a factory that makes an encoder for a briefing.
Observation: TypeAlias = str | Callable[[Briefing], Encoder]


def boxes_of(space: Space[Any]) -> dict[str, Box]:
    """Return the Boxes of a Dict by name, in the space's order, or a Box under the name ``""``."""
    return cast(dict[str, Box], space.spaces if isinstance(space, Dict) else {"": space})


def empty(space: Space[Any], *lead: int) -> Any:
    """Return new arrays of shape ``lead`` and then the space's, a Box or a Dict of Boxes, not filled."""
    if isinstance(space, Dict):
        return {name: np.empty((*lead, *(box.shape or ())), box.dtype) for name, box in space.spaces.items()}
    return np.empty((*lead, *(space.shape or ())), space.dtype)


def row_of(arrays: Any, b: int) -> Any:
    """Return entry ``b`` of arrays (B, ...), sharing their memory."""
    return {name: array[b] for name, array in arrays.items()} if isinstance(arrays, Mapping) else arrays[b]


def copy_of(arrays: Any) -> Any:
    """Return a copy of an array or of a dict of arrays."""
    return {name: array.copy() for name, array in arrays.items()} if isinstance(arrays, Mapping) else arrays.copy()

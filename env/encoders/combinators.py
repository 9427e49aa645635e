"""Encoders made of encoders: named parts, one flat vector, the last few observations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Space
from numpy.typing import NDArray

from indoor_explorers.env.encoders.base import Encoder, Views, boxes_of, empty
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.view import View


class PartsEncoder(Encoder):
    """Give parts their names in a Dict; a part that is a Dict already adds its own names."""

    def __init__(self, parts: Mapping[str, Encoder]) -> None:
        boxes: dict[str, Space[Any]] = {}
        for name, part in parts.items():
            for inner, box in boxes_of(part.space).items():
                if (key := inner or name) in boxes:
                    raise InputError(f"expected names that differ, got two parts called {key!r}; rename one")
                boxes[key] = box
        self.space = Dict(boxes)
        self.stateless = all(part.stateless for part in parts.values())
        self._parts = [(None if isinstance(part.space, Dict) else name, part) for name, part in parts.items()]

    def encode(self, view: View, out: dict[str, NDArray[Any]]) -> None:
        """Encode each part into its arrays."""
        for name, part in self._parts:
            part.encode(view, out if name is None else out[name])

    def encode_batch(self, views: Views, out: dict[str, NDArray[Any]]) -> None:
        """Encode each part for UAVs that fly alone."""
        for name, part in self._parts:
            part.encode_batch(views, out if name is None else out[name])

    def reset(self) -> None:
        """Reset each part."""
        for _, part in self._parts:
            part.reset()


class FlatEncoder(Encoder):
    """Join all numbers to one float32 vector, in the order of ``gymnasium.spaces.flatten``, bytes as 0 to 1."""

    def __init__(self, inner: Encoder) -> None:
        boxes = boxes_of(inner.space)
        self._named = isinstance(inner.space, Dict)
        self._inner = inner
        self.stateless = inner.stateless
        self._slots: list[tuple[str, slice, tuple[int, ...], np.float32 | None]] = []
        start = 0
        for name, box in boxes.items():
            stop = start + int(np.prod(box.shape))
            scale = np.float32(1 / 255) if box.dtype == np.uint8 else np.float32(1)
            direct = box.dtype == np.float32
            self._slots.append((name, slice(start, stop), box.shape, None if direct else scale))
            start = stop
        low, high = (_joined([getattr(box, bound) for box in boxes.values()], self._slots) for bound in ("low", "high"))
        self.space = Box(low, high, dtype=np.float32)
        self._scratch = {name: np.empty(box.shape, box.dtype) for name, box in boxes.items()}

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Encode one view; float32 parts are written where they belong at once."""
        parts = {
            name: out[span].reshape(shape) if scale is None else self._scratch[name]
            for name, span, shape, scale in self._slots
        }
        self._inner.encode(view, parts if self._named else parts[""])
        for name, span, _, scale in self._slots:
            if scale is not None:
                np.multiply(parts[name].reshape(-1), scale, out=out[span], casting="unsafe")

    def encode_batch(self, views: Views, out: NDArray[np.float32]) -> None:
        """Encode UAVs that fly alone."""
        count = len(views.cell)
        parts = empty(self._inner.space, count)
        self._inner.encode_batch(views, parts)
        for name, span, _, scale in self._slots:
            part = parts[name] if self._named else parts
            np.multiply(part.reshape(count, -1), scale or np.float32(1), out=out[:, span], casting="unsafe")

    def reset(self) -> None:
        """Reset what is inside."""
        self._inner.reset()


def _joined(bounds: list[NDArray[Any]], slots: list[tuple[str, slice, tuple[int, ...], Any]]) -> NDArray[np.float32]:
    scaled = [
        bound.ravel().astype(np.float32) * (scale or np.float32(1))
        for bound, (_, _, _, scale) in zip(bounds, slots, strict=True)
    ]
    return np.concatenate(scaled).astype(np.float32)


class StackedEncoder(Encoder):
    """Keep the last observations of an episode, oldest first; before the first step all of them are the first.

    Vectors and stacks of planes are joined along their first axis, so that (C, H, W) becomes (k C, H, W); an
    image (H, W) becomes the planes (k, H, W). To encode a step once more replaces the newest observation.
    """

    def __init__(self, inner: Encoder, depth: int) -> None:
        self._inner = inner
        self._named = isinstance(inner.space, Dict)
        boxes = boxes_of(inner.space)
        spaces: dict[str, Space[Any]] = {name: _repeated(box, depth) for name, box in boxes.items()}
        self.space: Space[Any] = Dict(spaces) if self._named else spaces[""]
        self._newest = empty(inner.space)
        self._frames = {name: np.empty((depth, *box.shape), box.dtype) for name, box in boxes.items()}
        self._step: int | None = None

    def reset(self) -> None:
        """Forget the observations of the episode before."""
        self._step = None
        self._inner.reset()

    def encode(self, view: View, out: Any) -> None:
        """Add the newest observation, and give the last ones."""
        self._inner.encode(view, self._newest)
        for name, frames in self._frames.items():
            newest, target = (self._newest[name], out[name]) if self._named else (self._newest, out)
            if self._step is None:
                frames[:] = newest
            elif view.step != self._step:
                frames[:-1] = frames[1:]
            frames[-1] = newest
            target[...] = frames.reshape(target.shape)
        self._step = view.step


def _repeated(box: Box, depth: int) -> Box:
    shape = (depth, *box.shape) if len(box.shape) == 2 else (depth * box.shape[0], *box.shape[1:])
    low, high = (np.stack([bound] * depth).reshape(shape) for bound in (box.low, box.high))
    return Box(low, high, dtype=box.dtype.type)  # type: ignore[union-attr, arg-type]  # a Box has a dtype

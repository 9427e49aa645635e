"""Encoders composed of other encoders: named parts, one flat vector, the last few observations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from gymnasium.spaces import Box, Dict, Space
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.observations.base import Encoder, Views, boxes_of, empty
from indoor_explorers.env.policies.view import Briefing, View


class _ComposedEncoder(Encoder):
    """Pass the start of an episode on to the encoders that an encoder is composed of."""

    def __init__(self, *inner: Encoder) -> None:
        self._all = inner
        self.stateless = all(each.stateless for each in inner)

    def reset(self) -> None:
        """Reset each inner encoder."""
        for each in self._all:
            each.reset()

    def begin(self, briefing: Briefing) -> None:
        """Begin each inner encoder's episode."""
        for each in self._all:
            each.begin(briefing)


class PartsEncoder(_ComposedEncoder):
    """Join parts in a Dict by their names; a part that is a Dict contributes its own names."""

    def __init__(self, parts: Mapping[str, Encoder]) -> None:
        super().__init__(*parts.values())
        boxes: dict[str, Space[Any]] = {}
        for name, part in parts.items():
            for inner, box in boxes_of(part.space).items():
                if (key := inner or name) in boxes:
                    raise InputError(f"expected names that differ, got two parts called {key!r}; rename one")
                boxes[key] = box
        self.space = Dict(boxes)
        self._parts = [(None if isinstance(part.space, Dict) else name, part) for name, part in parts.items()]

    def encode(self, view: View, out: dict[str, NDArray[Any]]) -> None:
        """Encode each part into its arrays."""
        for name, part in self._parts:
            part.encode(view, out if name is None else out[name])

    def encode_batch(self, views: Views, out: dict[str, NDArray[Any]]) -> None:
        """Encode each part of single UAVs into its arrays (B, ...)."""
        for name, part in self._parts:
            part.encode_batch(views, out if name is None else out[name])


class _Slot(NamedTuple):
    """Where a part lies in a flat vector."""

    name: str
    span: slice
    box: Box
    scale: np.float32


class FlatEncoder(_ComposedEncoder):
    """Join all numbers to one float32 vector, in the order of ``gymnasium.spaces.flatten``, bytes divided by 255."""

    def __init__(self, inner: Encoder) -> None:
        super().__init__(inner)
        self._inner = inner
        self._named = isinstance(inner.space, Dict)
        self._slots: list[_Slot] = []
        start = 0
        for name, box in boxes_of(inner.space).items():
            span = slice(start, start + int(np.prod(box.shape)))
            self._slots.append(_Slot(name, span, box, np.float32(1 / 255 if box.dtype == np.uint8 else 1)))
            start = span.stop
        low = np.concatenate([slot.box.low.astype(np.float32).ravel() * slot.scale for slot in self._slots])
        high = np.concatenate([slot.box.high.astype(np.float32).ravel() * slot.scale for slot in self._slots])
        self.space = Box(low, high, dtype=np.float32)
        self._places = [(name, span, box.shape) for name, span, box, _ in self._slots if box.dtype == np.float32]
        self._others = [slot for slot in self._slots if slot.box.dtype != np.float32]
        self._scratch = {slot.name: np.empty(slot.box.shape, slot.box.dtype) for slot in self._others}

    def encode(self, view: View, out: NDArray[np.float32]) -> None:
        """Encode one view into ``out`` (K,); float32 parts are written in place."""
        parts = self._scratch | {name: out[span].reshape(shape) for name, span, shape in self._places}
        self._inner.encode(view, parts if self._named else parts[""])
        for name, span, _, scale in self._others:
            np.multiply(parts[name].reshape(-1), scale, out=out[span], casting="unsafe")

    def encode_batch(self, views: Views, out: NDArray[np.float32]) -> None:
        """Encode the views of single UAVs into ``out`` (B, K)."""
        count = len(views.cell)
        parts = empty(self._inner.space, count)
        self._inner.encode_batch(views, parts)
        for name, span, _, scale in self._slots:
            part = parts[name] if self._named else parts
            np.multiply(part.reshape(count, -1), scale, out=out[:, span], casting="unsafe")


class StackedEncoder(_ComposedEncoder):
    """Stack the last observations of an episode, oldest first; at the start all of them are the first.

    Vectors and planes are joined along their first axis, so that (C, H, W) becomes (k C, H, W); an image (H, W) becomes
    the planes (k, H, W). Encoding the same step again replaces the newest observation.
    """

    def __init__(self, inner: Encoder, depth: int) -> None:
        super().__init__(inner)
        self.stateless = False
        self._inner = inner
        self._named = isinstance(inner.space, Dict)
        boxes = boxes_of(inner.space)
        spaces: dict[str, Space[Any]] = {name: _repeated(box, depth) for name, box in boxes.items()}
        self.space: Space[Any] = Dict(spaces) if self._named else spaces[""]
        self._newest = empty(inner.space)
        self._frames = {name: np.empty((depth, *box.shape), box.dtype) for name, box in boxes.items()}
        self._step: int | None = None

    def reset(self) -> None:
        """Drop the observations of the last episode."""
        self._step = None
        super().reset()

    def begin(self, briefing: Briefing) -> None:
        """Drop the observations of the last episode."""
        self._step = None
        super().begin(briefing)

    def encode(self, view: View, out: Any) -> None:
        """Add the newest observation, and write the last ones."""
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

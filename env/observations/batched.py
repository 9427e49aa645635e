"""Encoders for a batch of episodes: one for all of them, or one with a memory for each."""

from __future__ import annotations

from typing import Any

from indoor_explorers.env.observations.base import Encoder, Observation, Views, row_of
from indoor_explorers.env.observations.factories import make_encoder
from indoor_explorers.env.policies.view import Briefing


class BatchedEncoder:
    """Encode B episodes of lone UAVs, each as an encoder of its own would."""

    def __init__(self, observation: Observation, briefing: Briefing, count: int) -> None:
        first = make_encoder(observation, briefing)
        self.space = first.space
        self.shared = first if first.stateless else None
        """The encoder of all episodes, when they share one."""
        self._own = [first] + [make_encoder(observation, briefing) for _ in range(0 if first.stateless else count - 1)]

    def of(self, b: int) -> Encoder | None:
        """Return the encoder of the episode in place ``b`` of the batch; None where all share one without a memory."""
        return self._own[b] if self.shared is None else None

    def encode(self, views: Views, out: Any) -> None:
        """Overwrite all of ``out``, arrays (B, ...)."""
        if self.shared is not None:
            self.shared.encode_batch(views, out)
        else:
            for b in range(len(self._own)):
                self.encode_one(b, views, out)

    def encode_one(self, b: int, views: Views, out: Any) -> None:
        """Overwrite entry ``b`` of ``out``."""
        encoder = self._own[b] if self.shared is None else self.shared
        encoder.encode(views.view(b), row_of(out, b))

"""The training loop: fly an episode, learn from the replay, and so on; and the content of its checkpoint."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from indoor_explorers.learners.attention.flights import drawn_task, fly, greedy
from indoor_explorers.learners.attention.graph import GraphSettings
from indoor_explorers.learners.attention.model import weights_of
from indoor_explorers.learners.attention.network import Loaded, NetworkSettings, write_weights
from indoor_explorers.learners.attention.replay import Replay
from indoor_explorers.learners.attention.sac import Losses, Sac, SacSettings
from indoor_explorers.learners.pockets.maps import MapSettings
from indoor_explorers.learners.sessions.checkpoint import read_checkpoint, reporting_damage, write_checkpoint
from indoor_explorers.learners.sessions.evaluation import evaluate_world, mean_evaluation
from indoor_explorers.learners.sessions.seeds import evaluation_seeds, training_seeds
from indoor_explorers.learners.sessions.session import Trainee, TrainingStatus
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS


class TrainingConfig(MapSettings):
    """Describe one training completely, together with its seed."""

    episodes: int = Field(20_000, ge=1)
    """Training flights."""
    first_update: int = Field(1000, ge=1)
    """Choices before the first update."""
    choices_per_update: int = Field(8, ge=1)
    """Choices that are flown for one update."""
    replay: int = Field(10_000, ge=2)
    """Choices that are kept."""
    graph: GraphSettings = GraphSettings()
    network: NetworkSettings = NetworkSettings()
    sac: SacSettings = SacSettings()
    evaluation_episodes: int = Field(16, ge=1)
    """Flights of one evaluation."""
    evaluation_every: int = Field(100, ge=1)
    """Episodes between two evaluations."""
    checkpoint_every: int = Field(50, ge=1)
    """Episodes between two checkpoints."""


class AttentionTraining(Trainee):
    """Fly one episode at a time, and learn from the replay after each."""

    unit = "episodes"
    steps = 0

    def __init__(self, config: TrainingConfig, seed: int, checkpoint: Path | None = None) -> None:
        self.config, self.seed = config, seed
        self.maps = config.maps()
        self.sac, self.replay = Sac(config.sac, config.network, seed), Replay(config.replay)
        self.rng = np.random.default_rng(seed)
        self.episodes = self.choices = self.updates = 0
        self.losses: list[Losses] = []
        """Figures of the updates since the last evaluation."""
        self._reported, self._lengths = 0, [0]
        if checkpoint is not None:
            self._restore(checkpoint)

    @property
    def done(self) -> bool:
        """Tell whether the training is complete."""
        return self.episodes >= self.config.episodes

    @property
    def loaded(self) -> Loaded:
        """The present policy, as it flies."""
        return Loaded(weights_of(self.sac.policy), self.config.network, self.config.graph)

    def update(self) -> None:
        """Fly an episode, and make the updates that its choices pay for."""
        config = self.config
        world = drawn_task(self.maps, training_seeds(self.seed) + self.episodes, config.graph)
        flown = fly(world, self.loaded, self.rng, privileged=config.sac.privileged_critic)
        self.replay.add(flown.choices)
        self.episodes += 1
        self.steps += flown.steps
        self.choices += len(flown.choices)
        self._lengths.append(flown.steps)
        due = max(0, self.choices - config.first_update) // config.choices_per_update
        for _ in range(due - self.updates):
            self.losses.append(self.sac.update(*self.replay.drawn(config.sac.batch, self.rng)))
        self.updates = due

    def status(self) -> TrainingStatus:
        """Return the current status for a report."""
        new, self._reported = self.losses[self._reported :], len(self.losses)
        lengths, self._lengths = self._lengths, []
        return TrainingStatus(
            total_steps=round(self.steps / max(1, self.episodes) * self.config.episodes),
            loss=float(np.mean([loss.critic for loss in new])) if new else float("nan"),
            episodes=self.episodes,
            episode_steps=float(np.mean(lengths)) if lengths else float("nan"),
        )

    def evaluate(self) -> dict[str, int | float]:
        """Fly greedily without the guard on tasks that training does not use."""
        loaded, first = self.loaded, evaluation_seeds(self.seed)
        found = []
        for seed in range(first, first + self.config.evaluation_episodes):
            world = drawn_task(self.maps, seed, self.config.graph)
            flight = greedy(world, loaded)
            found.append(evaluate_world(world, lambda flight=flight: next(flight), self.steps))  # type: ignore[misc]
        told = mean_evaluation(found)._asdict() | {"episodes": self.episodes, "updates": self.updates}
        if self.losses:
            told |= dict(zip(Losses._fields, np.mean(self.losses, axis=0).round(5).tolist(), strict=True))
        self.losses, self._reported = [], 0
        return told

    def rank(self, evaluation: Mapping[str, int | float]) -> tuple[float, ...]:
        """Return the score: the network of the best evaluation is kept."""
        return (evaluation["score"],)

    def keep(self, folder: Path) -> None:
        """Write the present network."""
        write_weights(folder / WEIGHTS, self.loaded)

    def results(self) -> dict[str, Any]:
        """Return how much was flown and learned."""
        return {"episodes": self.episodes, "choices": self.choices, "updates": self.updates}

    def save(self, folder: Path) -> None:
        """Write the checkpoint."""
        state = {**self.results(), "steps": self.steps, "rng": self.rng.bit_generator.state, "losses": self.losses}
        write_checkpoint(folder, self.sac.tensors() | self.replay.tensors(), state)

    def _restore(self, path: Path) -> None:
        tensors, state = read_checkpoint(path)
        with reporting_damage(path):
            self.sac.restore(tensors)
            self.replay.restore(tensors)
            self.episodes, self.choices, self.updates = state["episodes"], state["choices"], state["updates"]
            self.steps, self.losses = state["steps"], [Losses(*each) for each in state["losses"]]
            self.rng.bit_generator.state = state["rng"]

"""Graph attention over viewpoints, trained by discrete soft actor-critic (ARiADNE).

A training is a session around :class:`AttentionTraining`. It draws its own maps and tasks, so it takes no scenario. The
folder gets ``weights.safetensors`` (the policy that did best in evaluation), ``training.json`` (configuration, seed,
versions, commits, evaluations), ``checkpoint.safetensors`` (everything that a resumed training needs) and
``tensorboard/``. The same seed gives the same weights, resumed or not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from torch import nn

from indoor_explorers.learners.attention.flights import Choice, drawn_task, fly, greedy
from indoor_explorers.learners.attention.graph import GraphSettings
from indoor_explorers.learners.attention.model import weights_of
from indoor_explorers.learners.attention.network import Loaded, NetworkSettings, write_weights
from indoor_explorers.learners.attention.sac import Losses, Sac, SacSettings
from indoor_explorers.learners.pockets.maps import MapSettings, map_record
from indoor_explorers.learners.sessions.checkpoint import read_checkpoint, reporting_damage, write_checkpoint
from indoor_explorers.learners.sessions.evaluation import evaluate_world, mean_evaluation
from indoor_explorers.learners.sessions.seeds import evaluation_seeds, training_seeds
from indoor_explorers.learners.sessions.session import Session, Trainee, TrainingStatus
from indoor_explorers.learners.sessions.tensorboard import Scalars
from indoor_explorers.learners.sessions.train import TrainingMethod
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS

__all__ = ["DEFAULT_SCENARIO", "TrainingConfig", "train"]

#: There is none: each flight draws its map, lidar, team and radio.
DEFAULT_SCENARIO = None
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

    def drawn(self, count: int, ahead: int, rng: np.random.Generator) -> list[list[Choice]]:
        """Return ``count`` random choices that went on as is known, each with up to ``ahead`` next ones."""
        usable = np.flatnonzero([choice.follows >= 0 for choice in self.choices])
        return [self._trail(int(row), ahead) for row in rng.choice(usable, count)]

    def _trail(self, row: int, ahead: int) -> list[Choice]:
        trail = [self.choices[row]]
        while len(trail) <= ahead and trail[-1].follows == 1:
            trail.append(self.choices[row + len(trail)])
        return trail

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


class TrainingConfig(MapSettings):
    """Describe one training completely, together with its seed."""

    episodes: int = Field(20_000, ge=1)
    """Training flights."""
    first_update: int = Field(1000, ge=1)
    """Choices before the first update."""
    choices_per_update: int = Field(4, ge=1)
    """Choices that are flown for one update."""
    replay: int = Field(20_000, ge=2)
    """Choices that are kept."""
    graph: GraphSettings = GraphSettings()
    network: NetworkSettings = NetworkSettings()
    sac: SacSettings = SacSettings()
    evaluation_episodes: int = Field(32, ge=1)
    """Flights of one evaluation."""
    evaluation_every: int = Field(50, ge=1)
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
        """The present policy, as training flies it."""
        return self._loaded(self.sac.policy)

    @property
    def averaged(self) -> Loaded:
        """The moving average of the policy, which is evaluated and kept."""
        return self._loaded(self.sac.averaged.module)

    def _loaded(self, policy: nn.Module) -> Loaded:
        return Loaded(weights_of(policy), self.config.network, self.config.graph)

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
            self.losses.append(self.sac.update(self.replay.drawn(config.sac.batch, config.sac.ahead, self.rng)))
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
        """Fly the averaged policy greedily without the guard on tasks that training does not use."""
        loaded, first = self.averaged, evaluation_seeds(self.seed)
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
        """Write the averaged network."""
        write_weights(folder / WEIGHTS, self.averaged)

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


@contextmanager
def _trainee(config: TrainingConfig, scenario: None, seed: int, session: Session) -> Iterator[AttentionTraining]:
    with Scalars(session):
        yield AttentionTraining(config, seed, session.checkpoint)


train = TrainingMethod(partial(map_record, "attention-sac"), _trainee)

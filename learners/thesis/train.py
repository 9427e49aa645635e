"""The DDDQN of the IndoorExplorers thesis, with its mistakes as switches.

A training is a session around :class:`indoor_explorers.learners.thesis.train.ThesisTraining`.
The folder gets ``weights.safetensors`` (the latest network, as in the thesis), ``episodes.csv`` (every training
episode: the thesis's curve), ``training.json`` (configuration, seed, versions, commits, evaluations) and
``checkpoint.safetensors`` (everything that a resumed training needs). The same seed gives the same weights, resumed
or not.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End
from indoor_explorers.learners.sessions.checkpoint import read_checkpoint, reporting_damage, write_checkpoint
from indoor_explorers.learners.sessions.networks import network_arrays
from indoor_explorers.learners.sessions.record import new_record
from indoor_explorers.learners.sessions.seeds import evaluation_seeds, training_seeds
from indoor_explorers.learners.sessions.session import Session, Trainee, TrainingStatus, crossed_multiple
from indoor_explorers.learners.sessions.train import TrainingMethod
from indoor_explorers.learners.thesis.config import MENDED, TrainingConfig
from indoor_explorers.learners.thesis.evaluation import evaluate
from indoor_explorers.learners.thesis.history import History
from indoor_explorers.learners.thesis.inference import MOVES, ImageFormat, load_weights, write_weights
from indoor_explorers.learners.thesis.learner import ThesisLearner, greedy
from indoor_explorers.learners.thesis.replay import ThesisReplay, Transitions
from indoor_explorers.learners.thesis.vector_flight import ImageFlight
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS

__all__ = ["MENDED", "TrainingConfig", "train"]

EPISODES = "episodes.csv"


class ThesisTraining(Trainee):
    """Train on a batch of episodes; an update is one move of all UAVs and the network updates that are then due.

    As in the thesis, the latest network is kept, not the best one.
    """

    unit = "episodes"
    steps = 0

    def __init__(self, config: TrainingConfig, scenario: Scenario, seed: int, checkpoint: Path | None = None) -> None:
        self._first_seed = training_seeds(seed)
        self.config, self.seed = config, seed
        self.task = config.task(scenario)
        self.begun = 0
        self.greedy_curve: list[float] = []
        """Mean coverage by step in the last evaluation."""
        self.losses: list[float] = []
        self.rng = np.random.default_rng(np.random.SeedSequence(seed))
        pilots = range(self.task.team if config.mates == "learn" else 1)
        image_settings: dict[str, Any] = {
            "frames": config.frame_stack,
            "identity": config.identity,
            "centred": config.centred,
        }
        self.flight = ImageFlight(self.task, config.environments, self._next_seed, pilots=pilots, **image_settings)
        self.image_format = ImageFormat(*self.flight.shape, **image_settings)
        self.learner = ThesisLearner(config, self.image_format, seed)
        self.replay = ThesisReplay(config.memory, self.image_format)
        self.history = History(config.environments)
        if config.initial_weights is not None:
            self.learner.start_from(self._weights(expanded(config.initial_weights)))
        if checkpoint is not None:
            self._restore(checkpoint)

    def _weights(self, path: Path) -> dict[str, NDArray[np.float32]]:
        image_format, arrays = load_weights(path)
        if image_format != self.image_format:
            raise InputError(
                f"{path}: expected weights of a network that sees {self.image_format}, got {image_format}; give others"
            )
        return arrays

    def _next_seed(self) -> int:
        self.begun += 1
        return self._first_seed + self.begun

    @property
    def episodes(self) -> int:
        """Finished training episodes."""
        return len(self.history.rows)

    @property
    def done(self) -> bool:
        """Tell whether the training is complete."""
        return self.episodes >= self.config.episodes

    def update(self) -> None:
        """Move every UAV, store the transitions, learn, and start new episodes in place of finished ones."""
        flight, state = self.flight, self.flight.world.state
        learning = flight.columns_of(np.arange(self.config.environments))
        learning = learning[flight.end[learning] == End.FLYING]
        actions = self._choose(learning)
        seen = flight.step(actions, learning)
        coverage = flight.world.team_coverage
        self.history.record_step(state.reward[:, 0], state.step, coverage)
        self.replay.add(
            Transitions(
                seen, actions[learning], state.reward.ravel()[learning].astype(np.float32), self._terminal(learning)
            )
        )
        self._learn(len(learning))
        over = np.flatnonzero(flight.over)
        if len(over):
            self.history.record_ends(over, state.step, coverage, state.end[:, 0])
            flight.restart(over)

    def _choose(self, learning: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return moves (C,): epsilon-greedy ones for the ``learning`` columns, random ones for all others."""
        actions = self.rng.integers(MOVES, size=self.flight.columns)
        epsilon = [self.config.epsilon(self.steps + k) for k in range(len(learning))]
        sure = learning[self.rng.random(len(learning)) >= epsilon]
        if len(sure):
            actions[sure] = greedy(self.learner.online, self.flight.images[sure])
        return actions

    def _terminal(self, learning: NDArray[np.int64]) -> NDArray[np.bool_]:
        end = self.flight.end[learning]
        return np.asarray((end != End.FLYING) & (self.config.budget_terminal | (end != End.BUDGET)))

    def _learn(self, moves: int) -> None:
        """Count the moves; copy the target network and update the network if due."""
        config, before = self.config, self.steps
        self.steps += moves
        if self.replay.filled < config.batch:
            return
        if crossed_multiple(before, self.steps, config.target_every):
            self.learner.copy_target()
        for _ in range(self.steps // config.learn_every - before // config.learn_every):
            self.losses.append(float(self.learner.update(self.replay.sample(config.batch, self.rng))))

    def evaluate(self) -> dict[str, int | float]:
        """Evaluate the network, and keep its mean coverage by step."""
        online, config = self.learner.online, self.config
        found, self.greedy_curve = evaluate(
            lambda images: greedy(online, images),
            self.task,
            config.evaluation_episodes,
            evaluation_seeds(self.seed),
            self.episodes,
            frames=config.frame_stack,
            identity=config.identity,
            centred=config.centred,
        )
        return found._asdict()

    def status(self) -> TrainingStatus:
        """Return the current status; total_steps is an estimate, since the training's length is given in episodes."""
        loss = float(np.mean(self.losses)) if self.losses else float("nan")
        self.losses.clear()
        share = min(max(self.episodes, 1) / self.config.episodes, 1.0)
        return TrainingStatus(
            total_steps=max(int(self.steps / share), 1),
            epsilon=self.config.epsilon(self.steps),
            loss=loss,
            episodes=self.episodes,
        )

    def results(self) -> dict[str, Any]:
        """Return the finished episodes, and the coverage by step in training and in the last evaluation."""
        return {
            "episodes": self.episodes,
            "training_coverage_by_step": self.history.by_step(),
            "greedy_coverage_by_step": self.greedy_curve,
        }

    def save(self, folder: Path) -> None:
        """Write the checkpoint, the weights of the current network and the table of episodes."""
        data = {f"replay/{name}": array[: self.replay.filled] for name, array in self.replay.data._asdict().items()}
        state = {
            "steps": self.steps,
            "begun": self.begun,
            "written": self.replay.written,
            "greedy_curve": self.greedy_curve,
            "rng": self.rng.bit_generator.state,
        }
        tensors = self.learner.tensors() | self.flight.tensors() | self.history.tensors() | data
        write_checkpoint(folder, tensors, state)
        write_weights(folder / WEIGHTS, network_arrays(self.learner.online), self.image_format)
        self.history.write(folder / EPISODES, self.config.episodes)

    def _restore(self, path: Path) -> None:
        """Restore the state that :meth:`save` wrote.

        Raises :class:`InputError` if the file is damaged.
        """
        tensors, state = read_checkpoint(path)
        with reporting_damage(path):
            for part in (self.learner, self.flight, self.history):
                part.restore(tensors)
            for name, array in self.replay.data._asdict().items():
                array[: len(tensors[f"replay/{name}"])] = tensors[f"replay/{name}"]
            self.steps, self.begun, self.replay.written = state["steps"], state["begun"], state["written"]
            self.rng.bit_generator.state = state["rng"]
            if "evaluations" in state:  # older checkpoints
                state["greedy_curve"] = state["evaluations"][-1][1] if state["evaluations"] else []
            self.greedy_curve = state["greedy_curve"]


def _trainee(
    config: TrainingConfig, scenario: Scenario, seed: int, session: Session
) -> AbstractContextManager[ThesisTraining]:
    return nullcontext(ThesisTraining(config, scenario, seed, session.checkpoint))


train = TrainingMethod(partial(new_record, "dddqn-thesis"), _trainee)

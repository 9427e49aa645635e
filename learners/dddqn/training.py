"""One training as an object: what happens in a tick, and everything that a checkpoint must hold."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Mask
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.scenario import Scenario
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.flock import Flock
from indoor_explorers.learners.dddqn.learner import BLOCKED, Learner, greedy
from indoor_explorers.learners.dddqn.replay import Replay
from indoor_explorers.learners.dddqn.trial import Trial, evaluate
from indoor_explorers.learners.dddqn.weights import read_tensors, write_tensors

#: Episode seeds of trainings start here, 2 * SEED_BLOCK apart, far from any seed that comparisons use; each
#: block's second half is for evaluation.
SEED_BLOCK = 2**40


class Training:
    """Train on the world's batch directly; every tick is a move of all UAVs and an update of the network."""

    def __init__(self, config: TrainingConfig, scenario: Scenario, seed: int) -> None:
        if seed < 0:
            raise InputError(f"expected a seed of at least 0, got {seed}")
        self.config, self.seed = config, seed
        self.task = config.task(scenario)
        self.steps = self.episodes = 0
        self.trials: list[Trial] = []
        self.losses: list[float] = []
        self.rng = np.random.default_rng(np.random.SeedSequence(seed))
        self.learner = Learner(seed, config.learning_rate)
        self.flock = Flock(self.task, config.environments, self._next_seed)
        self.replay = Replay(self._slots(), self.flock.columns)

    def _slots(self) -> int:
        slots = self.config.replay_steps // self.flock.columns
        if slots <= 2 * self.config.return_steps:
            raise InputError(
                f"expected replay_steps of more than {2 * self.config.return_steps} times the {self.flock.columns} "
                f"UAVs in training, got {self.config.replay_steps}; raise replay_steps or lower environments"
            )
        return slots

    def _next_seed(self) -> int:
        self.episodes += 1
        return SEED_BLOCK * (1 + 2 * self.seed) + self.episodes

    @property
    def share(self) -> float:
        """How much of the training is done, from 0 to 1."""
        return min(self.steps / self.config.total_steps, 1.0)

    @property
    def done(self) -> bool:
        """Tell whether all moves have been made."""
        return self.steps >= self.config.total_steps

    def tick(self) -> None:
        """Make one move of every UAV, remember it, begin new episodes where due, and learn."""
        flock, over = self.flock, self.flock.over
        flock.observe(np.arange(flock.columns))
        action, explored = self._choose()
        reward = flock.step(action)
        scene, moves = flock.scene, flock.moves
        self.replay.add(scene, moves, action, reward, flock.terminal & ~over, explored, over)
        flock.restart(np.flatnonzero(over.reshape(self.config.environments, -1).all(axis=1)))
        self.steps += int((~over).sum())
        if self.steps >= self.config.warmup_steps and self.replay.filled > 2 * self.config.return_steps:
            self.losses += [self._learn() for _ in range(self.config.updates_per_tick)]

    def _choose(self) -> tuple[NDArray[np.int64], Mask]:
        """Choose epsilon-greedily among the legal moves; return them (C,) and which were drawn at random."""
        scene, moves = self.flock.scene, self.flock.moves
        explored = self.rng.random(len(scene)) < self.config.epsilon(self.share)
        lots = self.rng.random((len(scene), 4)) - moves[:, :, BLOCKED]
        return np.where(explored, lots.argmax(axis=1), greedy(self.learner.online, scene, moves)), explored

    def _learn(self) -> float:
        config, share = self.config, self.share
        batch = self.replay.sample(config.batch, config.return_steps, config.gamma(share), self.rng)
        loss = self.learner.update(
            batch,
            rate=config.rate(share),
            clip=config.gradient_clip,
            target_rate=config.target_rate,
            average_rate=config.average_rate,
        )
        return float(loss)

    def take_trial(self) -> Trial:
        """Evaluate the averaged weights and keep them when they are the best so far."""
        first = SEED_BLOCK * (2 + 2 * self.seed)
        trial = evaluate(self.learner.average, self.task, self.config.evaluation_episodes, first, self.steps)
        if not self.trials or trial.t_goal <= min(other.t_goal for other in self.trials):
            self.learner.best.load_state_dict(self.learner.average.state_dict())
        self.trials.append(trial)
        return trial

    def identity(self) -> dict[str, Any]:
        """Return what makes this training: a checkpoint of another one is refused."""
        return {"config": self.config.model_dump(mode="json"), "task": self.task.fingerprint, "seed": self.seed}

    def save(self, path: Path) -> None:
        """Write everything to a safetensors file."""
        filled = self.replay.filled
        slots = {f"replay/{name}": array[:filled] for name, array in self.replay.data._asdict().items()}
        notes = self.identity() | {
            "steps": self.steps,
            "episodes": self.episodes,
            "written": self.replay.written,
            "trials": self.trials,
            "rng": self.rng.bit_generator.state,
        }
        write_tensors(path, self.learner.tensors() | self.flock.tensors() | slots, {"training": json.dumps(notes)})

    def load(self, path: Path) -> None:
        """Go on exactly where :meth:`save` left off.

        Raises:
            InputError: the file is damaged, or from another configuration, scenario or seed.

        """
        tensors, metadata = read_tensors(path)
        try:
            notes = json.loads(metadata["training"])
            self._refuse_others(notes, path)
            self.learner.restore(tensors)
            self.flock.restore(tensors)
            for name, array in self.replay.data._asdict().items():
                array[: len(tensors[f"replay/{name}"])] = tensors[f"replay/{name}"]
        except (KeyError, RuntimeError, json.JSONDecodeError) as error:
            raise InputError(
                f"{path}: expected a checkpoint of this version, got something else ({error!r})"
            ) from error
        self.steps, self.episodes, self.replay.written = notes["steps"], notes["episodes"], notes["written"]
        self.trials = [Trial(*trial) for trial in notes["trials"]]
        self.rng.bit_generator.state = notes["rng"]

    def _refuse_others(self, notes: dict[str, Any], path: Path) -> None:
        mine = self.identity()
        for part in ("seed", "task"):
            if notes[part] != mine[part]:
                raise InputError(f"{path}: expected {part} {mine[part]}, got {notes[part]}; resume with the same one")
        for key, value in mine["config"].items():
            if notes["config"].get(key) != value:
                raise InputError(
                    f"{path}: expected {key} {value}, got {notes['config'].get(key)}; resume with the same settings"
                )

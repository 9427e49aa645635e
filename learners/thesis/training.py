"""One training as an object: what happens in a tick, and everything that a checkpoint must hold."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.state import End
from indoor_explorers.learners.sessions.seeds import training_seeds, trial_seeds
from indoor_explorers.learners.sessions.tensors import read_tensors, write_tensors
from indoor_explorers.learners.thesis.config import TrainingConfig
from indoor_explorers.learners.thesis.evaluation import Flown, Trial, evaluate
from indoor_explorers.learners.thesis.history import History
from indoor_explorers.learners.thesis.learner import Learner, greedy
from indoor_explorers.learners.thesis.replay import Places, Replay
from indoor_explorers.learners.thesis.sizes import MOVES, Eye
from indoor_explorers.learners.thesis.vector_flight import Fleet
from indoor_explorers.learners.thesis.weights import load_weights


class Training:
    """Train on the world's batch directly; a tick is a move of all UAVs, and learning as often as is due."""

    def __init__(self, config: TrainingConfig, scenario: Scenario, seed: int) -> None:
        self._first_seed = training_seeds(seed)
        self.config, self.seed = config, seed
        self.task = config.task(scenario)
        self.steps = self.begun = 0
        self.seconds = 0.0
        """Flown up to the checkpoint that it goes on from."""
        self.evaluations: list[Flown] = []
        self.losses: list[float] = []
        self.commits: list[str | None] = []
        """Commits of the source that the training ran under, the one it began with first."""
        self.rng = np.random.default_rng(np.random.SeedSequence(seed))
        pilots = range(self.task.team if config.mates == "learn" else 1)
        looks: dict[str, Any] = {"frames": config.frame_stack, "identity": config.identity}
        self.fleet = Fleet(self.task, config.environments, self._next_seed, pilots=pilots, **looks)
        self.eye = Eye(*self.fleet.shape, **looks)
        self.learner = Learner(config, self.eye, seed)
        self.replay = Replay(config.memory, self.eye)
        self.history = History(config.environments)
        if config.initial_weights is not None:
            self.learner.start_from(self._weights(Path(config.initial_weights)))

    def _weights(self, path: Path) -> dict[str, NDArray[np.float32]]:
        eye, arrays = load_weights(path)
        if eye != self.eye:
            raise InputError(f"{path}: expected weights of a network that sees {self.eye}, got {eye}; give others")
        return arrays

    def _next_seed(self) -> int:
        self.begun += 1
        return self._first_seed + self.begun

    @property
    def episodes(self) -> int:
        """Episodes that are over."""
        return len(self.history.rows)

    @property
    def done(self) -> bool:
        """Tell whether all episodes have been flown."""
        return self.episodes >= self.config.episodes

    @property
    def trials(self) -> list[Trial]:
        """The evaluations so far."""
        return [flown.trial for flown in self.evaluations]

    def tick(self) -> None:
        """Make one move of every UAV, remember it, learn, and begin new episodes where due."""
        fleet, state = self.fleet, self.fleet.world.state
        pupils = fleet.columns_of(np.arange(self.config.environments))
        pupils = pupils[fleet.end[pupils] == End.FLYING]
        actions = self._choose(pupils)
        seen = fleet.step(actions, pupils)
        coverage = fleet.world.team_coverage
        self.history.note_step(state.reward[:, 0], state.step, coverage)
        self.replay.add(
            Places(seen, actions[pupils], state.reward.ravel()[pupils].astype(np.float32), self._terminal(pupils))
        )
        self._learn(len(pupils))
        over = np.flatnonzero(fleet.over)
        if len(over):
            self.history.note_ends(over, state.step, coverage, state.end[:, 0])
            fleet.restart(over)

    def _choose(self, pupils: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return moves (C,): those of ``pupils`` epsilon-greedily, all others at random."""
        actions = self.rng.integers(MOVES, size=self.fleet.columns)
        epsilon = [self.config.epsilon(self.steps + k) for k in range(len(pupils))]
        sure = pupils[self.rng.random(len(pupils)) >= epsilon]
        if len(sure):
            actions[sure] = greedy(self.learner.online, self.fleet.images[sure])
        return actions

    def _terminal(self, pupils: NDArray[np.int64]) -> NDArray[np.bool_]:
        end = self.fleet.end[pupils]
        return np.asarray((end != End.FLYING) & (self.config.budget_terminal | (end != End.BUDGET)))

    def _learn(self, moves: int) -> None:
        """Count the moves; copy the target network and update as often as that makes due."""
        config, before = self.config, self.steps
        self.steps += moves
        if self.replay.filled < config.batch:
            return
        if before // config.target_every < self.steps // config.target_every:
            self.learner.copy_target()
        for _ in range(self.steps // config.learn_every - before // config.learn_every):
            self.losses.append(float(self.learner.update(self.replay.sample(config.batch, self.rng))))

    def take_trial(self) -> Trial:
        """Evaluate the network."""
        online, config = self.learner.online, self.config
        flown = evaluate(
            lambda images: greedy(online, images),
            self.task,
            config.evaluation_episodes,
            trial_seeds(self.seed),
            self.episodes,
            frames=config.frame_stack,
            identity=config.identity,
        )
        self.evaluations.append(flown)
        return flown.trial

    def identity(self) -> dict[str, Any]:
        """Return what makes this training: a checkpoint of another one is refused."""
        return {"config": self.config.model_dump(mode="json"), "task": self.task.fingerprint, "seed": self.seed}

    def save(self, path: Path, seconds: float = 0.0) -> None:
        """Write everything to a safetensors file, and how many seconds it took since :attr:`seconds`."""
        places = {f"replay/{name}": array[: self.replay.filled] for name, array in self.replay.data._asdict().items()}
        notes = self.identity() | {
            "steps": self.steps,
            "begun": self.begun,
            "seconds": self.seconds + seconds,
            "written": self.replay.written,
            "evaluations": self.evaluations,
            "commits": self.commits,
            "rng": self.rng.bit_generator.state,
        }
        tensors = self.learner.tensors() | self.fleet.tensors() | self.history.tensors() | places
        write_tensors(path, tensors, {"training": json.dumps(notes)})

    def load(self, path: Path) -> None:
        """Go on exactly where :meth:`save` left off.

        Raises:
            InputError: the file is damaged, or from another configuration, scenario or seed.

        """
        tensors, metadata = read_tensors(path)
        try:
            notes = json.loads(metadata["training"])
            self._refuse_others(notes, path)
            for part in (self.learner, self.fleet, self.history):
                part.restore(tensors)
            for name, array in self.replay.data._asdict().items():
                array[: len(tensors[f"replay/{name}"])] = tensors[f"replay/{name}"]
        except (KeyError, RuntimeError, json.JSONDecodeError) as error:
            raise InputError(
                f"{path}: expected a checkpoint of this version, got something else ({error!r})"
            ) from error
        self.steps, self.begun, self.replay.written = notes["steps"], notes["begun"], notes["written"]
        self.seconds, self.commits = notes["seconds"], notes.get("commits", [None])  # unknown in checkpoints of before
        self.evaluations = [Flown(Trial(*trial), curve) for trial, curve in notes["evaluations"]]
        self.rng.bit_generator.state = notes["rng"]

    def _refuse_others(self, notes: dict[str, Any], path: Path) -> None:
        mine = self.identity()
        for key, value in {"seed": mine["seed"], "task": mine["task"], **mine["config"]}.items():
            found = (notes if key in ("seed", "task") else notes["config"]).get(key)
            if found != value:
                raise InputError(f"{path}: expected {key} {value}, got {found}; resume with the same one")

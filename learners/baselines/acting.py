"""A trained network as a policy: it encodes views as in training and takes the best legal action."""

from __future__ import annotations

import pickle
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.observations import Encoder, make_encoder
from indoor_explorers.env.policies.explanation import of_moves
from indoor_explorers.env.policies.policy import TRAINED_GOAL, Policy
from indoor_explorers.env.policies.registry import missing_module
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.env.provenance import RECORD
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.learners.baselines.config import EGOCENTRIC, BaselineConfig
from indoor_explorers.learners.baselines.trainee import BaselineRecord, Scores, best_moves
from indoor_explorers.learners.guard import WatchedPilot
from indoor_explorers.learners.sessions.process import one_thread
from indoor_explorers.learners.sessions.record import RecordedWeights, digest_of, read_record


@dataclass(frozen=True)
class TrainedModel:
    """The content of the folder of a training."""

    record: BaselineRecord
    """The record of the training."""
    config: BaselineConfig
    """Its hyperparameters."""
    scores: Scores
    """The network."""

    def encoder(self, briefing: Briefing) -> Encoder:
        """Return the encoder of a UAV's views that was used in training.

        Raises :class:`InputError` if the observation depends on the map's size, and the map has another one than in
        training.
        """
        if self.config.observation != EGOCENTRIC and briefing.shape != self.record.shape:
            raise InputError(
                f"expected a map of {self.record.shape[0]} x {self.record.shape[1]} cells as in training, got "
                f"{briefing.shape[0]} x {briefing.shape[1]}; train with observation={EGOCENTRIC} for maps of any size"
            )
        return make_encoder(self.config.recipe, briefing)


@dataclass(frozen=True, kw_only=True)
class TrainedPolicy(RecordedWeights, Policy):
    """Fly a trained network: greedy, and without memory except in the guard.

    Torch runs on one thread during a decision. Everything but the guard's back-off is deterministic. A process reads
    the folder once, and again when its files change.

    Raises:
        InputError: ``path`` is missing or holds no training with this library.

    """

    plans_for: ClassVar[str] = TRAINED_GOAL

    MODEL: ClassVar[str]
    """Name of the file with the best network."""
    LEARNERS: ClassVar[tuple[str, ...]]
    """Learners whose networks this policy flies; each has a module of that name."""

    path: str
    """The folder that ``indoor-explorers train`` wrote, or a model file in it."""
    mask: bool = True
    """Choose among the legal actions only, even if the learner was trained without an action mask."""
    guard: bool = False
    """Fly to the nearest frontier while the network makes no progress."""

    def __post_init__(self) -> None:
        self.trained()

    @staticmethod
    @abstractmethod
    def scores(module: Any, config: Any, inputs: int, model: Path) -> Scores:
        """Return the network in the file ``model``, for observations of ``inputs`` numbers.

        Raises one of :data:`DAMAGE` if the file holds no weights, or those of another network.
        """

    def model_file(self) -> Path:
        """Return the path of the model."""
        return folder_and_model(self.path, self.MODEL)[1]

    def trained(self) -> TrainedModel:
        """Return the training that ``path`` leads to."""
        folder, model = folder_and_model(self.path, self.MODEL)
        return _read_once(type(self), folder, model, changed(folder / RECORD, model))

    def provenance(self) -> dict[str, str]:
        """Return the hash of the weights, the learner and the fingerprint of the training scenario."""
        record, digest = self.trained().record, digest_of(self.model_file())
        return {"weights_sha256": digest, "learner": record.learner, "trained_on": record.fingerprint}

    def weights_paths(self) -> list[Path]:
        """Return the path of the model."""
        return [self.model_file()]

    def pilot(self, briefing: Briefing) -> TrainedPilot:
        """Make the pilot of one UAV for one episode."""
        return TrainedPilot(self, self.trained().encoder(briefing), briefing)


class TrainedPilot(WatchedPilot):
    """Encode one UAV's views and take the best action."""

    def __init__(self, policy: TrainedPolicy, encoder: Encoder, briefing: Briefing) -> None:
        super().__init__(briefing, guard=policy.guard)
        self._scores, self._mask, self._encoder = policy.trained().scores, policy.mask, encoder

    def act(self, view: View) -> int:
        """Choose the best action."""
        with one_thread():
            scores = self._scores(self.perceive(view)[None])
        legal = view.legal if self._mask else np.ones(5, np.bool_)
        action = self.review(view, int(best_moves(scores, legal[None])[0]))
        if self.explaining:
            self.kept = of_moves(view, action, scores.ravel()[:5], "the learner's score of the move", {})
        return action

    def perceive(self, view: View) -> NDArray[np.float32]:
        """Return the observation (D,) float32 of a view, encoded as in training."""
        seen: NDArray[np.float32] = self._encoder.observation(view)
        return seen


@lru_cache(maxsize=8)
def _read_once(kind: type[TrainedPolicy], folder: Path, model: Path, changed: tuple[int, ...]) -> TrainedModel:
    """Return the training in a folder; ``changed`` makes the cache miss when its files change."""
    record, module, config = read_training(folder, kind.LEARNERS)
    try:
        return TrainedModel(record, config, kind.scores(module, config, record.inputs, model))
    except DAMAGE as error:
        raise InputError(
            f"{model}: expected the weights that {record.learner} trained with this {RECORD}, got something else "
            f"({error!r:.200})"
        ) from error


#: Errors that libraries raise on a file that holds no weights, or those of another network.
DAMAGE = (SafetensorError, RuntimeError, KeyError, ValueError, BadZipFile, pickle.UnpicklingError, OSError)


def folder_and_model(path: str, model: str) -> tuple[Path, Path]:
    """Return the folder of a training and its model file: ``path`` itself if it is a file, else ``model`` in it."""
    given = expanded(path)
    return (given.parent, given) if given.is_file() else (given, given / model)


def read_training(folder: Path, learners: Sequence[str]) -> tuple[BaselineRecord, Any, Any]:
    """Return the record of a folder, the module of its learner and its configuration.

    Raises :class:`InputError` if the folder holds no training of these ``learners``, or their library is not installed.
    """
    record = read_record(folder, BaselineRecord, learners)
    try:
        module = import_module(f"{__package__}.{record.learner.replace('-', '_')}")
    except ModuleNotFoundError as error:
        raise InputError(f"{folder}: {missing_module(error)}") from error
    return record, module, validated(module.TrainingConfig, record.config, str(folder / RECORD))


def changed(*paths: Path) -> tuple[int, ...]:
    """Return the modification times of files in nanoseconds, 0 for missing ones."""
    return tuple(path.stat().st_mtime_ns if path.is_file() else 0 for path in paths)

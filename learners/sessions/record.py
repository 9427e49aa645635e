"""The record of a training: ``training.json`` in its folder, plain data that executes nothing when read."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.provenance import RECORD, joined, record_of, recorded_maps, source_commit, versions
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.scenarios.seed_sets import SeedUse
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.learners.sessions.seeds import recorded_seeds
from indoor_explorers.learners.sessions.settings import LearnerSettings

#: Packages that the result of any training depends on.
PACKAGES = ("indoor-explorers", "numpy", "numba", "torch")


class TrainingRecord(BaseModel):
    """How the network in a folder was trained."""

    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True)

    learner: str
    """Name of the learner, such as ``sb3-ppo``."""
    seed: int
    """Seed of the training."""
    scenario: dict[str, Any]
    """The scenario that it was trained on; empty for a learner that draws its own."""
    fingerprint: str
    """Fingerprint of the scenario; empty without one."""
    task: str | None = None
    """Fingerprints of all scenarios with the rewards of the training; None in older records."""
    config: dict[str, Any]
    """Every hyperparameter."""
    versions: dict[str, str]
    """Versions of Python and of the packages that the result depends on."""
    commit: str | None
    """Commit of the source tree at the start of the training."""
    commits: tuple[str | None, ...] = ()
    """All commits that the training ran under, the first one first; empty in older records."""
    seen_maps: dict[str, tuple[str, ...]] = {}
    """The training's map files by use, as in :meth:`~indoor_explorers.env.policies.policy.Policy.seen_maps`; empty
    where all maps were generated, and in older records."""
    seconds: float = 0.0
    """Duration of the training in seconds, evaluations included."""
    done: bool = False
    """Whether the training is complete."""
    steps: int = 0
    """Moves made in training, all environments together."""
    evaluations: tuple[dict[str, int | float], ...] = ()
    """Figures of each evaluation, oldest first."""

    @property
    def minutes(self) -> float:
        """Duration of the training in minutes."""
        return self.seconds / 60

    def continued_from(self, before: TrainingRecord) -> dict[str, Any]:
        """Return the fields that the record of a resumed training takes over from the one ``before``."""
        commits = before.commits or (before.commit,)
        if commits[-1] != self.commit:
            commits = (*commits, self.commit)
        kept = {name: getattr(before, name) for name in ("seconds", "steps", "evaluations", "commit")}
        return {**kept, "commits": commits}


Kind = TypeVar("Kind", bound=TrainingRecord)


def new_record(
    learner: str, config: LearnerSettings, scenario: Scenario | None, seed: int, packages: Iterable[str] = ()
) -> TrainingRecord:
    """Return the record of a new training whose result depends on :data:`PACKAGES` and on ``packages``."""
    commit, tasks = source_commit(), [] if scenario is None else config.tasks(scenario)
    digests = tuple(dict.fromkeys(digest for task in tasks for digest in _file_digests(task)))
    return TrainingRecord(
        learner=learner,
        seed=seed,
        scenario={} if scenario is None else scenario.model_dump(mode="json"),
        fingerprint="" if scenario is None else scenario.fingerprint,
        task=" ".join(task.fingerprint for task in tasks),
        config=config.model_dump(mode="json"),
        versions={"python": platform.python_version()} | versions((*PACKAGES, *packages)),
        commit=commit,
        commits=(commit,),
        seen_maps={use: digests for use in (SeedUse.TRAINING, SeedUse.VALIDATION) if digests},
    )


def _file_digests(task: Scenario) -> list[str]:
    """Return the digests of a scenario's map files and of their layouts; none for generated maps."""
    maps = task.map
    plans = [] if maps.generated else [maps.floorplan(index, 0) for index in range(maps.count)]
    return [digest for plan in plans for digest in (plan.digest, plan.layout)]


def write_record(record: TrainingRecord, folder: Path, results: Mapping[str, Any]) -> None:
    """Write a record with further ``results`` of the learner into the folder of a training, atomically."""
    facts = {**record.model_dump(mode="json"), **results}
    with written_whole(folder / RECORD) as partial:
        partial.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")


def digest_of(path: Path) -> str:
    """Return the SHA-256 digest of a weights file, for the provenance of results."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


class RecordedWeights:
    """The part of a policy that reports the trainings of its weights, from the records of these trainings."""

    def weights_paths(self) -> list[Path]:
        """Return the paths of the weights that the policy may fly."""
        raise NotImplementedError

    def seen_seeds(self) -> dict[str, list[range]]:
        """Return the seeds of the trainings and their evaluations, and of the rooms that the weights were chosen on."""
        return joined([recorded_seeds(record_of(path)) for path in self.weights_paths()])

    def seen_maps(self) -> dict[str, list[str]]:
        """Return the map files that the trainings flew."""
        return joined([recorded_maps(record_of(path)) for path in self.weights_paths()])


def existing_record(mine: Kind, config: LearnerSettings, folder: Path) -> Kind | None:
    """Return the record in a folder, of the same training as the new record ``mine``; None without one.

    Settings that were added since it was written have their defaults, those of ``config``. The weights do not depend
    on how often a checkpoint is written, so that may differ.

    Raises :class:`InputError` if the folder holds another training: of another learner, seed, scenario or
    configuration.
    """
    if not (folder / RECORD).exists():
        return None
    there = read_record(folder, type(mine), [mine.learner])
    with suppress(ValidationError):  # a setting that was removed since: the comparison names it
        whole = type(config).model_validate(there.config).model_dump(mode="json")
        there = there.model_copy(update={"config": whole})
    asked = {name: getattr(mine, name) for name in ("seed", "task", "fingerprint")} | mine.config
    found = {name: getattr(there, name) for name in ("seed", "fingerprint")} | there.config
    found["task"] = mine.task if there.task is None else there.task
    for name, value in asked.items():
        if name != "checkpoint_every" and found.get(name) != value:
            raise InputError(
                f"{folder} holds a training with {name} {found.get(name)}, expected {value}; give the same as then, or "
                "another --out"
            )
    return there


def read_record(folder: Path, kind: type[Kind], learners: Collection[str]) -> Kind:
    """Return the record of a folder.

    Raises :class:`InputError` if the folder is missing, or holds no training of one of these ``learners``.
    """
    path = folder / RECORD
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"{folder}: expected the folder of a training, found no {RECORD} in it; give the --out of indoor-explorers "
            "train"
        ) from error
    except ValueError as error:
        raise InputError(f"{path}: expected JSON, got {error}; train again") from error
    facts = data if isinstance(data, dict) else {}
    learner = facts.get("learner", facts.get("policy"))  # older records say "policy"
    if learner not in learners:
        found = "something else" if learner is None else f"one of {learner}"
        raise InputError(f"{folder}: expected a training of {', '.join(learners)}, got {found}; see its {RECORD}")
    return validated(kind, facts | {"learner": learner}, str(path))

"""What a folder says about its training: ``training.json``, and nothing in it that could run."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.observations import make_encoder
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.provenance import source_commit, versions
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.learners.baselines.config import BaselineConfig
from indoor_explorers.learners.baselines.evaluation import Trial

RECORD = "training.json"
#: Packages that the result of any training depends on.
PACKAGES = ("indoor-explorers", "numpy", "numba", "torch", "gymnasium")


class Record(BaseModel):
    """How the model in a folder was made."""

    model_config = ConfigDict(frozen=True, use_attribute_docstrings=True)

    learner: str
    """Name of the learner, such as ``sb3-ppo``."""
    seed: int
    """Of the training."""
    scenario: dict[str, Any]
    """What it was trained on."""
    fingerprint: str
    """Of the scenario."""
    shape: tuple[int, int]
    """(H, W) of its maps in cells."""
    inputs: int = Field(ge=1)
    """Numbers in an observation."""
    config: dict[str, Any]
    """Every hyperparameter."""
    versions: dict[str, str]
    """Of Python and the packages that matter."""
    commit: str | None
    """Of the source tree."""
    steps: int
    """Moves made."""
    evaluations: tuple[dict[str, float], ...]
    """Each :class:`Trial`."""

    @property
    def trials(self) -> list[Trial]:
        """The evaluations, oldest first."""
        return [Trial(**trial) for trial in self.evaluations]  # type: ignore[arg-type]  # steps: a whole number


def new_record(
    learner: str,
    packages: Iterable[str],
    config: BaselineConfig,
    scenario: Scenario,
    briefing: Briefing,
    seed: int,
) -> Record:
    """Return the record of a training that begins; ``briefing`` is that of one of its episodes."""
    return Record(
        learner=learner,
        seed=seed,
        scenario=scenario.model_dump(mode="json"),
        fingerprint=scenario.fingerprint,
        shape=briefing.shape,
        inputs=int(np.prod(make_encoder(config.recipe, briefing).space.shape or ())),
        config=config.model_dump(mode="json"),
        versions={"python": platform.python_version()} | versions((*PACKAGES, *packages)),
        commit=source_commit(),
        steps=0,
        evaluations=(),
    )


def write_record(record: Record, folder: Path) -> None:
    """Write the record into its folder in one go."""
    with written_whole(folder / RECORD) as partial:
        partial.write_text(json.dumps(record.model_dump(mode="json"), indent=2) + "\n", encoding="utf-8")


def read_record(folder: Path) -> Record:
    """Return the record of a folder.

    Raises:
        InputError: there is no such folder, or no baseline was trained in it.

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
    if not isinstance(data, dict) or "learner" not in data:
        raise InputError(f"{path}: expected the record of a baseline's training, got another one; see its --learner")
    return validated(Record, data, str(path))


def refuse_others(record: Record, mine: Record, path: Path) -> None:
    """Refuse to go on with a training of another learner, seed, scenario or configuration.

    Raises:
        InputError: the record is another training's.

    """
    for part in ("learner", "seed", "fingerprint"):
        if getattr(record, part) != getattr(mine, part):
            raise InputError(
                f"{path}: expected {part} {getattr(mine, part)}, got {getattr(record, part)}; resume with the same one"
            )
    for key, value in mine.config.items():
        if record.config.get(key) != value:
            raise InputError(
                f"{path}: expected {key} {value}, got {record.config.get(key)}; resume with the same settings"
            )

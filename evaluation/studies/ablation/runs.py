"""The trainings of an ablation: every variant that a learner declares, with every seed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.studies.training import find_learner, nested

#: File with the state of a training, in its folder.
STATE = "ablation.json"


class TrainingRun(NamedTuple):
    """One training."""

    learner: str
    scenario: str
    """Name or file of the scenario."""
    variant: str
    seed: int
    settings: dict[str, Any]
    """Settings that differ from the learner's defaults, by dotted keys."""
    folder: str
    """The folder of the training."""

    @property
    def title(self) -> str:
        """Its name in tables and messages."""
        return f"{self.variant}, seed {self.seed}"

    @property
    def identity(self) -> dict[str, Any]:
        """What identifies the training, as its state file stores it."""
        made: dict[str, Any] = json.loads(json.dumps(self._asdict()))
        return {key: value for key, value in made.items() if key != "folder"}


def read_state(run: TrainingRun) -> dict[str, Any]:
    """Return the state of a training: its ``minutes``, and ``weights`` once it is finished; empty before it began.

    Raises:
        InputError: the folder holds another training, or its state file is damaged.

    """
    path = Path(run.folder) / STATE
    if not path.exists():
        return {}
    try:
        state: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        found = state["order"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path}: expected the state of a training, got something else ({error!r}); delete it"
        ) from error
    for key, mine in run.identity.items():
        if found.get(key) != mine:
            raise InputError(
                f"{run.folder} holds a training with {key} {found.get(key)}, expected {mine}; give the same as then, "
                "or another --out"
            )
    return state


def runs_of(
    learner: str,
    scenario_name: str,
    scenario: Scenario,
    *,
    patterns: Sequence[str],
    settings: Mapping[str, Any],
    seeds: int,
    out: Path,
) -> list[TrainingRun]:
    """Return the trainings of the matching variants and of the full one, ordered by seed.

    Raises:
        InputError: the learner has no variants, a pattern matches none, a setting is invalid, or a folder holds
            another training.

    """
    module = find_learner(learner)
    variants = _chosen(_declared(learner, module, scenario.team), patterns)
    shared = {**getattr(module, "ABLATION_SETTINGS", {}), **settings}
    runs = [
        TrainingRun(learner, scenario_name, name, seed, {**shared, **switches}, str(out / name / f"seed-{seed}"))
        for seed in range(1, seeds + 1)
        for name, switches in variants.items()
    ]
    for run in runs:
        validated(module.TrainingConfig, nested(run.settings), f"settings of learner {learner!r}")
        read_state(run)
    return runs


def _declared(learner: str, module: Any, team: int) -> dict[str, Mapping[str, Any]]:
    if not getattr(module, "ABLATIONS", None):
        raise InputError(f"expected a learner that declares ABLATIONS, as dddqn does, got {learner!r}, which does not")
    return {**module.ABLATIONS, **(getattr(module, "TEAM_ABLATIONS", {}) if team > 1 else {})}


def _chosen(variants: Mapping[str, Mapping[str, Any]], patterns: Sequence[str]) -> dict[str, Mapping[str, Any]]:
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in variants):
            raise InputError(f"no variant is called {pattern!r}{did_you_mean(pattern, variants)}")
    full = next(iter(variants))
    return {
        name: switches
        for name, switches in variants.items()
        if name == full or any(fnmatchcase(name, pattern) for pattern in patterns)
    }

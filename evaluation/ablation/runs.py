"""Which trainings an ablation is made of: every variant that a learner declares, with every seed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.training import find_learner, nested

#: What is known of a training, in its folder.
NOTE = "ablation.json"


class TrainingRun(NamedTuple):
    """One training."""

    learner: str
    scenario: str
    """Name or file of the scenario."""
    variant: str
    seed: int
    settings: dict[str, Any]
    """All that differs from the learner's defaults, by dotted keys."""
    folder: str
    """Where the training lives."""

    @property
    def title(self) -> str:
        """The training in words."""
        return f"{self.variant}, seed {self.seed}"

    @property
    def identity(self) -> dict[str, Any]:
        """What makes the training, as a note of it is written."""
        made: dict[str, Any] = json.loads(json.dumps(self._asdict()))
        return {key: value for key, value in made.items() if key != "folder"}


def read_note(run: TrainingRun) -> dict[str, Any]:
    """Return what is known of a training: ``weights`` once it is finished, ``minutes``; empty when it never began.

    Raises:
        InputError: the folder holds another training, or its note is damaged.

    """
    path = Path(run.folder) / NOTE
    if not path.exists():
        return {}
    try:
        note: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        found = note["order"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path}: expected the note of a training, got something else ({error!r}); delete it"
        ) from error
    for key, mine in run.identity.items():
        if found.get(key) != mine:
            raise InputError(
                f"{run.folder} holds a training with {key} {found.get(key)}, expected {mine}; give the same as then, "
                "or another --out"
            )
    return note


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
    """Return the trainings of the variants whose names match any of the patterns, and of the first, all seeds 1 first.

    Raises:
        InputError: the learner has no variants, a pattern matches none, a setting is none of the learner's, or a
            folder holds another training.

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
        read_note(run)
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

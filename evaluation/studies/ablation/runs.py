"""The list of an ablation's trainings: the variants that a learner declares, each with every seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from indoor_explorers.env import InputError, Scenario
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.evaluation.studies.many_trainings import Training
from indoor_explorers.evaluation.studies.training import find_learner


def runs_of(
    learner: str,
    scenario_name: str,
    scenario: Scenario,
    *,
    patterns: Sequence[str],
    settings: Mapping[str, Any],
    seeds: int,
    out: Path,
) -> list[Training]:
    """Return the trainings of the matching variants and of the full one, ordered by seed.

    Raises:
        InputError: the learner has no variants, a pattern matches none, a setting is invalid, or a folder holds
            another training.

    """
    module = find_learner(learner)
    variants = _chosen(_declared(learner, module, scenario.team), patterns)
    shared = {**getattr(module, "ABLATION_SETTINGS", {}), **settings}
    runs = [
        Training(learner, scenario_name, name, seed, {**shared, **switches}, str(out / name / f"seed-{seed}"))
        for seed in range(1, seeds + 1)
        for name, switches in variants.items()
    ]
    for run in runs:
        run.finished()
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

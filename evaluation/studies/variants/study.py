"""What the studies of variants have in common: train the missing ones, score the finished ones, write the results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from indoor_explorers.env import Scenario
from indoor_explorers.env.files import writable
from indoor_explorers.evaluation.statistics import Estimate
from indoor_explorers.evaluation.studies.many_trainings import Failure, Training, matching, train_all
from indoor_explorers.evaluation.studies.training import find_learner
from indoor_explorers.evaluation.studies.variants.scoring import VariantScore, score

METRICS = ("t90", "t99")

Variants = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class StudyRequest:
    """What the commands of all studies of variants ask for."""

    learner: str
    scenario_name: str
    scenario: Scenario
    """The scenario that networks fly; they are trained on it too, unless the learner draws its own maps and tasks."""
    out: Path
    patterns: Sequence[str]
    """Names of variants, as patterns of file names."""
    settings: Mapping[str, Any]
    """Settings of all trainings, by dotted keys; those of a variant take precedence."""
    seeds: int
    """Trainings of each variant."""
    jobs: int
    """Processes at the same time."""
    episodes: int
    """Unseen maps that each training is evaluated on."""
    command: str
    """What the user typed."""


def trainings_of(request: StudyRequest, variants: Variants, always: Sequence[str] = ()) -> list[Training]:
    """Return the trainings of the variants that match the request's patterns, and of those in ``always``, by seed.

    Raises:
        InputError: a pattern matches no variant, a setting is invalid, or a folder holds another training.

    """
    wanted = {*always, *matching(variants, request.patterns, "variant")}
    draws_own = getattr(find_learner(request.learner), "DEFAULT_SCENARIO", request.scenario_name) is None
    runs = [
        Training(
            request.learner,
            None if draws_own else request.scenario_name,
            name,
            seed,
            {**request.settings, **settings},
            str(request.out / name / f"seed-{seed}"),
        )
        for seed in range(1, request.seeds + 1)
        for name, settings in variants.items()
        if name in wanted
    ]
    for run in runs:
        run.finished()
    return runs


def run_study(
    request: StudyRequest,
    runs: Sequence[Training],
    console: Console,
    conclude: Callable[[Sequence[VariantScore], Path], None],
) -> list[Failure]:
    """Run the unfinished trainings, fly the finished ones, and hand their scores to ``conclude``.

    Writes ``out/VARIANT/seed-S/`` for each training and ``out/judged/results.db``. Finished trainings and episodes are
    not repeated. After a Ctrl-C the finished ones are scored. Returns the trainings that failed.
    """
    with writable(request.out, "--out"):
        request.out.mkdir(parents=True, exist_ok=True)
        try:
            failures = train_all(runs, request.jobs, lambda line: console.print(line, highlight=False, soft_wrap=True))
        except KeyboardInterrupt:
            console.print("interrupted; scoring the finished trainings, which another Ctrl-C skips")
            conclude(_scored(request, runs), request.out)
            raise
        conclude(_scored(request, runs), request.out)
    return failures


def _scored(request: StudyRequest, runs: Sequence[Training]) -> list[VariantScore]:
    return score(
        runs,
        request.scenario,
        request.out,
        episodes=request.episodes,
        workers=request.jobs,
        command=request.command,
    )


def cells(name: str, estimate: Estimate) -> dict[str, str]:
    """Return the cells of a table for an estimate: ``name``, ``name_low`` and ``name_high``."""
    figures = zip(("", "_low", "_high"), estimate, strict=True)
    return {f"{name}{end}": "" if figure is None else f"{figure:.3f}" for end, figure in figures}

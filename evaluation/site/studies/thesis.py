"""The trainings of the thesis's experiments that THESIS.md shows, in short: a row of ``thesis.csv`` for each.

Written by hand from folders of ``indoor-explorers thesis``, of which it takes the trainings that are finished::

    indoor-explorers thesis --episodes 500 --out results/brief
    indoor-explorers thesis --episodes 500 --seed 2 --only 'rewards-*-stuck-2,obstacles-1' --out results/brief-2
    python -P -m indoor_explorers.evaluation.site.studies.thesis results/brief results/brief-2

A row has the command and the commit of its training, the figures of ``summary.csv``, the scores of the training
episodes (among obstacles every fifth), the coverage at every fourth step, the greedy evaluations, and among obstacles
the moves of one greedy episode. Lists are separated by spaces.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Action, World, make_policy, scenario
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.report.style.formatting import fixed, percent
from indoor_explorers.evaluation.thesis.experiments import AS_WAS, EXPERIMENTS, MENDED, ThesisExperiment
from indoor_explorers.evaluation.thesis.results import WEIGHTS, Run, read_run

MEASURED = Path(__file__).parent / "thesis.csv"
VERSIONS = (AS_WAS, MENDED)
#: Steps between two values of a curve.
STRIDE = 4
#: Episodes among which that of median coverage is kept.
FLOWN = range(1_000_000, 1_000_021)
#: Figures of a run's row of ``summary.csv``, and of each greedy evaluation.
FIGURES = ("training_score", "training_positive", "coverage", "t90", "reached", "crashed", "stuck")
EVALUATED = ("episodes", "coverage", "reached", "crashed", "stuck")
CURVES = ("training_coverage_by_step", "greedy_coverage_by_step")
COLUMNS = (
    *("experiment", "version", "seed", "command", "commit", *FIGURES, "scores", *CURVES),
    *(f"at_{name}" for name in EVALUATED),
    *("flown_seed", "moves"),
)


class Training(NamedTuple):
    """A training of the file."""

    run: Run
    """The training with the scores that were kept."""
    every: int
    """Episodes from one kept score to the next."""
    figures: dict[str, float]
    """Its figures in ``summary.csv``."""
    flown_seed: int | None
    """Seed of the greedy episode that was kept."""
    moves: tuple[str, ...]
    """The moves of each UAV in it, a digit each."""

    @property
    def seed(self) -> int:
        """The seed of the training."""
        return int(self.run.record["seed"])


def every(experiment: ThesisExperiment) -> int:
    """Return the episodes from one kept score of a training to the next."""
    return experiment.episodes(1)


@cache
def measured() -> tuple[Training, ...]:
    """Return the trainings of the file, in the thesis's order, by seed and version."""
    by_name = {experiment.name: experiment for experiment in EXPERIMENTS}
    csv.field_size_limit(sys.maxsize)
    with MEASURED.open(newline="", encoding="utf-8") as file:
        return tuple(_training(by_name[row["experiment"]], row) for row in csv.DictReader(file))


def _training(experiment: ThesisExperiment, row: dict[str, str]) -> Training:
    figures = {name: float(row[name]) for name in FIGURES}
    points = zip(*(_numbers(row[f"at_{name}"]) for name in EVALUATED), strict=True)
    record: dict[str, Any] = {
        "seed": int(row["seed"]),
        "evaluations": [dict(zip(EVALUATED, point, strict=True)) for point in points],
    }
    for name in CURVES:
        kept = _numbers(row[name])
        steps = np.arange((len(kept) - 1) * STRIDE + 1)
        record[name] = np.interp(steps, steps[::STRIDE], kept).tolist()
    run = Run(experiment, row["version"], record, _numbers(row["scores"]))
    seed = int(row["flown_seed"]) if row["flown_seed"] else None
    return Training(run, every(experiment), figures, seed, tuple(row["moves"].split()))


def _numbers(text: str) -> NDArray[np.float64]:
    return np.array(text.split(), np.float64)


def replayed(training: Training) -> Iterator[World]:
    """Yield the world at the start and after each step of the greedy episode that was kept."""
    assert training.flown_seed is not None
    world = World(scenario(training.run.experiment.scenario))
    world.reset([training.flown_seed])
    yield world
    moves = [iter(each) for each in training.moves]
    for _ in rollout(world, lambda flying: [(uav, int(next(moves[uav[1]]))) for uav in flying]):
        yield world


def results_table() -> list[str]:
    """Return the rows of the table of end results in Markdown, a row for each experiment and seed."""
    rows = []
    for pair in pairs(measured()):
        experiment = pair[0].run.experiment
        group = experiment.group.replace("rewards-", "rewards ") + ", " if experiment.group != "obstacles" else ""
        cells = [f"{group}{experiment.title}", str(pair[0].seed)]
        cells.append(" / ".join(fixed(each.figures["training_score"], 0) for each in pair))
        for name in ("training_positive", "coverage", "reached", "crashed", "stuck"):
            cells.append(" / ".join(percent(each.figures[name]) for each in pair))
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def pairs(trainings: Sequence[Training]) -> list[tuple[Training, ...]]:
    """Return the trainings of each experiment and seed that have both versions: as it was, and mended."""
    places = dict.fromkeys((training.run.experiment.name, training.seed) for training in trainings)
    found = [tuple(t for t in trainings if (t.run.experiment.name, t.seed) == place) for place in places]
    return [pair for pair in found if tuple(training.run.version for training in pair) == VERSIONS]


def rows(folders: Sequence[Path]) -> Iterator[dict[str, Any]]:
    """Yield the rows of the file: those of the finished trainings of some folders."""
    for experiment in EXPERIMENTS:
        for folder in folders:
            for version in VERSIONS:
                own = folder / experiment.name / version
                run = read_run(experiment, version, own)
                if run is not None:
                    yield _row(run, own / WEIGHTS)


def _row(run: Run, weights: Path) -> dict[str, Any]:
    experiment, record = run.experiment, run.record
    options = f"--episodes {len(run.scores) // experiment.episodes(1)} --seed {record['seed']} --only {experiment.name}"
    row = {"experiment": experiment.name, "version": run.version, "seed": record["seed"]}
    row |= {"command": f"indoor-explorers thesis {options} --versions {run.version}", "commit": record["commit"][:7]}
    row |= {name: run.row()[name] for name in FIGURES}
    row["scores"] = " ".join(f"{score:.0f}" for score in run.scores[every(experiment) - 1 :: every(experiment)])
    for name in CURVES:
        row[name] = " ".join(f"{share:.3f}" for share in record[name][::STRIDE])
    for name in EVALUATED:
        row[f"at_{name}"] = " ".join(
            f"{value:.3g}" if name != "episodes" else str(int(value)) for value in run.greedy(name)
        )
    if experiment.group == "obstacles":
        row["flown_seed"], moves = _median_episode(experiment, weights)
        row["moves"] = " ".join(moves)
    return row


def _median_episode(experiment: ThesisExperiment, weights: Path) -> tuple[int, list[str]]:
    """Return the seed and the moves of the greedy episode of median coverage."""
    policy, found = make_policy("dddqn-thesis", weights=str(weights)), []
    for seed in FLOWN:
        world = World(scenario(experiment.scenario))
        world.reset([seed])
        flight = rollout(world, ask_pilots(policy, make_pilots(policy, world), world))
        by_uav = np.array([actions[0] for actions in flight]).T
        moves = ["".join(map(str, actions)).rstrip(str(int(Action.STAY))) for actions in by_uav.tolist()]
        found.append((float(world.team_coverage[0]), seed, moves))
    _, seed, moves = sorted(found)[len(found) // 2]
    return seed, moves


def main(folders: Sequence[str], out: Path = MEASURED) -> None:
    """Write the file."""
    with written_whole(out) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        table.writeheader()
        table.writerows(rows([Path(folder) for folder in folders]))


if __name__ == "__main__":
    main(sys.argv[1:])

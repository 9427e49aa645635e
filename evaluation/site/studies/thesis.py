"""The trainings of the thesis's experiments that THESIS.md shows, summarised: a row of ``thesis.csv`` for each.

Written manually from folders of ``indoor-explorers thesis``, of which it takes the trainings that are finished::

    indoor-explorers thesis --episodes 500 --out results/brief
    indoor-explorers thesis --episodes 500 --seed 2 --only 'rewards-*,obstacles-1' --out results/brief-2
    python -P -m indoor_explorers.evaluation.site.studies.thesis results/brief results/brief-2

A row has the command and the commit of its training, the figures of ``summary.csv``, the scores of the training
episodes (among obstacles every fifth), the coverage at every fourth step, and the greedy evaluations. Among obstacles
the last evaluation is flown again: the row has the moves of its episode of median coverage, how often two UAVs in
contact and apart made the same move, and the share of the UAV that saw most. Lists are separated by spaces.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Action, World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.drawing.formatting import THIN_SPACE, fixed, percent
from indoor_explorers.evaluation.studies.many_trainings import write_rows
from indoor_explorers.evaluation.studies.thesis.experiments import AS_WAS, EXPERIMENTS, MENDED, ThesisExperiment
from indoor_explorers.evaluation.studies.thesis.results import WEIGHTS, Run, read_run
from indoor_explorers.learners.sessions.seeds import evaluation_seeds

MEASURED = Path(__file__).parent / "thesis.csv"
VERSIONS = (AS_WAS, MENDED)
#: Steps between two values of a curve.
STRIDE = 4
#: What is counted in the episodes of the last greedy evaluation among obstacles.
COUNTED = ("linked", "alike_linked", "apart", "alike_apart", "most")
#: The mean score of the first tenth of a training and its best score; figures of its row of ``summary.csv``, of its
#: greedy evaluations, and its curves.
SCORES = ("first_score", "best_score")
FIGURES = ("training_score", "training_positive", "coverage", "t90", "reached", "crashed", "stuck")
EVALUATED = ("episodes", "coverage", "reached", "crashed", "stuck")
CURVES = ("training_coverage_by_step", "greedy_coverage_by_step")
COLUMNS = (
    *("experiment", "version", "seed", "command", "commit", *SCORES, *FIGURES, "scores", *CURVES),
    *(f"at_{name}" for name in EVALUATED),
    *(*COUNTED, "flown_seed", "moves"),
)


class MeasuredTraining(NamedTuple):
    """A training of the file."""

    run: Run
    """The training with the scores that were kept."""
    figures: dict[str, float]
    """Its figures in ``summary.csv``, and :data:`SCORES`."""
    counted: dict[str, float]
    """What was counted in greedy episodes: pairs of flying UAVs at a step that were linked, the share of these that
    made the same move, the same of pairs apart, and of the cells that the UAVs saw, the share of the one that saw most.
    """
    flown_seed: int | None
    """Seed of the greedy episode that was kept."""
    moves: tuple[str, ...]
    """The moves of each UAV in it, a digit each."""

    @property
    def seed(self) -> int:
        """The seed of the training."""
        return int(self.run.record["seed"])

    @property
    def every(self) -> int:
        """Episodes from one kept score to the next: as many as the training is longer than one in the empty room."""
        return self.run.experiment.episodes(1)


@cache
def measured() -> tuple[MeasuredTraining, ...]:
    """Return the trainings of the file, in the thesis's order, by seed and version."""
    by_name = {experiment.name: experiment for experiment in EXPERIMENTS}
    csv.field_size_limit(sys.maxsize)
    with MEASURED.open(newline="", encoding="utf-8") as file:
        return tuple(_training(by_name[row["experiment"]], row) for row in csv.DictReader(file))


def _training(experiment: ThesisExperiment, row: dict[str, str]) -> MeasuredTraining:
    figures = {name: float(row[name]) for name in (*SCORES, *FIGURES)}
    points = zip(*(numbers(row[f"at_{name}"]) for name in EVALUATED), strict=True)
    record: dict[str, Any] = {
        "seed": int(row["seed"]),
        "evaluations": [dict(zip(EVALUATED, point, strict=True)) for point in points],
    }
    for name in CURVES:
        kept = numbers(row[name])
        steps = np.arange((len(kept) - 1) * STRIDE + 1)
        record[name] = np.interp(steps, steps[::STRIDE], kept).tolist()
    run = Run(experiment, row["version"], record, numbers(row["scores"]))
    counted = {name: float(row[name]) for name in COUNTED if row[name]}
    seed = int(row["flown_seed"]) if row["flown_seed"] else None
    return MeasuredTraining(run, figures, counted, seed, tuple(row["moves"].split()))


def numbers(listed: str) -> NDArray[np.float64]:
    """Return the numbers of a cell."""
    return np.array(listed.split(), np.float64)


def replayed(training: MeasuredTraining) -> Iterator[World]:
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
    for pair in pairs():
        experiment = pair[0].run.experiment
        group = experiment.group.replace("rewards-", "rewards ") + ", " if experiment.group != "obstacles" else ""
        cells = [f"{group}{experiment.title}", str(pair[0].seed)]
        cells.append(" / ".join(fixed(each.figures["training_score"], 0).replace(THIN_SPACE, ",") for each in pair))
        for name in ("training_positive", "coverage", "reached", "crashed", "stuck"):
            cells.append(" / ".join(percent(each.figures[name]) for each in pair))
        rows.append(f"| {' | '.join(cells)} |")
    return rows


@cache
def pairs() -> tuple[tuple[MeasuredTraining, ...], ...]:
    """Return the trainings of each experiment and seed of which the file has both: as it was, and mended."""
    places = dict.fromkeys((training.run.experiment.name, training.seed) for training in measured())
    found = [tuple(t for t in measured() if (t.run.experiment.name, t.seed) == place) for place in places]
    return tuple(pair for pair in found if tuple(training.run.version for training in pair) == VERSIONS)


def rows(folders: Sequence[Path]) -> Iterator[dict[str, Any]]:
    """Yield the rows of the file: the finished trainings of some folders, the first of equal ones."""
    written = set()
    for experiment in EXPERIMENTS:
        for folder in folders:
            for version in VERSIONS:
                own = folder / experiment.name / version
                run = read_run(experiment, version, own)
                if run is not None and (place := (experiment, run.record["seed"], version)) not in written:
                    written.add(place)
                    yield _row(run, own / WEIGHTS)


def _row(run: Run, weights: Path) -> dict[str, Any]:
    experiment, record, every = run.experiment, run.record, run.experiment.episodes(1)
    options = f"--episodes {len(run.scores) // every} --seed {record['seed']} --only {experiment.name}"
    row = {"experiment": experiment.name, "version": run.version, "seed": record["seed"]}
    row |= {"command": f"indoor-explorers thesis {options} --versions {run.version}", "commit": record["commit"][:7]}
    first = run.scores[: max(1, len(run.scores) // 10)].mean()
    row |= dict(zip(SCORES, (round(float(first), 2), float(run.scores.max())), strict=True))
    row |= {name: run.row()[name] for name in FIGURES}
    row["scores"] = text(run.scores[every - 1 :: every], ".0f")
    row |= {name: text(record[name][::STRIDE], ".3f") for name in CURVES}
    row |= {f"at_{name}": text(run.greedy(name), ".4g") for name in EVALUATED}
    if experiment.group == "obstacles":
        row |= _greedy_episodes(run, weights)
    return row


def text(listed: Iterable[float], form: str) -> str:
    """Return a cell with numbers in a format."""
    return " ".join(f"{number:{form}}" for number in listed)


def _greedy_episodes(run: Run, weights: Path) -> dict[str, Any]:
    """Fly the last evaluation again; return what is counted, and the episode of median coverage."""
    policy, found, most = make_policy("dddqn-thesis", weights=str(weights)), [], []
    steps, alike = np.zeros(2, np.int64), np.zeros(2, np.int64)  # of pairs apart, and of those linked
    first = evaluation_seeds(run.record["seed"])
    for seed in range(first, first + run.record["config"]["evaluation_episodes"]):
        world = World(scenario(run.experiment.scenario))
        world.reset([seed])
        state, flown = world.state, []
        linked, flying = state.linked[0].copy(), world.flying[0].copy()
        for actions in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
            flown.append(actions[0])
            for one, other in combinations(np.flatnonzero(flying), 2):
                steps[int(linked[one, other])] += 1
                alike[int(linked[one, other])] += actions[0, one] == actions[0, other]
            linked, flying = state.linked[0].copy(), world.flying[0].copy()
        moves = ["".join(map(str, own)).rstrip(str(int(Action.STAY))) for own in np.array(flown).T.tolist()]
        found.append((float(world.team_coverage[0]), seed, " ".join(moves)))
        most.append(state.sensed_count[0].max() / state.sensed_count[0].sum())
    _, seed, moves_of_median = sorted(found)[len(found) // 2]
    apart, together = (
        round(float(share), 4) if count else ""
        for share, count in zip(alike / np.maximum(steps, 1), steps, strict=True)
    )
    counted = (int(steps[1]), together, int(steps[0]), apart, round(float(np.mean(most)), 4))
    return {**dict(zip(COUNTED, counted, strict=True)), "flown_seed": seed, "moves": moves_of_median}


def main(folders: Sequence[str], out: Path = MEASURED) -> None:
    """Write the file."""
    found = list(rows([Path(folder) for folder in folders]))
    if not found:
        raise SystemExit(f"no finished trainings in {folders}; expected folders of indoor-explorers thesis")
    write_rows(out, COLUMNS, found)


if __name__ == "__main__":
    main(sys.argv[1:])

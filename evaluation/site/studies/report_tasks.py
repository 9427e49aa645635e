"""Compare rules of reporting and the learned one on drawn tasks: other maps, teams, lidars, radios and deadlines each.

    python -P -m indoor_explorers.evaluation.site.studies.report_tasks 100

flies 100 tasks, drawn as those of the training of ``dddqn-reports`` but by other seeds, in two processes, and prints in
Markdown the mean coverage of the base, the share of tasks in which it knew 99 % at the deadline, and the learner's
points (:mod:`indoor_explorers.learners.reports.flights`) beyond each rule's, with intervals over tasks. A second number
is the first task; paths after it are folders of other trainings of the learner, which fly as well.
"""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env import Policy, make_policy
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.evaluation.drawing.formatting import percent, with_interval
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.statistics import bootstrap_mean
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.reports.flights import ENOUGH, STREAM, points_lost, task
from indoor_explorers.learners.reports.situation import LATE_COST, POINTS

#: Seed of the first task, beyond those of trainings with a seed below 89.
FIRST = 900_000_000
#: The explorer of all.
EXPLORER = "frontier-predictive"
LEARNED = "dddqn-reports"
#: Parameters of ``return-to-base``, by name.
RULES: dict[str, dict[str, Any]] = {
    "at the deadline": {"when": "deadline"},
    "`trips = 2`": {},
    "`trips = 1`": {"trips": 1.0},
    "`worth`": {"when": "worth"},
    "`worth`, no reserve": {"when": "worth", "reserve": 0.0},
    "`worth = 1`, no reserve": {"when": "worth", "worth": 1.0, "reserve": 0.0},
}


class Flown(NamedTuple):
    """A flight."""

    coverage: float
    """Mean coverage of the base over the budget."""
    last: float
    """Its coverage at the deadline."""

    @property
    def points(self) -> float:
        """The points that count, of which 100 are the most."""
        return POINTS * self.coverage - points_lost(self.last, LATE_COST)


def policies(trainings: Sequence[str] = ()) -> dict[str, Policy]:
    """Return the rules, the learner of other trainings' folders, and the learner that ships, by name."""
    rules = {name: make_policy("return-to-base", explorer=EXPLORER, **given) for name, given in RULES.items()}
    others = {path: make_policy(f"{LEARNED}:{path}", explorer=EXPLORER) for path in trainings}
    return rules | others | {LEARNED: make_policy(LEARNED, explorer=EXPLORER)}


def flown(seed: int, trainings: Sequence[str] = ()) -> dict[str, Flown]:
    """Return the flights of all policies over the task of a seed."""
    plan, settings = task(TrainingMaps(), np.random.default_rng([seed, STREAM]))
    scenario, where = on_files(("map",), None).with_settings(settings).for_evaluation(), Task("drawn", 0, seed)
    found = {}
    for name, policy in policies(trainings).items():
        (record,) = fly(policy, name, scenario, [where], bounds={where: 0}, floorplans={where: plan})
        found[name] = Flown(float(record.metrics["auc_base"] or 0.0), float(record.curve[-1]))
    return found


def table(flights: list[dict[str, Flown]]) -> str:
    """Return the table in Markdown."""
    lines = ["| flights home | base, mean coverage | 99 % at the deadline | points | of the learner beyond it |"]
    lines.append("|---|---|---|---|---|")
    for name in flights[0]:
        each = [flight[name] for flight in flights]
        beyond = [flight[LEARNED].points - one.points for flight, one in zip(flights, each, strict=True)]
        reached = percent(float(np.mean([one.last >= ENOUGH for one in each])))
        cells = [f"{np.mean([one.coverage for one in each]):.3f}", reached]
        cells.append(f"{np.mean([one.points for one in each]):.1f}")
        cells.append("" if name == LEARNED else with_interval(bootstrap_mean(beyond), 1))
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main(count: int, first: int = 0, trainings: Sequence[str] = ()) -> None:
    """Fly ``count`` tasks and print the table."""
    seeds = range(FIRST + first, FIRST + first + count)
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        sys.stdout.write(table(list(pool.imap(partial(flown, trainings=trainings), seeds))))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0, sys.argv[3:])

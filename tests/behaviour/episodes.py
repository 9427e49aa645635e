"""One episode of a policy, the command that shows it, and what the policy did wrong in it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from indoor_explorers.env import Scenario, make_policy, scenario
from indoor_explorers.env.conformance import FAILURE_MODES, fly_failure_mode
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.evaluation.harness.episodes.metrics import WASTED, tolerated_steps
from indoor_explorers.evaluation.harness.episodes.record import Outcome, Record
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.episodes.stalling import longest_run, to_and_fro
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from tests.behaviour.worlds import BUDGET, RADIOS, WORLDS, Settings

#: Makes the policy that loses UAV 0 of the one named.
LOST_UAV = "tests.behaviour.lost_uav"
#: Steps that any UAV may fly to and fro, also when it has nothing left to find.
MOST_DITHER = 6


@dataclass(frozen=True)
class Case:
    """One episode on a preset or a map file."""

    policy: str
    world: str
    source: str
    team: int
    settings: Settings
    seed: int
    resolution: float | None = None

    @classmethod
    def on(cls, world: str, folder: Path, policy: str, team: int, settings: Settings, seed: int) -> Case:
        """Return a case on one of :data:`WORLDS`, whose map files are in the folder."""
        source, own = WORLDS[world]
        path = str(folder / source) if source.endswith(".npy") else source
        return cls(policy, world, path, team, {**own, "budget": BUDGET, **settings}, seed)

    @property
    def title(self) -> str:
        """What it is, in short."""
        return f"{self.policy} on {self.world}, {self.team} UAVs"

    @property
    def of_a_file(self) -> bool:
        """Whether the map is a file's."""
        return "." in self.source

    @property
    def scenario(self) -> Scenario:
        """What is flown."""
        chosen = on_files((self.source,), self.resolution) if self.of_a_file else scenario(self.source)
        return chosen.for_evaluation().with_settings({"team": self.team, **self.settings})

    def command(self) -> str:
        """Return the command that shows it."""
        source = "--maps" if self.of_a_file else "--scenario"
        words = ["indoor-explorers", "watch", "--policy", self.policy, source, self.source, "--team", str(self.team)]
        words += ["--resolution", f"{self.resolution:g}"] if self.resolution else []
        changes = [f"{key}={_written(value)}" for key, value in self.settings.items()]
        return shlex.join([*words, "--seed", str(self.seed), "--set", *changes])

    def fly(self) -> Record:
        """Fly it."""
        task = self.scenario
        (record,) = fly(make_policy(self.policy), self.policy, task, [Task(task.name, 0, self.seed)])
        return record

    def problems(self) -> list[str]:
        """Fly it, and name what the policy did wrong."""
        return violations(self.fly())


@dataclass(frozen=True)
class FailureCase:
    """One failure mode that users report, flown with a radio."""

    policy: str
    mode: str
    radio: str
    seed: int

    @property
    def title(self) -> str:
        """What it is, in short."""
        return f"{self.policy} in {self.mode}, radio {self.radio}"

    def command(self) -> str:
        """Return the command that shows it."""
        words = ["--policies", self.policy, "--worlds", "", "--modes", self.mode, "--radios", self.radio]
        return shlex.join(["python", "-m", "tests.behaviour.soak", *words, "--seed", str(self.seed)])

    def problems(self) -> list[str]:
        """Fly it, and name what the policy did wrong: a violation of the contract, or what it did not finish."""
        (mode,) = (mode for mode in FAILURE_MODES if mode.name == self.mode)
        flight = fly_failure_mode(make_policy(self.policy), mode, radio=RADIOS[self.radio], seed=self.seed)
        found = [str(violation) for violation in flight.trace.violations.values()]
        known = f"unfinished: UAV {flight.agent} knew {int(100 * flight.share)} %"
        return found if flight.finished else [*found, known]


def violations(record: Record) -> list[str]:
    """Name what a policy must not do in an episode.

    It must not raise, leave cells unexplored, fly into a wall, or have a UAV that stands still or flies to and fro for
    longer than is excused.
    """
    if record.outcome is Outcome.FAILED:
        return [f"failed: {record.reason}"]
    found = []
    if record.outcome is not Outcome.COMPLETE:
        found.append(f"covered {record.curve[-1]:.1%} ({record.outcome})")
    crashes = int(record.metrics["collisions"] or 0) - record.policy.startswith(LOST_UAV)
    if crashes > 0:
        found.append(f"{crashes} collisions")
    return found + [
        f"{metric.replace('_', ' ')} {record.metrics[metric]:g}"
        for metric in WASTED
        if (record.metrics[metric] or 0) > tolerated_steps(metric, record.team)
    ]


def longest_dither(record: Record) -> int:
    """Return the most steps in a row that a UAV flew to and fro, whatever was left to find."""
    return longest_run(np.asarray(to_and_fro(record.cells)))


def _written(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)

"""Caveats of results: their suite, episodes that were flown again, maps and seeds that policies saw before."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cached_property
from typing import Any

from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.stored_names import MODELS, refusal
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.policy_lists import PolicyLists
from indoor_explorers.evaluation.harness.results.seen_maps import seen_maps_line
from indoor_explorers.evaluation.harness.results.seen_seeds import seen_seeds_line
from indoor_explorers.evaluation.harness.results.suite_runs import SuiteRun, suite_run_of

#: The attempt that counts for an episode that was flown again.
WHICH_COUNTS = "the first attempt counts where the policy failed, the last where the machine did"


class ResultNotes(PolicyLists):
    """Notes on results: lines of each kind, mostly one or none."""

    scenarios: dict[str, dict[str, Any]]
    """Settings of each scenario by name, in table order."""
    records: list[Record]
    retries: Mapping[tuple[str, Task], int]
    """How often episodes were flown again after a failure, of those that were."""
    plugins: frozenset[str]
    """What the user named of that which the results name from outside this package."""

    @property
    def plugin_notes(self) -> list[str]:
        """Which scenarios cannot be simulated again, as the user did not name their models: a line for each."""
        found = {name: refusal(settings, self.plugins, MODELS) for name, settings in self.scenarios.items()}
        return [f"no replays of scenario {name!r}: {why}" for name, why in found.items() if why]

    @property
    def retry_notes(self) -> list[str]:
        """How many episodes of which policies were flown again after a failure: a line, or nothing."""
        counts = Counter(policy for policy, _ in self.retries)
        listed = ", ".join(f"{count} of {policy}" for policy, count in counts.items())
        return [f"episodes flown again after a failure: {listed}; {WHICH_COUNTS}"] if counts else []

    @property
    def seed_notes(self) -> list[str]:
        """Which policies were trained, validated or chosen on some of the seeds: a line, or nothing."""
        line = seen_seeds_line(self.policies, {record.task.seed for record in self.records})
        return [line] if line else []

    @cached_property
    def suite_run(self) -> SuiteRun | None:
        """The part of a suite that the results are about; None where they are not about one alone."""
        flown = {name: [record for record in self.records if record.policy == name] for name in self.policies}
        return suite_run_of(self.scenarios, flown)

    @property
    def suite_notes(self) -> list[str]:
        """Which part of which suite was flown, and how much of it: a line, or nothing."""
        return [": ".join(self.suite_run.phrases)] if self.suite_run else []

    @property
    def map_notes(self) -> list[str]:
        """Which policies were trained, validated or tuned on some of the maps: a line, or nothing."""
        line = seen_maps_line(self.policies, {record.floorplan.digest: record.floorplan for record in self.records})
        return [line] if line else []

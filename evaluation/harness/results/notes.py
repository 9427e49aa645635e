"""Lists of policies by their facts, and notes on results: suite, repeated episodes, maps and seeds seen before."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any

from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.layouts import PREFIX
from indoor_explorers.env.scenarios.seed_sets import SeedUse, fresh_test_set
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.stored_names import MODELS, refusal
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.suite_runs import SuiteRun, suite_run_of

#: How the classes of this package's own policies begin.
OURS = f"{__name__.partition('.')[0]}."
#: The attempt that counts for an episode that was flown again.
WHICH_COUNTS = "the first attempt counts where the policy failed, the last where the machine did"
#: Facts of a run about its machine.
MACHINE = ("system", "processor", "cores")
#: Maps that a line names.
MOST_NAMED = 3
#: The participle for each use of seeds or maps, before "on seeds 1 to 9".
USED = {
    SeedUse.TRAINING: "trained",
    SeedUse.VALIDATION: "validated",
    SeedUse.TRIAL: "tried out",
    SeedUse.TEST: "published before",
    SeedUse.TUNING: "developed",
}


class ResultNotes:
    """Lists policies by their facts, in table order, and notes on results, each a list of lines, often empty."""

    policies: dict[str, dict[str, Any]]
    scenarios: dict[str, dict[str, Any]]
    runs: list[dict[str, Any]]
    records: list[Record]
    notes: tuple[str, ...]
    retries: Mapping[tuple[str, Task], int]
    plugins: frozenset[str]

    def _with(self, fact: str) -> list[str]:
        return [name for name, about in self.policies.items() if about.get(fact)]

    @property
    def privileged_policies(self) -> list[str]:
        """The policies that are given the true map and are not ranked."""
        return self._with("privileged")

    @property
    def generator_policies(self) -> list[str]:
        """The policies that read the settings of the maps' generator."""
        return self._with("uses_generator")

    @property
    def batched_policies(self) -> list[str]:
        """The policies that decide for many UAVs at once: their decision times are shares of a batch's."""
        return self._with("batched")

    @property
    def failed_checks(self) -> dict[str, str]:
        """The check for hidden knowledge that a policy failed and how to fix it, by the policy's name."""
        return {name: self.policies[name]["failed_check"] for name in self._with("failed_check")}

    @property
    def aims(self) -> dict[str, list[str]]:
        """The policies by the coverage that they plan for; "not stated" where they do not say."""
        found: dict[str, list[str]] = {}
        for name, about in self.policies.items():
            found.setdefault(about.get("plans_for", "not stated"), []).append(name)
        return found

    @property
    def policies_from_outside(self) -> list[str]:
        """The policies from outside this package."""
        return [name for name, about in self.policies.items() if not str(about.get("class", OURS)).startswith(OURS)]

    @property
    def policies_of_unknown_code(self) -> list[str]:
        """The policies from outside this package without hashes of their sources."""
        return [name for name in self.policies_from_outside if not self.policies[name].get("sources")]

    @property
    def exposed_policies(self) -> list[str]:
        """The policies from outside this package that flew in the process that had the true map.

        Stores from before policies could be isolated lack this fact.
        """
        return [name for name in self.policies_from_outside if self.policies[name].get("isolated") is False]

    @property
    def warnings(self) -> list[str]:
        """The notes on the stores, and a line for each fact that differs between the runs and can change results.

        Such facts are commits, versions and machines.
        """
        lines = [*self.notes, *self.retry_notes]
        for key in dict.fromkeys(key for run in self.runs for key in run if _can_change_results(key)):
            values = dict.fromkeys(str(run.get(key, "not recorded")) for run in self.runs)
            if len(values) > 1:
                effect = "; latencies do not compare" if key in MACHINE else ""
                lines.append(f"runs differ in {key}: {', '.join(values)}{effect}")
        return lines

    @property
    def plugin_notes(self) -> list[str]:
        """A line for each scenario that cannot be simulated again, as the user did not name its models."""
        found = {name: refusal(settings, self.plugins, MODELS) for name, settings in self.scenarios.items()}
        return [f"no replays of scenario {name!r}: {why}" for name, why in found.items() if why]

    @property
    def retry_notes(self) -> list[str]:
        """How many episodes of which policies were flown again after a failure."""
        counts = Counter(policy for policy, _ in self.retries)
        listed = ", ".join(f"{count} of {policy}" for policy, count in counts.items())
        return [f"episodes flown again after a failure: {listed}; {WHICH_COUNTS}"] if counts else []

    @cached_property
    def suite_run(self) -> SuiteRun | None:
        """The part of a suite that the results are about; None where they are not about one alone."""
        flown = {name: [record for record in self.records if record.policy == name] for name in self.policies}
        return suite_run_of(self.scenarios, flown)

    @property
    def suite_notes(self) -> list[str]:
        """Which part of which suite was flown, and how much of it."""
        return [": ".join(self.suite_run.phrases)] if self.suite_run else []

    @property
    def seed_notes(self) -> list[str]:
        """Which policies were trained, validated or chosen on some of the seeds."""
        flown = {record.task.seed for record in self.records}
        listed = self._listed(lambda facts: _seen_seeds(facts, flown))
        fresh = f"for unseen seeds: --seed {fresh_test_set().first}"
        return [f"seeds seen before ({listed}): such figures may be optimistic; {fresh}"] if listed else []

    @property
    def map_notes(self) -> list[str]:
        """Which policies were trained, validated or tuned on some of the maps."""
        flown = {record.floorplan.digest: record.floorplan for record in self.records}
        listed = self._listed(lambda facts: _seen_maps(facts, flown))
        return [f"maps seen before ({listed}): such figures may be optimistic"] if listed else []

    def _listed(self, seen: Callable[[Mapping[str, Any]], Iterable[str]]) -> str:
        """Return the phrases about the facts of policies, each with the names of the policies that it holds for."""
        found: dict[str, list[str]] = {}
        for name, facts in self.policies.items():
            for phrase in seen(facts):
                found.setdefault(phrase, []).append(name)
        return "; ".join(f"{', '.join(names)}: {phrase}" for phrase, names in found.items())


def _can_change_results(key: str) -> bool:
    return key in (*MACHINE, "commit", "python") or key.endswith(" version")


def _seen_seeds(facts: Mapping[str, Any], flown: set[int]) -> Iterator[str]:
    """Say which of the seeds flown a policy saw, and for what use."""
    for use, ranges in facts.get("seen_seeds", {}).items():
        seen = {seed for first, last in ranges for seed in flown if first <= seed <= last}
        if seen:
            span = f"seeds {min(seen)} to {max(seen)}" if len(seen) > 1 else f"seed {min(seen)}"
            yield f"{USED[SeedUse(use)]} on {span}"


def _seen_maps(facts: Mapping[str, Any], flown: Mapping[str, Floorplan]) -> Iterator[str]:
    """Say which of the maps flown (by digest) a policy saw, or their layouts, each for its first use alone."""
    left = dict(flown)
    for use, digests in facts.get("seen_maps", {}).items():
        known = set(digests)
        of_layouts = any(digest.startswith(PREFIX) for digest in known)
        found = [key for key, plan in left.items() if key in known or (of_layouts and plan.layout in known)]
        names = sorted(left.pop(digest).name for digest in found)
        if names:
            listed = ", ".join(names[:MOST_NAMED]) + (", ..." if len(names) > MOST_NAMED else "")
            yield f"{USED[SeedUse(use)]} on {len(names)} of {len(flown)}, {listed}"

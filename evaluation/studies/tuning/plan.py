"""The plan of a search: what is tuned, on which episodes, and on which fresh ones the gain is flown."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from indoor_explorers.env import InputError
from indoor_explorers.env.files import write_whole
from indoor_explorers.env.policies.registry import policy_class
from indoor_explorers.env.policies.renamed import renamed_parameters
from indoor_explorers.env.scenarios.seed_sets import SeedUse, seed_set
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES, Measure
from indoor_explorers.evaluation.harness.experiment.experiment import LONGEST_NAME, Experiment, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.experiment.selection import chosen_policies
from indoor_explorers.evaluation.harness.results.coverage_threshold import applies_to
from indoor_explorers.evaluation.harness.results.policy_version import differing_fields
from indoor_explorers.evaluation.studies.tuning.request import TuneRequest
from indoor_explorers.evaluation.studies.tuning.space import SearchSpace

#: Trials, tuning seeds and fresh seeds where none are asked for.
TRIALS, EPISODES, FRESH = 40, 32, 100
#: The sets of seeds of generated maps, and of the starts on map files outside of suites.
TUNING_SEEDS, FRESH_SEEDS = seed_set("tune"), seed_set("tune-fresh")
#: The file that says what a folder's search is.
RECORD = "tune.json"
#: Ends the name of the tuned policy.
SUFFIX = "-tuned"
#: The part of a suite whose map files are fresh, by the one that is tuned on.
OTHER_PART = {"validation": "train", "train": "validation"}
#: The options that make the tasks, as those of a comparison.
OF_TASKS = ("scenario", "suite", "part", "data", "team", "settings", "episodes")


@dataclass(frozen=True)
class Search:
    """What is searched for, and how long."""

    space: SearchSpace
    tuning: Experiment
    """The default policy on the tuning episodes."""
    fresh: Experiment
    """The same on fresh ones."""
    request: TuneRequest

    @classmethod
    def of(cls, request: TuneRequest) -> Search:
        """Plan what is asked for.

        Raises:
            InputError: something does not exist or fit together, or the metric cannot be measured.

        """
        if request.trials is not None and request.hours is not None:
            raise InputError("expected --trials or --hours, got both; leave one of them out")
        if request.scenario is None and request.suite is None:
            raise InputError("expected a scenario to tune for, got none; name one with --scenario, or a --suite")
        space = SearchSpace.of(_choice(request.policy), request.ranges)
        tuning = _tuning(request, space.choice)
        for scenario in tuning.scenarios:
            if not applies_to(scenario.goal, request.metric):
                raise InputError(
                    f"scenario {scenario.name!r} ends at {100 * scenario.goal:g} % coverage, where {request.metric} "
                    "cannot be measured; ask for --metric t90 or auc, or set a higher goal with --set goal=0.99"
                )
        return cls(space, tuning, _fresh(request, tuning), request)

    @property
    def measure(self) -> Measure:
        """What is tuned for."""
        return MEASURES[self.request.metric]

    @property
    def trials(self) -> int | None:
        """Number of trials besides the default; None where time limits them."""
        return None if self.request.hours is not None else self.request.trials or TRIALS

    @property
    def generated(self) -> bool:
        """Whether all maps are drawn from seeds."""
        return all(scenario.map.generated for scenario in self.tuning.scenarios)

    @cached_property
    def tasks(self) -> list[Task]:
        """The tuning episodes in the order of their flights: shuffled once where there are several maps or scenarios.

        So the first ones of a trial are a sample of all.
        """
        tasks = self.tuning.tasks()
        if self.generated and len(self.tuning.scenarios) == 1:
            return tasks
        return [tasks[k] for k in np.random.default_rng(0).permutation(len(tasks))]

    def tuned(self, parameters: Mapping[str, Any]) -> PolicyChoice:
        """Return the policy with the parameters found, and with the seeds and maps that they were found on."""
        name = self.space.choice.use[: LONGEST_NAME - len(SUFFIX)] + SUFFIX
        used = {SeedUse.TUNING: self.tuning, SeedUse.VALIDATION: self.fresh}
        seen: dict[str, Any] = {
            "seen_seeds": {use: [(each.seed, each.seed + each.episodes - 1)] for use, each in used.items()}
        }
        if not self.generated:
            seen = {"seen_maps": {use: _digests(each) for use, each in used.items()}}
        return self.space.with_parameters(name, parameters).model_copy(update=seen)

    def claim(self, out: Path) -> None:
        """Note in a folder that it is this search's.

        Raises:
            InputError: it is that of another one.

        """
        path = out / RECORD
        ours = json.loads(json.dumps(self._record()))
        if not path.exists():
            out.mkdir(parents=True, exist_ok=True)
            write_whole(path, json.dumps(ours, indent=1) + "\n")
            return
        try:
            theirs = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise InputError(f"{path}: expected the record of a search, got a damaged one; choose another --out") from (
                error
            )
        if ours != theirs:
            differing = differing_fields(theirs, ours)
            raise InputError(f"{out}: holds another search, with other {differing}; choose another --out")

    def _record(self) -> dict[str, Any]:
        """Return all that makes the search what it is; the number of workers is not part of it."""
        space, request = self.space, self.request
        return {
            "policy": {"use": space.choice.use, "parameters": dict(space.choice.parameters)},
            "ranges": {name: str(each) for name, each in space.ranges.items()},
            **{name: getattr(request, name) for name in ("metric", "hours", "seed", "suite", "part")},
            "trials": self.trials,
            "tuning": self.tuning.model_dump(mode="json", exclude={"policies", "margin"}),
            "fresh": self.fresh.model_dump(mode="json", exclude={"policies", "margin", "scenarios"}),
        }


def _choice(typed: str) -> PolicyChoice:
    """Return the policy that was typed, with the present names of its parameters."""
    (entry,) = chosen_policies([typed], None)
    choice = validated(PolicyChoice, entry if isinstance(entry, dict) else {"use": entry}, "policy")
    return choice.by_present_names({"renamed": renamed_parameters(policy_class(choice.use))})


def _tuning(request: TuneRequest, choice: PolicyChoice) -> Experiment:
    given = {name: getattr(request, name) for name in OF_TASKS if name in request.model_fields_set}
    if request.suite is not None:
        given["part"] = request.part
    else:
        given |= {"episodes": request.episodes or EPISODES, "seed": TUNING_SEEDS.first}
    return plan(ComparisonRequest.of(policies=[choice.model_dump(exclude_none=True)], **given))


def _fresh(request: TuneRequest, tuning: Experiment) -> Experiment:
    """Return the experiment on fresh seeds, or on the other part of a suite of map files."""
    if request.suite is not None and not all(scenario.map.generated for scenario in tuning.scenarios):
        given: dict[str, Any] = {"part": OTHER_PART[request.part], "episodes": request.fresh_episodes}
        return _tuning(request.model_copy(update=given), tuning.policies[0])
    return tuning.model_copy(update={"episodes": request.fresh_episodes or FRESH, "seed": FRESH_SEEDS.first})


def _digests(experiment: Experiment) -> list[str]:
    """Return the digests of all map files, each once."""
    found = (
        scenario.map.floorplan(index, 0).digest
        for scenario in experiment.scenarios
        for index in range(scenario.map.count)
    )
    return list(dict.fromkeys(found))

"""An experiment: policies x scenarios x maps x seeds, all policies on the same maps, spawns and seeds."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from indoor_explorers.env import InputError, Policy, Scenario, make_policy
from indoor_explorers.env.policies.renamed import with_present_names
from indoor_explorers.env.scenarios.seed_sets import SeedUse
from indoor_explorers.env.scenarios.validation import validated

#: By which share a mean time may exceed another for the two to count as equally good, where nothing else is declared.
MARGIN = 0.05


class Task(NamedTuple):
    """One episode to be flown by every policy."""

    scenario: str
    """Name of the scenario."""
    map_index: int
    """Which of the scenario's map files; 0 for generators."""
    seed: int
    """Seed of the generated map, the spawns, the order of moves and the pilots' random numbers."""


def episode_name(policy: str, task: Task) -> str:
    """Return what messages call the episode in which a policy flew a task."""
    return f"{policy} on {task.scenario}, map {task.map_index}, seed {task.seed}"


#: Characters of a policy's name in results.
LONGEST_NAME = 80


class PolicyChoice(BaseModel):
    """A policy by registry name, ``NAME:PATH`` or ``module:Class``, its parameters, and its name in results."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    use: str = Field(min_length=1)
    """Registry name, ``NAME:PATH`` or ``module:Class``."""
    name: str = Field("", max_length=LONGEST_NAME)
    """Name in tables and figures; by default the registry name, with a long path in it shortened."""
    parameters: dict[str, Any] = {}
    """Arguments of the policy's constructor."""
    seen_seeds: dict[SeedUse, list[tuple[int, int]]] | None = None
    """First and last seed of each range that the parameters were chosen on, by use such as "tuning"."""
    seen_maps: dict[SeedUse, list[str]] | None = None
    """The maps that they were chosen on, see :meth:`~indoor_explorers.env.policies.policy.Policy.seen_maps`."""

    @model_validator(mode="before")
    @classmethod
    def _from_name(cls, data: Any) -> Any:
        data = {"use": data} if isinstance(data, str) else data
        return data | {"name": data.get("name") or _brief(data.get("use", ""))} if isinstance(data, dict) else data

    def make(self) -> Policy:
        """Make the policy."""
        return make_policy(self.use, **self.parameters)

    def by_present_names(self, facts: Mapping[str, Any]) -> PolicyChoice:
        """Return the choice with present names of parameters, by the policy's facts: of old ones is warned but once."""
        given = with_present_names(self.parameters, facts.get("renamed", {}), self.name)
        return self.model_copy(update={"parameters": given})


def _brief(use: Any) -> Any:
    """Return a name with the middle of a long path left out."""
    if not isinstance(use, str) or len(use) <= LONGEST_NAME:
        return use
    head = use.partition(":")[0][:20]
    return f"{head}:…{use[len(head) + 2 - LONGEST_NAME :]}"


class Job(NamedTuple):
    """A batch of episodes of one policy on one scenario."""

    policy: PolicyChoice
    scenario: Scenario
    tasks: tuple[Task, ...]
    bounds: Mapping[Task, int] = {}
    """Lower bounds of the tasks whose bounds and maps the driver already has; workers send neither again."""
    isolated: bool = False
    """Whether the policy decides in a process of its own, which never has the world."""
    privileged: bool = False
    """Whether an isolated policy is given the true map, as its facts say."""


class Experiment(BaseModel):
    """A complete description of a comparison."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    policies: tuple[PolicyChoice, ...] = Field(min_length=1)
    """The policies compared, in the order of tables."""
    scenarios: tuple[Scenario, ...] = Field(min_length=1)
    """The scenarios, with all settings applied."""
    episodes: int = Field(30, ge=1, le=1_000_000)
    """Seeds flown on each map."""
    seed: int = Field(0, ge=0, lt=2**62)
    """First seed; episode k has seed + k."""
    margin: float = Field(MARGIN, ge=0, lt=1)
    """By which share a mean time may exceed another for the two to count as equally good; 0 for no such statement."""

    @field_validator("policies", "scenarios")
    @classmethod
    def _names_differ(cls, entries: tuple[Any, ...]) -> tuple[Any, ...]:
        names = [entry.name for entry in entries]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"the name {twice[0]!r} appears twice; give each its own name")
        return entries

    def tasks(self) -> list[Task]:
        """List the episodes that every policy flies."""
        return [
            Task(scenario.name, index, self.seed + k)
            for scenario in self.scenarios
            for index in range(scenario.map.count)
            for k in range(self.episodes)
        ]

    def scenario(self, name: str) -> Scenario:
        """Return the scenario of that name."""
        return next(scenario for scenario in self.scenarios if scenario.name == name)

    def to_toml(self) -> str:
        """Return the experiment as TOML that can be read back, with every setting of every scenario.

        Paths of map files are written as absolute ones.
        """
        data = self.model_dump(mode="json", exclude_none=True)
        for scenario in data["scenarios"]:
            if "paths" in scenario["map"]:
                scenario["map"]["paths"] = [str(Path(path).resolve()) for path in scenario["map"]["paths"]]
        return tomli_w.dumps(data)


def declared_margin(text: str) -> float:
    """Return the margin of an experiment in TOML, the default where it has none."""
    margin = tomllib.loads(text).get("margin", MARGIN)
    return float(margin) if isinstance(margin, (int, float)) and 0 <= margin < 1 else MARGIN


def merged_experiments(texts: Sequence[str]) -> str:
    """Return one experiment in TOML for all runs of a store, given that of each run in TOML, oldest first.

    It has the policies of all runs and the largest number of episodes; the rest is that of the latest run. Empty
    without a run.
    """
    if not texts:
        return ""
    runs = [tomllib.loads(text) for text in texts]
    policies = {policy["name"]: policy for run in runs for policy in run["policies"]}
    whole = {"policies": list(policies.values()), "episodes": max(run["episodes"] for run in runs)}
    return tomli_w.dumps(runs[-1] | whole)


def build_experiment(
    policies: Sequence[Any],
    scenarios: Sequence[Scenario],
    *,
    episodes: int | None = None,
    seed: int | None = None,
    margin: float | None = None,
    settings: Mapping[str, Any],
) -> Experiment:
    """Build an experiment from scenarios, with ``settings`` applied to each of them, see :func:`with_sweeps`."""
    flown = tuple(variant for scenario in scenarios for variant in with_sweeps(scenario, settings))
    numbers = {"episodes": episodes, "seed": seed, "margin": margin}
    given = {name: value for name, value in numbers.items() if value is not None}
    return validated(Experiment, {"policies": tuple(policies), "scenarios": flown, **given}, "experiment")


def with_sweeps(scenario: Scenario, settings: Mapping[str, Any]) -> list[Scenario]:
    """Return a scenario with settings, one for each combination of the values of those that are lists.

    A list is the value itself where the setting takes a list, such as ``spawn``. Names tell the values that were swept:
    ``thesis-team-2 radio.range=3``.

    Raises:
        InputError: a setting does not exist, or a value does not fit.

    """
    single = {key: value for key, value in settings.items() if not isinstance(value, list)}
    lists = {key: value for key, value in settings.items() if key not in single}
    swept = {key: values for key, values in lists.items() if values and not _fits(scenario, {**single, key: values})}
    variants = []
    for values in product(*swept.values()):
        chosen = dict(zip(swept, values, strict=True))
        suffix = "".join(f" {key}={value}" for key, value in chosen.items())
        named = {"name": f"{settings.get('name', scenario.name)}{suffix}"} if chosen else {}
        variants.append(scenario.with_settings({**settings, **chosen, **named}))
    return variants


def _fits(scenario: Scenario, settings: Mapping[str, Any]) -> bool:
    try:
        scenario.with_settings(settings)
    except InputError:
        return False
    return True

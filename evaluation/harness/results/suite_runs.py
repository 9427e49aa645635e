"""Recognises results of a suite by settings, maps and seeds, whatever command flew them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from pydantic import ValidationError

from indoor_explorers.env import Scenario
from indoor_explorers.env.maps.base import BaseMaps
from indoor_explorers.env.scenarios.suites.catalogue import all_suites
from indoor_explorers.env.scenarios.suites.suite import Part, Suite
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.resimulate import recorded_scenario
from indoor_explorers.evaluation.harness.episodes.stored_names import MODELS, outside_names


class SuiteTask(NamedTuple):
    """A task of a suite, identified by its map and seed rather than by names and paths of files."""

    scenario: str
    """The suite's name of the scenario."""
    digest: str
    """Digest of the map; empty where the seed makes it."""
    levels: int
    """Levels that the map was flown with; 0 where the seed makes it."""
    seed: int


@dataclass(frozen=True)
class SuiteRun:
    """The part of a suite that results are about, and how much of it every policy has flown."""

    suite: Suite
    part: Part
    flown: frozenset[SuiteTask]
    """The tasks that every policy flew."""

    @property
    def total(self) -> int:
        """Number of tasks of the whole part."""
        return self.suite.task_count(self.part)

    @property
    def complete(self) -> bool:
        """Whether every policy flew all of them."""
        return len(self.flown) == self.total

    @property
    def phrases(self) -> list[str]:
        """What results are about in two short phrases: suite with version and part, and how much of it."""
        return [f"suite {self.suite.title}, {self.part} part", "complete" if self.complete else self._subset()]

    def _subset(self) -> str:
        scenarios = len({task.scenario for task in self.flown})
        return (
            f"a subset of it: {len(self.flown)} of {self.total} tasks, in {scenarios} of "
            f"{len(self.suite.scenarios())} scenarios"
        )


def suite_run_of(
    scenarios: Mapping[str, Mapping[str, Any]], records: Mapping[str, Iterable[Record]]
) -> SuiteRun | None:
    """Return which part of which suite results are about; None if any task is not of that part.

    Args:
        scenarios: stored settings by the name of the scenario.
        records: the episodes by policy.

    """
    for suite in all_suites():
        named = suite.scenarios()
        names = {name: _name_in(suite, named, settings) for name, settings in scenarios.items()}
        if names and all(names.values()):
            found = [{_task(suite, names, record) for record in mine} for mine in records.values()]
            for part in Part:
                if found and all(found) and _are_of(suite, part, set().union(*found)):
                    return SuiteRun(suite, part, frozenset(set.intersection(*found)))
    return None


def _name_in(suite: Suite, named: Sequence[Scenario], stored: Mapping[str, Any]) -> str:
    """Return the name of a scenario among those of a suite, empty where it is none of them."""
    if outside_names(stored, MODELS):
        return ""
    possible = [each for each in named if not suite.generated or _is_generator(each.map, stored["map"])]
    settings = _settings(recorded_scenario(stored)) if possible else {}
    return next((each.name for each in possible if _settings(each) == settings), "")


def _is_generator(maps: BaseMaps, stored: Mapping[str, Any]) -> bool:
    """Return whether stored settings are those of a generator; settings that older results lack are at defaults."""
    try:
        return type(maps).model_validate(stored) == maps
    except ValidationError:
        return False


def _settings(scenario: Scenario) -> dict[str, Any]:
    """Return the settings of a task without its maps, and without the radio for one UAV."""
    return scenario.model_dump(exclude={"name", "map", *(["radio"] if scenario.team == 1 else [])})


def _task(suite: Suite, names: Mapping[str, str], record: Record) -> SuiteTask:
    flown = ("", 0) if suite.generated else (record.floorplan.digest, record.floorplan.level_count)
    return SuiteTask(names[record.task.scenario], *flown, record.task.seed)


def _are_of(suite: Suite, part: Part, tasks: set[SuiteTask]) -> bool:
    levels = suite.levels.get(part, 1)
    maps = {("", 0)} if suite.generated else {(each.digest, levels) for _, each in suite.maps(part)}
    return all(task.seed in suite.seeds(part) and (task.digest, task.levels) in maps for task in tasks)

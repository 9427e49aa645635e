"""Whether stored episodes are what the world makes of their maps, seeds and actions, and the policy of its views."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from indoor_explorers.env import Scenario
from indoor_explorers.env.maps.base import BaseMaps
from indoor_explorers.env.maps.sources import map_class
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.episodes.mismatch import mismatch
from indoor_explorers.evaluation.episodes.record import Record
from indoor_explorers.evaluation.episodes.resimulate import recorded_scenario
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.experiment.experiment import PolicyChoice
from indoor_explorers.evaluation.results.results import Results


def mismatches(results: Results) -> Iterator[str]:
    """Yield a line for each episode that is not what its map, seed and actions give."""
    scenarios = {name: recorded_scenario(settings) for name, settings in results.scenarios.items()}
    generators = {name: _generator(settings["map"]) for name, settings in results.scenarios.items()}
    for record in results.records:
        scenario, maps = scenarios[record.task.scenario], generators[record.task.scenario]
        wrong = maps is not None and _is_another_map(record, scenario.model_copy(update={"map": maps}))
        fault = "not the map that the generator makes of its seed" if wrong else mismatch(record, scenario)
        if fault:
            yield f"{_named(record)}: {fault}"


def flown_differently(results: Results, count: int) -> Iterator[str]:
    """Let every policy fly ``count`` of its episodes again, spread over its tasks; yield a line for each that differs.

    The policies are made as the stored experiment says, so plug-ins have to be installed.
    """
    choices = _choices(results.experiments)
    for (name, policy), records in results.groups.items():
        scenario = recorded_scenario(results.scenarios[name])
        made = choices[policy].make()
        for place in np.unique(np.linspace(0, len(records) - 1, count).round().astype(int)):
            record = records[place]
            floorplans = {record.task: record.floorplan}
            (again,) = fly(made, policy, scenario, [record.task], bounds={record.task: 1}, floorplans=floorplans)
            if not again.flew_like(record):
                yield f"{_named(record)}: flown again, it took other actions"


def _choices(experiments: Sequence[str]) -> dict[str, PolicyChoice]:
    entries = [entry for text in experiments for entry in tomllib.loads(text)["policies"]]
    return {entry["name"]: PolicyChoice.model_validate(entry) for entry in entries}


def _generator(stored: Mapping[str, Any]) -> BaseMaps | None:
    """Return the generator of stored settings; None where maps are files."""
    kind = map_class(stored["source"])
    if kind is None:
        return None
    maps = kind.model_validate({key: value for key, value in stored.items() if key in kind.model_fields})
    return maps if maps.generated else None


def _is_another_map(record: Record, scenario: Scenario) -> bool:
    """Tell whether a map is not the one that the scenario's generator makes of the seed."""
    return draw_floorplan(scenario, record.task.seed, record.task.map_index).digest != record.floorplan.digest


def _named(record: Record) -> str:
    task = record.task
    return f"{record.policy} on {task.scenario}, map {task.map_index}, seed {task.seed}"

"""The command that reproduces one row of a results table."""

from __future__ import annotations

import re
import shlex
import tomllib
from collections.abc import Mapping
from typing import Any

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.results.results import Results

#: Names that need no double quotes on the command line.
PLAIN = re.compile(r"[\w.:][\w.:-]*")
#: Folder that the commands write to.
OUT = "again"


def experiment_files(results: Results) -> dict[str, str]:
    """Return the experiment files that the commands read, as TOML by name: one for each store."""
    if len(results.experiments) == 1:
        return {"experiment.toml": results.experiments[0]}
    return {f"experiment-{number}.toml": text for number, text in enumerate(results.experiments, 1)}


def row_command(results: Results, scenario: str, policy: str) -> str:
    """Return the shell command that flies the episodes of one row again; empty if nothing is recorded about them.

    A policy with default parameters on an unchanged preset is given by name; others are entries of one of
    :func:`experiment_files`. A ratio to the policy that knows the map also needs that policy's row.
    """
    records = results.groups.get((scenario, policy), [])
    for file, text in experiment_files(results).items():
        experiment = tomllib.loads(text)
        choice, task = _entry(experiment["policies"], policy), _entry(experiment["scenarios"], scenario)
        if records and choice is not None and task is not None:
            named = _is_default(choice) and _is_preset(task)
            source = _seeds(records) if named else ["--experiment", file, *_fewer(experiment, records)]
            names = ["--policies", quoted(policy), "--scenario", quoted(scenario)]
            return shlex.join(["indoor-explorers", "compare", *names, *source, "--out", OUT])
    return ""


def _entry(entries: list[dict[str, Any]], name: str) -> dict[str, Any] | None:
    return next((entry for entry in entries if entry["name"] == name), None)


def _is_default(choice: Mapping[str, Any]) -> bool:
    return choice["name"] == choice["use"] and not choice.get("parameters")


def _is_preset(task: Mapping[str, Any]) -> bool:
    """Return whether the task is how comparisons fly the preset of its name."""
    preset = PRESETS.get(task["name"])
    return preset is not None and preset.for_evaluation().model_dump(mode="json", exclude_none=True) == task


def _seeds(records: list[Record]) -> list[str]:
    return ["--episodes", str(_episodes(records)), "--seed", str(min(record.task.seed for record in records))]


def _fewer(experiment: Mapping[str, Any], records: list[Record]) -> list[str]:
    """Return ``--episodes`` with the row's number of episodes if the experiment has another number."""
    count = _episodes(records)
    return [] if count == experiment["episodes"] else ["--episodes", str(count)]


def _episodes(records: list[Record]) -> int:
    seeds = [record.task.seed for record in records]
    return max(seeds) - min(seeds) + 1


def quoted(name: str) -> str:
    """Return a name as ``--policies`` and ``--scenario`` expect it, in double quotes if necessary."""
    return name if PLAIN.fullmatch(name) else '"' + name.replace('"', '""') + '"'

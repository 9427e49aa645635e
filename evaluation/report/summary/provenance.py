"""Where results come from: the runs, their commands, and a command for each row of the results tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from indoor_explorers.evaluation.analysis.facts import shown
from indoor_explorers.evaluation.analysis.reproduce import experiment_files, row_command
from indoor_explorers.evaluation.harness.results.results import Results


@dataclass(frozen=True)
class Provenance:
    """What the page says about where its results come from."""

    runs: list[tuple[str, list[tuple[str, str]]]]
    """Each fact of the runs with its values, and where they differ the runs of each value."""
    run_count: int
    commands: list[str]
    row_commands: list[tuple[str, str, str]]
    """(scenario, policy, command) of each row that one command reproduces."""
    experiments: dict[str, str]
    """The experiment files that these commands read, as TOML by name."""


def provenance(results: Results) -> Provenance:
    """Return where results come from."""
    return Provenance(
        runs=run_rows(results.runs),
        run_count=len(results.runs),
        commands=commands(results.runs),
        row_commands=_row_commands(results),
        experiments=experiment_files(results),
    )


def _row_commands(results: Results) -> list[tuple[str, str, str]]:
    rows = [(scenario, policy, row_command(results, scenario, policy)) for scenario, policy in results.groups]
    return [row for row in rows if row[2]]


def run_rows(runs: Sequence[Mapping[str, Any]]) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return each fact of the runs with its values, and for values that differ the runs that they are of."""
    keys = list(dict.fromkeys(key for run in runs for key in run))
    return [(key, _values(key, runs)) for key in keys]


def _values(key: str, runs: Sequence[Mapping[str, Any]]) -> list[tuple[str, str]]:
    by_value: dict[str, list[int]] = {}
    for number, run in enumerate(runs, 1):
        by_value.setdefault(_fact(run.get(key)), []).append(number)
    if len(by_value) == 1:
        return [(value, "") for value in by_value]
    return [(value, _numbered(numbers)) for value, numbers in by_value.items()]


def _fact(value: Any) -> str:
    return "not recorded" if value is None or value == "" else shown(value)


def _numbered(numbers: Sequence[int]) -> str:
    if len(numbers) == 1:
        return f"run {numbers[0]}"
    if numbers[-1] - numbers[0] + 1 == len(numbers):
        return f"runs {numbers[0]} to {numbers[-1]}"
    return "runs " + ", ".join(str(number) for number in numbers)


def commands(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the different commands of the runs, in order."""
    return list(dict.fromkeys(str(run["command"]) for run in runs if run.get("command")))

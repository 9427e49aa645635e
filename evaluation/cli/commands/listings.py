"""``policies``, ``scenarios`` and ``learners``: list all, or explain some."""

from __future__ import annotations

from itertools import accumulate
from typing import TYPE_CHECKING, Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import Option, Request

if TYPE_CHECKING:
    from collections.abc import Iterable
    from importlib.metadata import EntryPoint

    from rich.console import Console

    from indoor_explorers.env import Scenario
    from indoor_explorers.env.maps.sources import MapSource
    from indoor_explorers.evaluation.cli.parameters import Parameter


#: Columns of the list of scenarios; map, lidar and radio range in cells, last the rewards of step, cell and goal.
HEADINGS = ("scenario", "map", "UAVs", "lidar", "radio", "steps", "goal", "stuck", "step, cell, goal")


class ListOptions(Request):
    """The options of a list."""

    names: Annotated[tuple[str, ...], Option(metavar="NAME", several=True, positional=True)] = ()
    """Explain these, with all their settings (default: list all)."""


def list_policies(options: ListOptions, typed: str) -> int:
    """Print the installed policies, or what some are and their parameters."""
    from rich.table import Table

    from indoor_explorers.env.policies.registry import opener_entry_points, policy_class, policy_entry_points
    from indoor_explorers.env.policies.tunable import told, tunable_parameters
    from indoor_explorers.evaluation.cli.parameters import policy_parameters

    console = make_console()
    for name in options.names:
        kind = policy_class(name)
        _explain(console, name, kind.__doc__ or "", policy_parameters(kind))
        if ranges := tunable_parameters(kind):
            print_line(console, f"Ranges of tune: {told(ranges)}\n")
    if options.names:
        return 0
    table = Table("policy", "what it is", "from", box=None, header_style="bold")
    table.columns[0].no_wrap = True
    declared = policy_entry_points()
    names = {entry.value: name for name, entry in reversed(declared.items())}
    names |= {entry.value: name for name, entry in declared.items() if _is_own_name(name, entry)}
    for name, entry in declared.items():
        own = names[entry.value]
        about = _about(entry) if name == own else f"alias of {own}"
        table.add_row(name, about, entry.dist.name if entry.dist else "")
    for name, entry in opener_entry_points().items():
        table.add_row(f"{name}:PATH", _about(entry), entry.dist.name if entry.dist else "")
    console.print(table, highlight=False, markup=False)
    return 0


def _is_own_name(name: str, entry: EntryPoint) -> bool:
    """Return whether a name is that of its class, such as ``rrt-aep`` for ``RrtAep``, and not an alias."""
    return entry.value.rpartition(":")[2].lower() == name.replace("-", "")


def _about(entry: EntryPoint) -> str:
    """Return the first line of an entry's docstring as plain text."""
    from indoor_explorers.env.policies.registry import missing_module
    from indoor_explorers.evaluation.cli.parameters import plain_text

    try:
        return plain_text(entry.load().__doc__ or "").partition("\n")[0]
    except ModuleNotFoundError as error:
        return missing_module(error)


def _explain(console: Console, name: str, about: str, parameters: Iterable[Parameter]) -> None:
    """Print a docstring and a table of parameters."""
    from rich.table import Table

    from indoor_explorers.evaluation.cli.parameters import plain_text

    print_line(console, name, "bold")
    print_line(console, plain_text(about))
    table = Table("parameter", "default", "", box=None, header_style="bold")
    for parameter in parameters:
        table.add_row(*parameter)
    if table.row_count:
        console.print(table, highlight=False, markup=False)
    print_line(console, "")


def list_learners(options: ListOptions, typed: str) -> int:
    """Print the installed learners, or the hyperparameters of some."""
    from rich.table import Table

    from indoor_explorers.evaluation.cli.parameters import model_parameters
    from indoor_explorers.evaluation.studies.training import find_learner, learner_entry_points

    console = make_console()
    for name in options.names:
        learner = find_learner(name)
        _explain(console, name, learner.__doc__ or "", model_parameters(learner.TrainingConfig))
        presets = ", ".join(getattr(learner, "PRESETS", {}))
        print_line(console, f"Presets for --preset: {presets or 'none'}")
    if not options.names:
        table = Table("learner", "what it is", box=None, header_style="bold")
        for name, entry in learner_entry_points().items():
            table.add_row(name, _about(entry))
        console.print(table, highlight=False, markup=False)
    return 0


def list_scenarios(options: ListOptions, typed: str) -> int:
    """Print the preset scenarios, in as many columns as fit, nothing is cut; or all settings of some, as TOML."""
    from rich.table import Table

    from indoor_explorers.env.scenarios.loading import named_scenario
    from indoor_explorers.env.scenarios.presets import PRESETS

    console = make_console()
    for name in options.names:
        print_line(console, named_scenario(name).to_toml())
    if options.names:
        return 0
    rows = [_scenario_row(preset) for preset in PRESETS.values()]
    widths = [max(map(len, column)) + 2 for column in zip(HEADINGS, *rows, strict=True)]
    fitting = max(1, sum(end - 2 <= console.width for end in accumulate(widths)))
    table = Table(*HEADINGS[:fitting], box=None, header_style="bold", pad_edge=False)
    table.columns[0].no_wrap, table.columns[0].overflow = True, "ignore"
    for row in rows:
        table.add_row(*row[:fitting])
    console.print(table, highlight=False, crop=False)
    if fitting < len(HEADINGS):
        print_line(console, f"A wider window shows: {', '.join(HEADINGS[fitting:])}", "dim")
    return 0


def _scenario_row(preset: Scenario) -> tuple[str, ...]:
    size = "x".join(map(str, _size(preset.map)))
    rewards, radio = preset.rewards, preset.radio.model
    reach = "" if radio in {"none", "unlimited"} else f" {preset.radio.range:g}"
    return (
        *(preset.name, size, str(preset.team), f"{preset.lidar.range:g}", radio + reach),
        *(str(preset.budget), f"{preset.goal:.0%} of {preset.denominator}", preset.stuck.rule),
        f"{rewards.step:+g}, {rewards.discovered:+g}, {rewards.goal:+g}",
    )


def _size(source: MapSource) -> tuple[int, ...]:
    """Return the (height, width) of a source's first map, drawn only where its settings lack them, and its levels."""
    height, width = getattr(source, "height", None), getattr(source, "width", None)
    levels = (source.level_count,) if source.level_count > 1 else ()
    return ((height, width) if height and width else source.floorplan(0, 0).shape) + levels


POLICIES = Command(ListOptions, list_policies)
SCENARIOS = Command(ListOptions, list_scenarios)
LEARNERS = Command(ListOptions, list_learners)

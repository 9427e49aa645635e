"""``policies`` and ``scenarios``: list what can be compared."""

from __future__ import annotations

from itertools import accumulate
from typing import TYPE_CHECKING

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.experiment.request import Request

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from indoor_explorers.env import Scenario
    from indoor_explorers.env.maps.sources import MapSource


#: Columns of the list of scenarios; map, lidar and radio range in cells, last the rewards of step, cell and goal.
HEADINGS = ("scenario", "map", "UAVs", "lidar", "radio", "steps", "goal", "stuck", "step, cell, goal")


class NoOptions(Request):
    """A command without options."""


def list_policies(options: NoOptions, typed: str) -> int:
    """Print the installed policies."""
    from rich.table import Table

    from indoor_explorers.env.policies.registry import opener_entry_points, policy_entry_points

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
    make_console().print(table, highlight=False, markup=False)
    return 0


def _is_own_name(name: str, entry: EntryPoint) -> bool:
    """Return whether a name is that of its class, such as ``rrt-aep`` for ``RrtAep``, and not an alias."""
    return entry.value.rpartition(":")[2].lower() == name.replace("-", "")


def _about(entry: EntryPoint) -> str:
    """Return the first line of an entry's docstring as plain text."""
    from indoor_explorers.env.policies.registry import missing_module

    try:
        line = (entry.load().__doc__ or "").strip().partition("\n")[0]
    except ModuleNotFoundError as error:
        return missing_module(error)
    return line.replace("``", "")


def list_scenarios(options: NoOptions, typed: str) -> int:
    """Print the preset scenarios, in as many columns as fit; nothing is cut."""
    from rich.table import Table

    from indoor_explorers.env.scenarios.presets import PRESETS

    console = make_console()
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
    rows, cols = _shape(preset.map)
    rewards, radio = preset.rewards, preset.radio.model
    reach = "" if radio in {"none", "unlimited"} else f" {preset.radio.range:g}"
    return (
        *(preset.name, f"{rows}x{cols}", str(preset.team), f"{preset.lidar.range:g}", radio + reach),
        *(str(preset.budget), f"{preset.goal:.0%} of {preset.denominator}", preset.stuck.rule),
        f"{rewards.step:+g}, {rewards.discovered:+g}, {rewards.goal:+g}",
    )


def _shape(source: MapSource) -> tuple[int, int]:
    """Return the (height, width) of a source's first map, drawn only where its settings lack them."""
    height, width = getattr(source, "height", None), getattr(source, "width", None)
    return (height, width) if height and width else source.floorplan(0, 0).shape


POLICIES = Command("policies", "list the installed policies", NoOptions, list_policies)
SCENARIOS = Command("scenarios", "list the preset scenarios", NoOptions, list_scenarios)

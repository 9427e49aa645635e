"""Reference pages generated from the code: the command line, the settings of scenarios, and the public names."""

from __future__ import annotations

import argparse
import importlib
import inspect
import re
from collections.abc import Iterator
from enum import EnumType
from pathlib import Path

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from indoor_explorers.env import Scenario
from indoor_explorers.evaluation.analysis.best_planner import PLANNER_COLUMNS
from indoor_explorers.evaluation.analysis.tables.reported_table import COLUMNS as REPORTED_COLUMNS
from indoor_explorers.evaluation.cli.parser import build_parser
from indoor_explorers.evaluation.exports.episodes.csv_tables import COLUMNS as STEP_COLUMNS
from indoor_explorers.evaluation.harness.episodes.metrics import MEASURES
from indoor_explorers.evaluation.harness.results import rows
from indoor_explorers.evaluation.harness.results.differences import COLUMNS as DIFFERENCE_COLUMNS
from indoor_explorers.evaluation.harness.results.origin_ratios import ORIGIN_COLUMNS
from indoor_explorers.evaluation.harness.results.ratios import COLUMNS as RATIO_COLUMNS
from indoor_explorers.evaluation.harness.results.results import SUMMARY_COLUMNS

#: The page that lists the public modules.
NAMES = Path(__file__).parent / "pages" / "reference" / "names.md"
#: What a reader of the store has to know beside its tables.
STORE_NOTES = """
    `facts` and `metrics` are JSON. Blobs are arrays, compressed with zlib: of each step, the covered cells of the team
    and of each UAV, the cells of the UAVs, their actions, the seconds of their decisions and the bytes sent. Map, seed
    and actions determine an episode; `indoor_explorers.evaluation.Results.load(folder)` reads all of it. Every row has
    a checksum. Newer stores have a table `origin` with source and kind of each map by its digest.
    """
#: The files of ``export``.
EXPORT_NOTES = """
    `indoor-explorers export` writes one episode as MCAP or as a ROS 2 bag, whose topics are in
    [the guide](../guides/ros.md), or as a folder with two files. `steps.csv` has a row for each step and UAV:
    {columns}.
    `x` and `y` are metres from the lower left corner; `flew` is 0 once a UAV has ended; `action` led to the step and is
    empty at the start; `discovered` and `received` count the cells that were new to the UAV, by its lidar and by radio;
    `linked` are the UAVs in direct radio contact. Maps of several levels have columns `level` and `z` too, and `row` is
    then that on the level. `meta.json` has the task, its settings, the outcome, the metrics and
    the seconds of a step.
    """
#: How the bounds of a setting are written.
SIGNS = {"ge": "\u2265", "gt": ">", "le": "\u2264", "lt": "<"}


def command_line_page() -> str:
    """Return the help of every command."""
    parser = build_parser()
    (commands,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    helps = [f"## {name}\n\n```text\n{each.format_help().strip()}\n```\n" for name, each in commands.choices.items()]
    return "\n".join(["# Command line\n", f"```text\n{parser.format_help().strip()}\n```\n", *helps])


def metrics_page() -> str:
    """Return the metrics of an episode with their definitions."""
    lines = [
        "# Metrics",
        "",
        "Each is measured in every episode, and is a column of `tables/results.csv` and a `metric` of `summary.csv`,",
        "where the means are. [Plug-ins](../guides/plugins.md) add others.",
        "",
        "| key | name | unit | better | definition |",
        "|---|---|---|---|---|",
    ]
    for key, each in MEASURES.items():
        better = "lower" if each.lower_is_better else "higher"
        cells = (f"`{key}`", each.title, each.unit.replace("us", "\u00b5s"), better, each.definition)
        lines.append(f"| {' | '.join(map(_escaped, cells))} |")
    return "\n".join(
        [*lines, "", "Metrics that begin with `pilot_` are what the pilots of a policy count themselves.", ""]
    )


def files_page() -> str:
    """Return the files that a comparison writes, with their columns and the tables of the store."""
    listed = {
        "summary.csv": ("a row for each policy, scenario and metric", SUMMARY_COLUMNS),
        "tables/ratios.csv": ("steps as ratios to a baseline's, paired", RATIO_COLUMNS),
        "tables/ratios_by_origin.csv": (
            "where maps are of several kinds or sources, the same on the maps of each",
            ORIGIN_COLUMNS,
        ),
        "tables/best_planner.csv": (
            "where learners and planners flew several scenarios, steps as ratios to the best planner of each",
            PLANNER_COLUMNS,
        ),
        "tables/differences.csv": ("steps minus a baseline's, paired", DIFFERENCE_COLUMNS),
        "tables/reported.csv": (
            "where rows of others were imported, a row for each reported and flown policy and metric",
            REPORTED_COLUMNS,
        ),
    }
    lines = [
        "# Files",
        "",
        "A comparison writes these into its folder; [the guide](../guides/compare.md) says what each is for.",
        "",
    ]
    for name, (about, columns) in listed.items():
        lines += [f"## {name}", "", f"{about.capitalize()}: {', '.join(f'`{column}`' for column in columns)}.", ""]
    lines += [
        "## results.db",
        "",
        "An SQLite database of these tables:",
        "",
    ]
    lines += ["```sql", rows.SCHEMA.strip(), "```", "", inspect.cleandoc(STORE_NOTES), ""]
    steps = ", ".join(f"`{column}`" for column in STEP_COLUMNS)
    lines += ["## Exported episodes", "", inspect.cleandoc(EXPORT_NOTES).format(columns=steps), ""]
    return "\n".join(lines)


def settings_page() -> str:
    """Return the settings of a scenario: keys of its TOML file, and of ``--set``."""
    lines = [
        "# Settings of a scenario",
        "",
        "Each is a key of a scenario's TOML table, of `--set key=value`, and of `Scenario.with_settings`; a dot leads",
        "into a table, as in `lidar.range`.",
        "",
    ]
    for title, model, prefix in _tables(Scenario, "Scenario", ""):
        lines += [f"## {title}", "", inspect.cleandoc(model.__doc__ or ""), ""]
        lines += ["| key | values | default | |", "|---|---|---|---|"]
        lines += [_row(prefix + name, field) for name, field in model.model_fields.items()]
        lines.append("")
    return "\n".join(lines)


def _tables(model: type[BaseModel], title: str, prefix: str) -> Iterator[tuple[str, type[BaseModel], str]]:
    """Yield a model and the models of its fields, with titles and the prefixes of their keys."""
    yield title, model, prefix
    for name, field in model.model_fields.items():
        models = [each for each in _parts(field.annotation) if isinstance(each, type) and issubclass(each, BaseModel)]
        for each in models:
            source = each.model_fields.get("source")
            titled = f"{prefix}{name}" if source is None else f'{prefix}{name} with source = "{source.default}"'
            yield from _tables(each, titled, f"{prefix}{name}.")


def _parts(annotation: object) -> tuple[object, ...]:
    """Return the members of a union, or the one type."""
    arguments = getattr(annotation, "__args__", ())
    return arguments if "Union" in type(annotation).__name__ or "|" in str(annotation) else (annotation,)


def _row(key: str, field: FieldInfo) -> str:
    default = "" if field.is_required() else f"`{_short(field.get_default(call_default_factory=True))}`"
    bounds = [
        f"{sign} {getattr(each, name)}"
        for each in field.metadata
        for name, sign in SIGNS.items()
        if hasattr(each, name)
    ]
    values = _escaped(", ".join([_named(field.annotation), *bounds]))
    return f"| `{key}` | {values} | {_escaped(default)} | {_escaped(' '.join((field.description or '').split()))} |"


def _short(value: object) -> str:
    return "its defaults" if isinstance(value, BaseModel) else repr(value)


def _named(annotation: object) -> str:
    text = annotation.__name__ if isinstance(annotation, type) else str(annotation)
    return re.sub(r"(?:typing\.|indoor_explorers\.[\w.]+\.)", "", text)


def _escaped(text: str) -> str:
    return text.replace("|", "\\|")


def public_modules() -> list[str]:
    """Return the modules whose names are public."""
    return re.findall(r"`(indoor_explorers\.[\w.]+)`", NAMES.read_text("utf-8").partition("- The entry-point")[0])


def python_pages() -> dict[str, str]:
    """Return a page for each public module, and one that lists them; an undocumented name is refused."""
    pages, index = {}, ["# Python", ""]
    described: dict[str, str] = {}
    for name in public_modules():
        module = importlib.import_module(name)
        page, about = f"python/{name.rpartition('.')[2]}.md", (inspect.getdoc(module) or "").partition("\n\n")[0]
        lines = [f"# {name}", "", about, ""]
        for public in sorted(module.__all__):
            lines += _described(f"{name}.{public}", getattr(module, public), described)
        pages[f"reference/{page}"] = "\n".join(lines)
        index += [f"## [{name}]({page})", "", about, "", ", ".join(f"`{each}`" for each in sorted(module.__all__)), ""]
    return {"reference/python.md": "\n".join(index)} | pages


def _described(name: str, value: object, described: dict[str, str]) -> list[str]:
    """Return the lines of one public name; what another module's page has ``described`` is referred to."""
    module, _, title = name.rpartition(".")
    if not (inspect.isclass(value) or inspect.isroutine(value)):
        number = f", {value}" if isinstance(value, (int, np.integer)) else ""
        return [f"## {title}", "", f"`{type(value).__name__}`{number}", ""]
    if not inspect.getdoc(value):
        raise ValueError(f"{name}: a public name has no docstring")
    path = f"{value.__module__}.{value.__qualname__}"
    if path in described:
        return [f"## {title}", "", f"See [{title}][{path}] of `{described[path]}`.", ""]
    described[path] = module
    members = ["    options:", "      show_if_no_docstring: true"]  # an enumeration's say enough by their names
    return [f"::: {path}", *(members if isinstance(value, EnumType) else ()), ""]

"""Small coverage panels side by side, one for each map or scenario, as inline SVG that needs no script."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.coverage_axes import coverage_at, focus_step, last_active_step
from indoor_explorers.evaluation.analysis.outliers import far_behind
from indoor_explorers.evaluation.drawing.formatting import counted
from indoor_explorers.evaluation.drawing.palette import DASHES, MARKER_PATHS, PolicyStyle, Styles
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold

#: Limit of panels; more maps are shown by folder, or only the first of them.
MOST = 24
#: Panels share their range of steps unless the longest range is more than this multiple of the shortest.
UNLIKE = 5
#: Position of the axes in a panel of 240 by 140.
LEFT, RIGHT, TOP, BOTTOM = 30.0, 236.0, 6.0, 122.0
#: Steps at which a curve is drawn.
POINTS = 50
#: Limit of the points of all curves of all scenarios, and the fewest of a curve.
MOST_POINTS, FEWEST_POINTS = 24_000, 16

Groups = dict[str, list[Record]]


@dataclass(frozen=True)
class Panel:
    """One small chart."""

    title: str
    detail: str
    drawing: Markup
    task: tuple[int, int] | None = None
    """Map index and seed of the episode to replay."""
    section: str = ""
    """The section to jump to."""


@dataclass(frozen=True)
class SmallMultiples:
    """The panels of a section."""

    panels: list[Panel]
    maps: int
    by_folder: bool
    same_axes: bool
    """False if maps differ so much in size that each panel has its own range of steps."""


def map_multiples(comparison: Comparison, styles: Styles) -> SmallMultiples | None:
    """Return a panel for each map file, or for each folder where the files are many; None for one map."""
    indices = sorted({record.task.map_index for record in comparison.records})
    if len(indices) < 2:
        return None
    folders = _folders(comparison)
    by_folder = len(indices) > MOST and 1 < len(set(folders.values())) <= MOST
    labels: dict[int, Any] = folders if by_folder else {index: index for index in indices}
    chosen = list(dict.fromkeys(labels[index] for index in indices))[:MOST]
    parts = {label: _where(comparison, {i for i in indices if labels[i] == label}) for label in chosen}
    far = far_behind(comparison)
    limits = {label: _limit(groups, far, comparison.level) for label, groups in parts.items()}
    longest = max(limits.values())
    same_axes = longest <= UNLIKE * min(limits.values())
    panels = [
        _map_panel(
            groups, str(label) if by_folder else "", longest if same_axes else limits[label], styles, comparison.level
        )
        for label, groups in parts.items()
    ]
    return SmallMultiples(panels, len(indices), by_folder, same_axes)


def _limit(groups: Groups, far: Sequence[str], level: CoverageThreshold) -> int:
    """Return the step after which curves hardly change, by the policies that are not far behind."""
    near = [records for policy, records in groups.items() if policy not in far]
    return last_active_step(near or list(groups.values()), level.share)


def _folders(comparison: Comparison) -> dict[int, str]:
    """Return the name of the folder that each map file lies in."""
    paths = comparison.results.scenarios[comparison.scenario]["map"].get("paths", [])
    return {index: Path(path).parent.name for index, path in enumerate(paths)}


def _where(comparison: Comparison, indices: set[int]) -> Groups:
    kept = {
        policy: [record for record in records if record.task.map_index in indices]
        for policy, records in comparison.groups.items()
    }
    return {policy: records for policy, records in kept.items() if records}


def _map_panel(groups: Groups, folder: str, limit: int, styles: Styles, level: CoverageThreshold) -> Panel:
    task = _median_task(groups)
    records = [record for group in groups.values() for record in group]
    name = next(record.floorplan.name for record in records if record.task == task)
    size = next(record.floorplan.levels.size for record in records if record.task == task)
    maps = len({record.task.map_index for record in records})
    detail = counted(maps, "map") if folder else " x ".join(map(str, size))
    return Panel(folder or name, detail, _drawing(groups, limit, styles, level), (task.map_index, task.seed))


def _median_task(groups: Groups) -> Task:
    """Return the median task by the total steps of all policies."""
    steps: dict[Task, int] = {}
    for records in groups.values():
        for record in records:
            steps[record.task] = steps.get(record.task, 0) + record.steps
    return sorted(steps, key=lambda task: (steps[task], task))[(len(steps) - 1) // 2]


def scenario_multiples(sections: Sequence[tuple[str, Comparison]], styles: Styles) -> list[Panel]:
    """Return a panel for each scenario; none for a single one."""
    flown = [(section, each) for section, each in sections if each.groups]
    if len(flown) < 2:
        return []
    points = max(FEWEST_POINTS, min(POINTS, MOST_POINTS // sum(len(each.groups) for _, each in flown[:MOST])))
    return [
        Panel(
            each.scenario,
            f"{family(each)}, {counted(each.results.scenarios[each.scenario]['team'], 'UAV')}",
            _drawing(each.groups, focus_step(each), styles, each.level, points),
            section=section,
        )
        for section, each in flown[:MOST]
    ]


def family(comparison: Comparison) -> str:
    """Return the kind of maps of a scenario: the generator, or the folders of its files."""
    source = str(comparison.results.scenarios[comparison.scenario]["map"]["source"])
    folders = dict.fromkeys(_folders(comparison).values())
    return " and ".join(folders) if 0 < len(folders) <= 2 else f"{source} maps"


def _drawing(groups: Groups, limit: int, styles: Styles, level: CoverageThreshold, points: int = POINTS) -> Markup:
    """Draw the mean coverage of each policy over 0 to ``limit`` steps, with a line at ``level``."""
    steps = np.unique(np.linspace(0, limit, points).round()).astype(np.int64)
    x = LEFT + (RIGHT - LEFT) * steps / limit
    lines = [
        _line(policy, x, _height(coverage_at(records, steps).mean(axis=0)), styles[policy])
        for policy, records in groups.items()
    ]
    ticks = Markup("").join(
        Markup('<path class="grid" d="M{} {y}H{}"/><text x="{}" y="{}" text-anchor="end">{}</text>').format(
            LEFT, RIGHT, LEFT - 4, _height(share) + 3, f"{share:.0%}"[:-1], y=_height(share)
        )
        for share in sorted({0.0, 0.5, level.share})
    )
    ends = Markup('<text x="{}" y="135">0</text><text x="{}" y="135" text-anchor="end">{}</text>').format(
        LEFT, RIGHT, f"{limit} steps"
    )
    return Markup('<svg viewBox="0 0 240 140" aria-hidden="true">{}{}{}</svg>').format(
        ticks, ends, Markup("").join(lines)
    )


def _height(share: Any) -> Any:
    return BOTTOM - (BOTTOM - TOP) * share


def _line(policy: str, x: np.ndarray, y: np.ndarray, style: PolicyStyle) -> Markup:
    """Draw one curve with its dash, and its marker once."""
    path = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))
    dash = " ".join(f"{length:g}" for length in DASHES[style.dash]) or "none"
    place = (len(x) // 5 + 3 * style.marker) % len(x)
    return Markup(
        '<g data-name="{}" style="color:{}"><path class="curve" stroke-dasharray="{}" d="{}"/>'
        '<path class="mark" transform="translate({:.1f} {:.1f})" d="{}"/></g>'
    ).format(policy, style.variable, dash, path, x[place], y[place], MARKER_PATHS[style.marker])

"""The sections of the page about sweeps of the radio's range, of the number of UAVs, and of other settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from indoor_explorers.evaluation.analysis.panels.plot_data import Plot
from indoor_explorers.evaluation.analysis.panels.sweep_plots import range_plots, setting_plots
from indoor_explorers.evaluation.analysis.panels.team_scaling import scaling_plots
from indoor_explorers.evaluation.analysis.sweeps import (
    RadioSweep,
    SettingSweep,
    TeamScaling,
    radio_sweeps,
    setting_sweeps,
    team_scalings,
)
from indoor_explorers.evaluation.drawing.formatting import counted, span
from indoor_explorers.evaluation.drawing.palette import Styles
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.harness.results.results import Results


@dataclass(frozen=True)
class SweepPanel:
    """One sweep: small plots that share their legend."""

    title: str
    scenarios: tuple[str, ...]
    policies: list[str]
    plots: Sequence[Plot]
    times: list[str]
    """Titles of the times that are shown, that to the threshold last."""
    tasks: str
    """Number of episodes of a point."""
    few: bool
    beyond: str
    """A sentence about the policies that the ranges leave out; empty where they have all."""
    hollow: bool
    """Whether a point is hollow because some of its episodes never reached the threshold."""


@dataclass(frozen=True)
class SweepSection:
    """The panels of all sections; a section without panels is left out."""

    radio: list[SweepPanel]
    team: list[SweepPanel]
    setting: list[SweepPanel]


def sweep_sections(results: Results, styles: Styles) -> SweepSection:
    """Return the sweeps among the scenarios that have been flown."""
    flown = {scenario for scenario, _ in results.groups}
    settings = {name: facts for name, facts in results.scenarios.items() if name in flown}
    radio = [
        _panel(_radio_title(each), each, range_plots(results, each, styles), results) for each in radio_sweeps(settings)
    ]
    team = [
        _panel(_team_title(each, settings), each, scaling_plots(results, each, styles), results)
        for each in team_scalings(settings)
    ]
    setting = [
        _panel(_setting_title(each), each, setting_plots(results, each, styles), results)
        for each in setting_sweeps(settings)
    ]
    return SweepSection(*([panel for panel in panels if panel] for panels in (radio, team, setting)))


def _panel(
    title: str, sweep: RadioSweep | TeamScaling | SettingSweep, plots: Sequence[Plot], results: Results
) -> SweepPanel | None:
    series = [each for plot in plots for each in plot.series]
    if not series:
        return None
    return SweepPanel(
        title,
        sweep.scenarios,
        list(dict.fromkeys(each.name for each in series)),
        plots,
        [CoverageThreshold(key).title for key in results.level(sweep.scenarios[0]).times],
        span(len(records) for (scenario, _), records in results.groups.items() if scenario in sweep.scenarios),
        any(each.dots for each in series),
        plots[0].beyond,
        any(any(each.hollow or []) for each in series),
    )


def _radio_title(sweep: RadioSweep) -> str:
    model = "" if sweep.model in ("none", "unlimited") else f", {sweep.model} radio"
    return f"{counted(sweep.team, 'UAV')}{model}"


def _setting_title(sweep: SettingSweep) -> str:
    *most, last = (f"{value:g}" for value in sweep.values)
    return f"{sweep.setting.partition(' [')[0].capitalize()}: {', '.join(most)} and {last}"


def _team_title(scaling: TeamScaling, settings: Mapping[str, Any]) -> str:
    radio = settings[scaling.scenarios[-1]]["radio"]
    reach = {"none": "without radio", "unlimited": "unlimited radio"}
    radius = reach.get(radio["model"], f"{radio['model']} radio of {radio['range']:g} cells")
    loss = f", {radio['loss']:.0%} of contacts lost" if radio.get("loss") else ""
    *most, last = scaling.teams
    return f"{', '.join(str(team) for team in most)} and {last} UAVs, {radius}{loss}"

"""The overview at the top of the page: who came first, the league table, and whether the policies are comparable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.charts.small_multiples import Panel, scenario_multiples
from indoor_explorers.evaluation.report.style.palette import Styles
from indoor_explorers.evaluation.report.summary.comparability import Verdict, verdict_on
from indoor_explorers.evaluation.report.summary.headline import NAME, headline
from indoor_explorers.evaluation.report.tables.league_table import LeagueTable, league_table
from indoor_explorers.evaluation.results.coverage_threshold import CoverageThreshold, shared
from indoor_explorers.evaluation.results.results import Results
from indoor_explorers.evaluation.statistics import Finding


@dataclass(frozen=True)
class Overview:
    """The first section of the page."""

    verdict: Verdict
    lead: Markup
    """The best policies in a sentence or two."""
    level: CoverageThreshold | None
    """The coverage threshold of all scenarios; None if they differ."""
    league: LeagueTable
    panels: dict[str, Panel]
    """A small coverage chart of each scenario by section; empty for a single scenario."""


def overview(results: Results, comparisons: Mapping[str, Comparison], styles: Styles) -> Overview:
    """Gather the overview of all results; ``comparisons`` are those of their common tasks, by section."""
    return Overview(
        verdict=verdict_on(results),
        lead=lead(list(comparisons.values())),
        level=shared(results.levels),
        league=league_table(comparisons, styles),
        panels={panel.section: panel for panel in scenario_multiples(list(comparisons.items()), styles)},
    )


def lead(comparisons: Sequence[Comparison]) -> Markup:
    """Name the best policies in a sentence or two; for a single scenario return its headline."""
    flown = [each for each in comparisons if each.groups]
    if len(flown) < 2:
        return headline(flown[0]) if flown else Markup("")
    tally = Counter(each.ranked_policies[0] for each in flown)
    wins = [
        Markup("{} in {}").format(NAME.format(name), f"{number} of {len(flown)} scenarios" if not place else number)
        for place, (name, number) in enumerate(tally.most_common())
    ]
    level = shared(each.level for each in flown)
    return Markup("Lowest mean {}: {}. {}").format(
        level.title if level else "time to the coverage threshold",
        Markup(", ").join(wins),
        _significance(sum(_beats_runner_up(each) for each in flown), len(flown)),
    )


def _significance(significant: int, scenarios: int) -> str:
    """Say in how many scenarios the lead over the runner-up is significant."""
    if significant == scenarios:
        return "Every lead is statistically significant."
    if significant:
        return f"{significant} of {scenarios} leads {'is' if significant == 1 else 'are'} statistically significant."
    return f"{'Neither' if scenarios == 2 else 'No'} lead is statistically significant."


def _beats_runner_up(comparison: Comparison) -> bool:
    second = comparison.ranked_policies[1] if len(comparison.ranked_policies) > 1 else ""
    return second in comparison.contrasts and comparison.contrasts[second].finding is Finding.WORSE

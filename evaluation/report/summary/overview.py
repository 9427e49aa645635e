"""The overview at the top of the page: who came first, the league table, and whether the policies are comparable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.evaluation.analysis.comparability import Verdict, verdict_on
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failure_lines
from indoor_explorers.evaluation.analysis.headline import headline, named
from indoor_explorers.evaluation.analysis.resolution import fastest, outcomes, resolution
from indoor_explorers.evaluation.analysis.tables.league_table import LeagueTable, league_table
from indoor_explorers.evaluation.drawing.formatting import counted, joined
from indoor_explorers.evaluation.drawing.palette import Styles
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold, shared
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.charts.small_multiples import Panel, scenario_multiples

#: Largest number of scenarios that are named.
FEW = 3


@dataclass(frozen=True)
class Overview:
    """The first section of the page."""

    verdict: Verdict
    lead: Markup
    """The best policies, and what was resolved."""
    failures: list[str]
    """What failed how often and why."""
    level: CoverageThreshold | None
    """The coverage threshold of all scenarios; None if they differ."""
    league: LeagueTable
    panels: dict[str, Panel]
    """A small coverage chart of each scenario by section; empty for a single scenario."""


def overview(results: Results, comparisons: Mapping[str, Comparison], styles: Styles) -> Overview:
    """Gather the overview of all results; ``comparisons`` cover their common tasks, by section."""
    return Overview(
        verdict=verdict_on(results),
        lead=lead(list(comparisons.values())),
        failures=list(failure_lines(results.records)),
        level=shared(results.levels),
        league=league_table(comparisons, styles),
        panels={panel.section: panel for panel in scenario_multiples(list(comparisons.items()), styles)},
    )


def lead(comparisons: Sequence[Comparison]) -> Markup:
    """Name the best policies, and say what was resolved; for a single scenario return its headline."""
    flown = [each for each in comparisons if each.groups]
    if len(flown) < 2:
        return headline(flown[0]) if flown else Markup("")
    first = {each.scenario: tuple(fastest(each)) for each in flown}
    level, tally = shared(each.level for each in flown), Counter(filter(None, first.values()))
    reached = level.percent if level else "the coverage threshold"
    if not tally:
        return Markup("No policy reached {} in any of the {} scenarios.").format(reached, len(flown))
    wins = [
        Markup("{} in {}").format(named(names), number if place else f"{number} of {len(flown)} scenarios")
        for place, (names, number) in enumerate(sorted(tally.items(), key=lambda each: (-each[1], each[0])))
    ]
    unreached = [name for name, names in first.items() if not names]
    missed = Markup("; no policy reached {} in {}").format(reached, _listed(unreached)) if unreached else ""
    what = level.title if level else "time to the coverage threshold"
    resolved = resolution([outcomes(each) for each in flown if first[each.scenario]], flown[0].results.margin)
    return Markup("Lowest mean {}: {}{}. {}").format(what, Markup(", ").join(wins), missed, resolved)


def _listed(scenarios: Sequence[str]) -> str:
    """Return the names of few scenarios, else their number."""
    return joined(scenarios) if len(scenarios) <= FEW else counted(len(scenarios), "scenario")

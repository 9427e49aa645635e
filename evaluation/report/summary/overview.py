"""The overview at the top of the page: the best policy of each scenario."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.charts.small_multiples import Panel, scenario_multiples
from indoor_explorers.evaluation.report.style.formatting import percent, with_interval
from indoor_explorers.evaluation.report.style.palette import Styles
from indoor_explorers.evaluation.report.summary.comparability import Verdict, verdict_on
from indoor_explorers.evaluation.report.summary.headline import NAME, headline
from indoor_explorers.evaluation.results.coverage_threshold import CoverageThreshold, shared
from indoor_explorers.evaluation.results.results import Results


@dataclass(frozen=True)
class OverviewRow:
    """One scenario in the table of all."""

    id: str
    scenario: str
    first: str
    """The policy with the lowest mean time among those that do not know the map; empty if none was flown."""
    level: CoverageThreshold
    """The coverage threshold of the scenario."""
    time: str
    """Its mean steps to the threshold."""
    reached: str
    runner_up: str
    lead: str
    """The runner-up's steps minus those of the first."""
    shown: bool
    """Whether that difference is significant."""


@dataclass(frozen=True)
class Overview:
    """The first section of the page."""

    verdict: Verdict
    lead: Markup
    """The best policies in a sentence or two."""
    level: CoverageThreshold | None
    """The coverage threshold of all scenarios; None if they differ."""
    rows: list[OverviewRow]
    panels: list[Panel]
    """Small coverage charts, one for each scenario."""


def overview(results: Results, comparisons: Mapping[str, Comparison], styles: Styles) -> Overview:
    """Gather the overview of all results; ``comparisons`` are those of their common tasks, by section."""
    return Overview(
        verdict=verdict_on(results),
        lead=lead(list(comparisons.values())),
        level=shared(results.levels),
        rows=[overview_row(each, section) for section, each in comparisons.items()],
        panels=scenario_multiples(list(comparisons.items()), styles),
    )


def overview_row(comparison: Comparison, section_id: str) -> OverviewRow:
    """Return the row of a scenario."""
    name, level = comparison.scenario, comparison.level
    if not comparison.groups:
        return OverviewRow(section_id, name, "", level, "", "", "", "", False)
    first, *others = comparison.ranked_policies
    second = others[0] if others else ""
    contrast = comparison.contrasts.get(second)
    return OverviewRow(
        id=section_id,
        scenario=name,
        first=first,
        level=level,
        time=with_interval(comparison.time(first)),
        reached=percent(comparison.reached(first)),
        runner_up=second,
        lead=with_interval(contrast.difference, sign=True) if contrast else "",
        shown=bool(contrast and contrast.shown),
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
        return "Every lead over the runner-up is statistically significant."
    if significant:
        return f"The lead over the runner-up is statistically significant in {significant} of {scenarios}."
    return f"{'Neither' if scenarios == 2 else 'No'} lead over the runner-up is statistically significant."


def _beats_runner_up(comparison: Comparison) -> bool:
    second = comparison.ranked_policies[1] if len(comparison.ranked_policies) > 1 else ""
    return second in comparison.contrasts and comparison.contrasts[second].shown

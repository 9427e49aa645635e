"""Sentences below a scenario's table: identical flights, differing success rates, detectable differences."""

from __future__ import annotations

import math

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_of
from indoor_explorers.evaluation.analysis.tables.contrast_table import margin, missing
from indoor_explorers.evaluation.drawing.formatting import decimals_for, fixed, joined, percent
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.statistics import FEWEST, Finding

#: Largest number of episodes that never reached a threshold for which the interval of its mean is called too narrow.
FEW_NEVER = 5


def scenario_notes(comparison: Comparison) -> list[str]:
    """Return all sentences about a scenario; empty where there is nothing to say."""
    return [*twin_notes(comparison), *success_notes(comparison), *tested_notes(comparison)]


def tested_notes(comparison: Comparison) -> list[str]:
    """Return the sentences about what the tests show, and what they could have shown."""
    return [*resolved_notes(comparison), *detectable_notes(comparison), *unseen_notes(comparison)]


def twin_notes(comparison: Comparison) -> list[str]:
    """Name the policies that flew the same episodes, which count as one."""
    return [f"{joined(names)} flew the same episodes." for names in comparison.twins]


def success_notes(comparison: Comparison) -> list[str]:
    """Name the policies whose success differs significantly from that of the best-ranked; empty without any."""
    differ = [name for name in _sound(comparison) if comparison.success_differs(name)]
    first = comparison.ranked_policies[0] if differ else ""
    return [
        f"Reached {comparison.level.percent} {word} often than {first}, significantly: {', '.join(names)}."
        for word, sign in (("less", -1), ("more", 1))
        if (names := [name for name in differ if sign * (comparison.reached(name) - comparison.reached(first)) > 0])
    ]


def detectable_notes(comparison: Comparison) -> list[str]:
    """State the smallest detectable differences to the best-ranked policy, of those not shown to differ if any."""
    rivals = [comparison.contrasts[name] for name in _sound(comparison) if name in comparison.contrasts]
    tested = [each for each in rivals if each.difference.low is not None and 0 < each.detectable < math.inf]
    sizes = sorted(each.detectable for each in [each for each in tested if not each.shown] or tested)
    if not sizes:
        return []
    least, most = fixed(sizes[0], 1), fixed(sizes[-1], 1)
    span = most if least == most else f"{least} to {most}"
    first, level = comparison.ranked_policies[0], comparison.level.title
    return [f"Only differences of {level} to {first} above some {span} steps can be detected with so few episodes."]


def _sound(comparison: Comparison) -> list[str]:
    """Return the ranked policies that failed in no episode, best first."""
    return [name for name in comparison.ranked_policies if not failed_of(comparison, name)]


def resolved_notes(comparison: Comparison) -> list[str]:
    """Name the ranked policies that are as good as the best-ranked one, and those not resolved."""
    first = comparison.ranked_policies[0]
    rivals = {name: comparison.contrasts[name] for name in comparison.ranked_policies if name in comparison.contrasts}
    tested = {name: each for name, each in rivals.items() if each.difference.low is not None and each.margin}
    good = [name for name, each in tested.items() if each.finding is Finding.AS_GOOD]
    resolving = [f"{name} ({missing(each)})" for name, each in tested.items() if each.finding is Finding.OPEN]
    return [
        *([f"As good as {first} within {margin(tested[good[0]])}: {', '.join(good)}."] if good else []),
        *([f"Not resolved against {first}: {', '.join(resolving)}."] if resolving else []),
    ]


def unseen_notes(comparison: Comparison) -> list[str]:
    """Say what failures that were not seen could cost the best-ranked policy, where it is better than another."""
    first = comparison.ranked_policies[0]
    found = comparison.undetected(first)
    if found is None or all(each.finding is not Finding.WORSE for each in comparison.contrasts.values()):
        return []
    share, steps = found
    return [
        f"Times are compared where both finished; failures of {first} that its episodes cannot exclude "
        f"(up to {percent(share)}) would add up to {fixed(steps, decimals_for(steps))} steps to its mean."
    ]


def narrow_notes(comparison: Comparison) -> list[str]:
    """Name the policies whose interval of a time is too narrow: a few episodes never reached it."""
    return [
        f"The interval of {CoverageThreshold(metric).title} is too narrow: {'; '.join(few)} never reached."
        for metric in comparison.level.times
        if (few := [text for policy in comparison.groups if (text := _few_never(comparison, policy, metric))])
    ]


def _few_never(comparison: Comparison, policy: str, metric: str) -> str:
    reached = comparison.results.reached(comparison.scenario, policy, metric)
    never = int((~reached).sum())
    few = len(reached) >= FEWEST and 0 < never <= FEW_NEVER
    return f"{policy}, {never} of {len(reached)}" if few else ""

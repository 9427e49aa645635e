"""Sentences about the differences that tests resolved and did not resolve, in one scenario or several."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from markupsafe import Markup, escape

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_of
from indoor_explorers.evaluation.drawing.formatting import percent_as_given
from indoor_explorers.evaluation.statistics import Finding

NAME = Markup("<b>{}</b>")
#: Policies by what is shown of them against the best; None where no test was made.
Outcomes = Mapping[Finding | None, Sequence[str]]
#: The beginning of the sentence about those policies, in the order of the sentences.
SAID: dict[Finding | None, str] = {
    Finding.WORSE: "Significantly worse",
    Finding.BETTER: "Significantly better where both finished",
    Finding.MIXED: "Faster but finishing less often, or the reverse",
    Finding.AS_GOOD: "As good within {margin}",
    Finding.OPEN: "Not resolved",
    None: "Too few episodes for a test",
}


def fastest(comparison: Comparison) -> list[str]:
    """Return the ranked policies that share the lowest mean time, by name; empty where none reached the threshold."""
    times = {name: comparison.time(name).mean for name in comparison.ranked_policies if comparison.reached(name)}
    return sorted(name for name, mean in times.items() if mean == min(times.values()))


def rivals(comparison: Comparison) -> list[str]:
    """Return the other ranked policies that failed in no episode, best first."""
    first = fastest(comparison)
    return [name for name in comparison.ranked_policies if name not in first and not failed_of(comparison, name)]


def outcomes(comparison: Comparison) -> Outcomes:
    """Return the :func:`rivals` by what is shown of them against the best."""
    found: dict[Finding | None, list[str]] = {}
    for name in rivals(comparison) if fastest(comparison) else ():
        contrast = comparison.contrasts.get(name)
        finding = contrast.finding if contrast else None
        if contrast and finding is Finding.OPEN and contrast.difference.low is None:
            finding = None
        found.setdefault(finding, []).append(name)
    return found


def resolution(scenarios: Sequence[Outcomes], margin: float) -> Markup:
    """Say of which policies something is shown, and of which nothing; with counts if scenarios are several."""
    named = {kind: Counter(name for each in scenarios for name in each.get(kind, ())) for kind in SAID}
    if named[None] and named[None].total() == sum(names.total() for names in named.values()):
        return Markup(f"{SAID[None]}.")
    within = percent_as_given(margin)
    return escape(
        " ".join(
            f"{SAID[kind].format(margin=within)}: {_counted(names, len(scenarios))}."
            for kind, names in named.items()
            if names
        )
    )


def _counted(names: Counter[str], scenarios: int) -> str:
    counts = {name: "" if scenarios == 1 else f" in {number}" for name, number in names.items()}
    return ", ".join(f"{name}{' in all' if names[name] == scenarios > 1 else count}" for name, count in counts.items())

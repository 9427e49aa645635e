"""What the tests resolved and what they did not, in a sentence about one scenario or several."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from markupsafe import Markup, escape

from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.analysis.failures import failed_of
from indoor_explorers.evaluation.report.tables.contrast_table import margin
from indoor_explorers.evaluation.statistics import Contrast, Finding

NAME = Markup("<b>{}</b>")
#: Policies by what is shown of them against the best.
Outcomes = Mapping[str, Sequence[str]]
UNTESTED = "Too few episodes for a test"


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
    found: dict[str, list[str]] = {}
    for name in rivals(comparison) if fastest(comparison) else ():
        found.setdefault(_finding(comparison.contrasts.get(name)), []).append(name)
    return found


def _finding(contrast: Contrast | None) -> str:
    """Return what is shown about a policy against the best, as the beginning of a sentence."""
    if contrast is None or contrast.difference.low is None:
        return UNTESTED
    return {
        Finding.WORSE: "Significantly worse",
        Finding.BETTER: "Significantly better where both finished",
        Finding.MIXED: "Faster but finishing less often, or the reverse",
        Finding.AS_GOOD: f"As good within {margin(contrast)}",
        Finding.OPEN: "Not resolved",
    }[contrast.finding]


def resolution(scenarios: Sequence[Outcomes]) -> Markup:
    """Say which policies are slower than the best, as good as it, or neither; with counts if scenarios are several."""
    kinds = dict.fromkeys(kind for each in scenarios for kind in each)
    named = {kind: Counter(name for each in scenarios for name in each.get(kind, ())) for kind in kinds}
    if not any(names for kind, names in named.items() if kind != UNTESTED):
        return Markup(f"{UNTESTED}.") if any(named.values()) else Markup("")
    parts = [
        f"{kind}: {', '.join(_counted(name, names[name], len(scenarios)) for name in names)}."
        for kind, names in named.items()
        if names
    ]
    return escape(" ".join(parts))


def _counted(name: str, number: int, scenarios: int) -> str:
    return name if scenarios == 1 else f"{name} in {'all' if number == scenarios else number}"

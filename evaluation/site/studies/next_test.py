"""The six comparisons that NEXT_TEST.md declared before anything was flown, from stored results.

``python -P -m indoor_explorers.evaluation.site.studies.next_test DIR`` prints them in Markdown. ``DIR`` has the folders
of that page. Claims of fewer or more steps take the sign-flip test, those of policies that are as good the equivalence
test with :data:`MARGIN`; buildings are drawn where the suite names them. Holm's method adjusts the six p-values.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

from indoor_explorers.evaluation.analysis.tables.ratio_table import bounded
from indoor_explorers.evaluation.drawing.formatting import MINUS, fixed, with_interval
from indoor_explorers.evaluation.harness.results.ratios import RatioRow, Ratios
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import CONFIDENCE, Contrast, Finding, contrasts, holm

#: The declared margin, by which share a mean may exceed the other for two policies to be as good.
MARGIN = 0.05


class Claim(StrEnum):
    """What was declared of a policy and another."""

    FEWER = "needs fewer steps than"
    MORE = "needs more steps than"
    AS_GOOD = "is as good as"


class Verdict(StrEnum):
    """What came of a claim."""

    SHOWN = "shown"
    OPPOSITE = "the opposite is shown"
    """Of a claim of fewer or more steps alone; no test is about the opposite of being as good."""
    OPEN = "not shown"


class Declared(NamedTuple):
    """A declared comparison."""

    folder: str
    """Folder of the results."""
    scenario: str
    metric: str
    """``t90`` or ``t99``."""
    policy: str
    claim: Claim
    other: str


DECLARED = (
    Declared("next-rooms", "thesis-obstacles", "t90", "dddqn", Claim.FEWER, "tours"),
    Declared("next-rooms", "thesis-obstacles", "t99", "dddqn", Claim.AS_GOOD, "tours"),
    Declared("next-rooms", "thesis-team-4", "t99", "dddqn", Claim.MORE, "horizon"),
    Declared("next-floors", "small-floors", "t99", "frontier-predictive", Claim.FEWER, "frontier-latency"),
    Declared("next-floors", "small-floors", "t99", "dddqn", Claim.AS_GOOD, "frontier-predictive"),
    Declared("buildings-1", "buildings-1", "t99", "frontier-predictive", Claim.FEWER, "frontier"),
)


@dataclass(frozen=True, eq=False)
class Tested:
    """A declared comparison with its result."""

    declared: Declared
    means: tuple[float, float]
    """Mean steps of the policy and of the other over all tasks; an episode that never got there counts its budget."""
    ratio: RatioRow
    """The policy's steps divided by the other's."""
    contrast: Contrast
    """The policy minus the other, in steps, over the tasks that both finished."""
    p: float
    """p-value of the claim's own test, for this comparison alone until it is adjusted."""

    @property
    def verdict(self) -> Verdict:
        """What is shown at 5 %, by :attr:`p`."""
        if self.declared.claim is Claim.AS_GOOD:
            return Verdict.SHOWN if self.p <= 1 - CONFIDENCE else Verdict.OPEN
        found = replace(self.contrast, adjusted_p=self.p, success_p=1.0).finding  # successes are no declared claim
        fewer = {Finding.BETTER: Claim.FEWER, Finding.WORSE: Claim.MORE}.get(found)
        if fewer is None:
            return Verdict.OPEN
        return Verdict.SHOWN if fewer is self.declared.claim else Verdict.OPPOSITE


def compared(declared: Declared, results: Results) -> Tested:
    """Return a comparison from the results of its folder, over the tasks that all policies flew; not yet adjusted."""
    _, scenario, metric, policy, claim, other = declared
    common = results.on_common_tasks
    values = {name: common.values(scenario, name, metric) for name in (other, policy)}
    reached = {name: common.reached(scenario, name, metric) for name in values}
    maps = common.maps(scenario, other)
    contrast = contrasts(values, other, maps=maps, reached=reached, margin=MARGIN)[policy]
    rows = Ratios(common, (other,)).of_scenario(scenario, other, metric)
    ratio = next(row for row in rows if row.policy == policy)
    p = contrast.equivalence_p if claim is Claim.AS_GOOD else contrast.p_value
    return Tested(declared, (float(values[policy].mean()), float(values[other].mean())), ratio, contrast, p)


def adjusted(alone: Sequence[Tested]) -> list[Tested]:
    """Return the comparisons with p-values adjusted for all of them by Holm's method."""
    p_values = holm([each.p for each in alone]).tolist()
    return [replace(each, p=p) for each, p in zip(alone, p_values, strict=True)]


def table(alone: Sequence[Tested]) -> str:
    """Return the table in Markdown of comparisons that are not yet adjusted."""
    lines = [
        "| | scenario | time | claim | mean steps | ratio of the means | difference | p | p (Holm) | verdict |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for number, (each, final) in enumerate(zip(alone, adjusted(alone), strict=True), 1):
        _, scenario, metric, policy, claim, other = each.declared
        cells = [str(number), f"`{scenario}`", metric.upper(), f"`{policy}` {claim} `{other}`"]
        cells.append(" / ".join(fixed(mean, 1) for mean in each.means))
        cells.append(bounded(with_interval(each.ratio.ratio.of_means, 3), each.ratio.censoring.bound))
        cells.append(with_interval(each.contrast.difference, 1, sign=True))
        cells += [f"{each.p:.2g}", f"{final.p:.2g}", final.verdict]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines).replace(MINUS, "-") + "\n"


def main(folder: Path) -> None:
    """Print the table of the results in ``folder``."""
    loaded = {name: Results.load(folder / name) for name in dict.fromkeys(each.folder for each in DECLARED)}
    sys.stdout.write(table([compared(each, loaded[each.folder]) for each in DECLARED]))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

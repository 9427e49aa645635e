"""Definitions of the page's terms, shown at the end of the page and as tooltips."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from indoor_explorers.evaluation.drawing.formatting import percent
from indoor_explorers.evaluation.harness.episodes.metrics import Measure
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from indoor_explorers.evaluation.statistics import CONFIDENCE, FEWEST, RESAMPLES


class Definition(NamedTuple):
    """One term."""

    title: str
    unit: str
    text: str


#: Terms other than metrics.
TERMS = {
    "reached": Definition("reached", "", "share of episodes that reached that coverage within the budget"),
    "failures": Definition(
        "failed episodes",
        "",
        "episodes in which the policy raised an error, returned an invalid action, took too long or too much memory, "
        "or ended its process; what it covered until then counts",
    ),
    "interval": Definition(
        "interval",
        "",
        f"{percent(CONFIDENCE)} percentile bootstrap interval of the mean, in brackets: {RESAMPLES} resamples; maps "
        "are drawn first and then whole episodes on each map drawn, the same for all policies. With fewer than "
        f"{FEWEST} maps, these are fixed and the interval holds for them alone. Fewer than {FEWEST} episodes get none",
    ),
    "band": Definition(
        "band",
        "",
        f"region that holds the whole true mean curve, at all steps at once, with {percent(CONFIDENCE)} confidence "
        "(sup-t bootstrap, Montiel Olea and Plagborg-Møller 2019)",
    ),
    "difference": Definition(
        "difference",
        "steps",
        "mean of one policy's {time} minus the other's over the tasks on which both reached it, with its interval",
    ),
    "better": Definition(
        "P(better)", "", "share of tasks on which the policy needed fewer steps than the other; ties count one half"
    ),
    "holm": Definition(
        "p (adjusted)",
        "",
        "two-sided p-value of the sign-flip test of the paired differences, of all pairs of ranked policies at once "
        "(single-step max-T, Westfall and Young 1993), so that it holds for the policy that came first; those that "
        f"know the map by Holm's method; a difference is significant up to {1 - CONFIDENCE:.2f}",
    ),
    "effect": Definition(
        "effect size",
        "",
        "mean difference in standard deviations of the paired differences (Cohen's d of pairs, Hedges' correction)",
    ),
    "margin": Definition(
        "as good, not resolved",
        "",
        "as good: two one-sided tests show that neither mean is the declared margin above the other (Student's t, Holm "
        "over all pairs); not resolved: neither that nor a difference is shown; beside it the number of maps or tasks "
        "that would show one with 80 % power, if the difference is as seen",
    ),
    "detectable": Definition(
        "detectable",
        "steps",
        "smallest true difference that this many episodes with this spread would detect with 80 % power; "
        "a difference that is not significant may still exist",
    ),
}


def definitions(level: CoverageThreshold | None, measures: Mapping[str, Measure]) -> dict[str, Definition]:
    """Return all definitions by key, ``measures`` first; ``level`` is that of all scenarios, None if they differ."""
    metrics = {
        key: Definition(
            each.title,
            each.unit.replace("us", "µs"),
            f"{each.definition}; {'lower' if each.lower_is_better else 'higher'} is better",
        )
        for key, each in measures.items()
    }
    time = level.title if level else "steps to the threshold of the scenario"
    difference = TERMS["difference"]
    return metrics | TERMS | {"difference": difference._replace(text=difference.text.format(time=time))}

"""The sentences above a scenario: the best policies, their lead, whether that is significant, and who failed."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup, escape

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.failures import failed_of
from indoor_explorers.evaluation.analysis.notes import success_notes
from indoor_explorers.evaluation.analysis.resolution import NAME, fastest, outcomes, resolution, rivals
from indoor_explorers.evaluation.analysis.tables.contrast_table import reading, where_both_finished
from indoor_explorers.evaluation.drawing.formatting import counted, fixed, p_value, percent, with_interval
from indoor_explorers.evaluation.statistics import FEWEST, Contrast


def headline(comparison: Comparison) -> Markup:
    """Return the sentences, names escaped."""
    if not comparison.groups:
        return Markup("No episode of this scenario has been flown yet.")
    first = fastest(comparison)
    if not first:
        parts = [_no_policy(comparison)]
    elif len(comparison.ranked_policies) == 1:
        parts = [_alone(comparison, first[0])]
    else:
        parts = [_winner(comparison, first), _lead(comparison), _others(comparison)]
        parts += map(escape, success_notes(comparison))
    parts += [_failed(comparison, name) for name in comparison.ranked_policies if failed_of(comparison, name)]
    parts += [_unranked(comparison, name) for name in comparison.ranking if name not in comparison.ranked_policies]
    return Markup(" ").join(part for part in parts if part)


def named(policies: Sequence[str]) -> Markup:
    """Return ``a``, ``a and b``, ``a, b and c`` with the names marked."""
    *others, last = map(NAME.format, policies)
    return Markup(", ").join(others) + Markup(" and ") + last if others else last


def _steps(comparison: Comparison, policy: str) -> str:
    return f"{with_interval(comparison.time(policy))} steps"


def _over(comparison: Comparison, policy: str) -> str:
    """Return the number of episodes, and in how many of them the threshold was missed."""
    records = comparison.groups[policy]
    missed = sum(record.metrics.get(comparison.level.key) is None for record in records)
    text = f"over {counted(len(records), 'episode')}"
    if comparison.map_count > 1 and not comparison.over_maps:
        text += f" on these {comparison.map_count} maps"
    if len(records) < FEWEST:
        text += ", too few for an interval"
    if missed:
        text += f" ({missed} of them never reached it and {'count' if missed > 1 else 'counts'} as the whole budget)"
    return text


def _winner(comparison: Comparison, first: Sequence[str]) -> Markup:
    level, names = comparison.level, named(first)
    if len(first) > 1:
        start = Markup("{} share the lowest mean {}:").format(names, level.title)
    else:
        start = Markup("{} reached {} coverage first on average: mean {}").format(names, level.percent, level.title)
    return Markup("{} {} {}.").format(start, _steps(comparison, first[0]), _over(comparison, first[0]))


def _lead(comparison: Comparison) -> Markup:
    """Compare the best with the next one that did not fail."""
    second = next(iter(rivals(comparison)), None)
    if second is None:
        return Markup("")
    if second not in comparison.contrasts:
        text = "Its lead over {} cannot be tested: the two did not fly the same tasks."
        return Markup(text).format(NAME.format(second))
    contrast = comparison.contrasts[second]
    where = where_both_finished(contrast) or f" on the same {counted(contrast.pairs, 'task')}"
    took = f"{with_interval(contrast.difference, sign=True)} steps against {comparison.ranked_policies[0]}{where}"
    return Markup("{} took {}; {}.").format(NAME.format(second), took, verdict(contrast))


def _others(comparison: Comparison) -> Markup:
    """Say what is shown of all policies, where more than one was compared with the best."""
    tested = [name for name in rivals(comparison) if name in comparison.contrasts]
    few = any(comparison.contrasts[name].difference.low is None for name in tested)
    return Markup("") if few or len(tested) < 2 else resolution([outcomes(comparison)], comparison.results.margin)


def _failed(comparison: Comparison, policy: str) -> Markup:
    return Markup("{} failed in {} episodes.").format(NAME.format(policy), failed_of(comparison, policy))


def verdict(contrast: Contrast) -> str:
    """Return the result of a contrast in words; the adjusted p-values decide."""
    if contrast.difference.low is None:
        return "too few episodes for a test"
    p = p_value(contrast.adjusted_p)
    if contrast.shown:
        return f"the difference is significant (adjusted p {p})"
    shown = reading(contrast)
    return f"the difference is not significant (adjusted p {p}){f'; {shown}' if shown else ''}"


def _alone(comparison: Comparison, first: str) -> Markup:
    text = "{} reached {} coverage after {} on average, {}. There is no other policy to compare it with."
    level, steps = comparison.level.percent, _steps(comparison, first)
    return Markup(text).format(NAME.format(first), level, steps, _over(comparison, first))


def _no_policy(comparison: Comparison) -> Markup:
    sound = [name for name in comparison.ranked_policies if not failed_of(comparison, name)]
    final = {
        name: sum(float(record.curve[-1]) for record in comparison.groups[name]) / len(comparison.groups[name])
        for name in sound or comparison.ranked_policies
    }
    best = sorted(name for name in final if final[name] == max(final.values()))
    text = "No policy reached {} coverage within the budget. {} covered most by its end: {} on average, {}."
    episodes = f"over {counted(len(comparison.groups[best[0]]), 'episode')}"
    return Markup(text).format(comparison.level.percent, named(best), percent(final[best[0]], 1), episodes)


def _unranked(comparison: Comparison, policy: str) -> Markup:
    why = "is given the true map" if comparison.privileged(policy) else "failed a check and is not ranked"
    steps = fixed(comparison.time(policy).mean, 1)
    return Markup("{}, which {}, took {} steps.").format(NAME.format(policy), why, steps)

"""The sentences above a scenario: the best policy, its lead, and whether that is significant."""

from __future__ import annotations

from markupsafe import Markup, escape

from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.style.formatting import counted, fixed, p_value, percent, with_interval
from indoor_explorers.evaluation.report.summary.notes import success_notes
from indoor_explorers.evaluation.report.tables.contrast_table import reading, where_both_finished
from indoor_explorers.evaluation.statistics import FEWEST, Contrast

NAME = Markup("<b>{}</b>")


def headline(comparison: Comparison) -> Markup:
    """Return the sentences, names escaped."""
    if not comparison.groups:
        return Markup("No episode of this scenario has been flown yet.")
    first = comparison.ranked_policies[0]
    if not any(comparison.reached(name) for name in comparison.ranked_policies):
        parts = [_no_policy(comparison)]
    elif len(comparison.ranked_policies) == 1:
        parts = [_alone(comparison, first)]
    else:
        parts = [_winner(comparison, first), _lead(comparison, first), *map(escape, success_notes(comparison))]
    others = [name for name in comparison.ranking if not comparison.ranked(name) and name != first]
    return Markup(" ").join(part for part in (*parts, *(_unranked(comparison, name) for name in others)) if part)


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


def _winner(comparison: Comparison, first: str) -> Markup:
    level = comparison.level
    mean = comparison.time(first).mean
    second = comparison.ranked_policies[1]
    if mean == comparison.time(second).mean:
        text = f"{{}} and {{}} share the lowest mean {level.title}: {{}} {{}}."
        return Markup(text).format(
            NAME.format(first), NAME.format(second), _steps(comparison, first), _over(comparison, first)
        )
    text = f"{{}} reached {level.percent} coverage first on average: mean {level.title} {{}} {{}}."
    return Markup(text).format(NAME.format(first), _steps(comparison, first), _over(comparison, first))


def _lead(comparison: Comparison, first: str) -> Markup:
    second = comparison.ranked_policies[1]
    if second not in comparison.contrasts:
        text = "Its lead over {} cannot be tested: the two did not fly the same tasks."
        return Markup(text).format(NAME.format(second))
    contrast = comparison.contrasts[second]
    where = where_both_finished(contrast) or f" on the same {counted(contrast.pairs, 'task')}"
    took = f"{with_interval(contrast.difference, sign=True)} steps against {first}{where}"
    return Markup("{} took {}; {}.").format(NAME.format(second), took, verdict(contrast))


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
    final = {
        name: sum(float(record.curve[-1]) for record in comparison.groups[name]) / len(comparison.groups[name])
        for name in comparison.ranked_policies
    }
    best = max(final, key=lambda name: final[name])
    text = "No policy reached {} coverage within the budget. {} covered most by its end: {} on average, {}."
    episodes = f"over {counted(len(comparison.groups[best]), 'episode')}"
    return Markup(text).format(comparison.level.percent, NAME.format(best), percent(final[best], 1), episodes)


def _unranked(comparison: Comparison, policy: str) -> Markup:
    why = "is given the true map" if comparison.privileged(policy) else "failed a check and is not ranked"
    steps = fixed(comparison.time(policy).mean, 1)
    return Markup("{}, which {}, took {} steps.").format(NAME.format(policy), why, steps)

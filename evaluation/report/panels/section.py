"""The panels of one scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from markupsafe import Markup

from indoor_explorers.evaluation.report.comparison import Comparison
from indoor_explorers.evaluation.report.panels.causes import Cause, causes
from indoor_explorers.evaluation.report.panels.outcomes import Outcomes
from indoor_explorers.evaluation.report.panels.pareto import pareto_plot
from indoor_explorers.evaluation.report.panels.plots import Plot
from indoor_explorers.evaluation.report.panels.profiles import profile_plot
from indoor_explorers.evaluation.report.panels.rank_plot import Chance, Rung, ladder
from indoor_explorers.evaluation.report.panels.ranks import Ranks, ranks
from indoor_explorers.evaluation.report.panels.wins import Duel, win_matrix
from indoor_explorers.evaluation.report.style.palette import Style
from indoor_explorers.evaluation.report.tables.columns import troubles


@dataclass(frozen=True)
class Step:
    """A rung of the ladder with its drawings."""

    rung: Rung
    next_strip: Markup | None
    best_strip: Markup | None


@dataclass(frozen=True)
class SectionPanels:
    """What the template shows; a panel without content is None or empty and is left out."""

    duels: list[tuple[str, list[Duel | None]]]
    ranks: Ranks | None
    ladder: list[Step]
    pareto: Plot | None
    profile: Plot | None
    tasks: int
    """Tasks that all contestants flew."""
    episodes: str
    """Episodes a policy."""
    causes: list[Cause]


def section_panels(comparison: Comparison, looks: Mapping[str, Style]) -> SectionPanels:
    """Gather the panels of a scenario."""
    outcomes = Outcomes.of(comparison)
    counts = sorted({len(records) for records in comparison.groups.values()})
    return SectionPanels(
        duels=win_matrix(outcomes),
        ranks=ranks(comparison, outcomes),
        ladder=[_step(rung, looks) for rung in ladder(outcomes)],
        pareto=pareto_plot(comparison, looks),
        profile=profile_plot(outcomes, looks),
        tasks=len(outcomes.common().tasks),
        episodes=" to ".join(str(count) for count in (counts[:1] + counts[-1:] if len(counts) > 1 else counts)),
        causes=causes(troubles(comparison), {policy: len(group) for policy, group in comparison.groups.items()}),
    )


def _step(rung: Rung, looks: Mapping[str, Style]) -> Step:
    def strip(chance: Chance | None) -> Markup | None:
        return chance.strip(looks[chance.policy]) if chance is not None else None

    return Step(rung, strip(rung.next), strip(rung.best))

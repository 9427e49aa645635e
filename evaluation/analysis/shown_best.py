"""Which policies are shown to be the best in a metric: those printed in bold."""

from __future__ import annotations

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.task_times import TaskTimes
from indoor_explorers.evaluation.statistics import CONFIDENCE, all_pairs_test

#: What bold means in every table of results.
BOLD = (
    "Bold: significantly better than every other policy "
    f"(sign-flip test of all pairs at once, p at most {1 - CONFIDENCE:.2f}; times where both finish)."
)


def shown_best(comparison: Comparison, metric: str, *, lower_is_better: bool = True) -> list[str]:
    """Return the policies whose metric is significantly better than every other's on the tasks that all flew.

    That is one policy, or several with the same values on every task, which count as one; mostly there is none.
    Policies that know the map are not ranked. See :meth:`~indoor_explorers.evaluation.statistics.AllPairs.better`.
    """
    common = TaskTimes.of(comparison, metric).common()
    if len(common.policies) < 2 or not common.tasks:
        return []
    better = all_pairs_test(common.times, common.maps, common.reached).better(lower_is_better=lower_is_better)
    best = int(better.sum(axis=1).argmax())
    same = (common.times == common.times[:, [best]]).all(axis=0)
    if same.all() or not better[best, ~same].all():
        return []
    return [name for name, is_best in zip(common.policies, same.tolist(), strict=True) if is_best]

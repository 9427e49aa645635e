"""The paired sequential test that drops a trial early, as a pruner of Optuna.

A trial flies the same episodes in the same order as the best trial so far. It is looked at after 8, 16, 32, ...
episodes. At each look the sign-flip test (Fisher 1935) of the paired differences asks whether the trial is worse; its
one-sided level is the total level divided by the number of looks, which is an error-spending function of a group
sequential test (Lan & DeMets 1983, Biometrika 70:659, doi:10.1093/biomet/70.3.659) that holds, by Bonferroni's
inequality, however the looks depend on each other. So a trial that is as good as the one it is compared with is dropped
with a probability of at most :data:`LEVEL` in all, exactly so where differences are symmetric around 0 and their units
independent. The best so far was itself selected on these episodes, which flatters it: of many equal trials more are
dropped.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from optuna.pruners import BasePruner
from optuna.study import Study, StudyDirection
from optuna.trial import FrozenTrial

from indoor_explorers.evaluation.statistics import sign_flip_test

#: Probability of dropping a trial that is as good as the best, over all looks together.
LEVEL = 0.05
#: Episodes before the first look; with each further one there are twice as many.
FIRST_LOOK = 8
#: The attribute of a trial that has its (E,) values by episode.
VALUES = "values"


def looks(episodes: int) -> list[int]:
    """Return after how many of the episodes of a trial it is looked at, the last one left out."""
    found: list[int] = []
    while (count := FIRST_LOOK * 2 ** len(found)) < episodes:
        found.append(count)
    return found


def is_worse(apart: NDArray[np.float64], maps: Sequence[str], level: float) -> bool:
    """Return whether (E,) differences to the best, positive where the trial is worse, show that it is worse.

    Args:
        apart: the differences.
        maps: (E,) the map of each episode, which count as units where they are a sample.
        level: the one-sided level.

    """
    return bool(apart.sum() > 0) and sign_flip_test(apart, np.asarray(maps)) / 2 <= level


class PairedTest(BasePruner):
    """Drop a trial when the test shows that it is worse than the best one that was flown to the end.

    Each trial has the values of its episodes so far in the attribute :data:`VALUES`.
    """

    def __init__(self, maps: Sequence[str], level: float = LEVEL) -> None:
        """Take the map of each of the E episodes in their order, and the level of all looks together."""
        self._maps, self._level = maps, level

    def prune(self, study: Study, trial: FrozenTrial) -> bool:
        """Return whether to drop a trial now."""
        own = np.asarray(trial.user_attrs[VALUES])
        best = np.asarray(study.best_trial.user_attrs[VALUES])
        sign = 1.0 if study.direction is StudyDirection.MINIMIZE else -1.0
        apart = sign * (own - best[: len(own)])
        return is_worse(apart, self._maps[: len(own)], self._level / max(1, len(looks(len(best)))))

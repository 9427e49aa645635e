"""The errors of a scenario's sensors and poses, as the world calls them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.simulation.engine import Engine
from indoor_explorers.env.simulation.slam.state import Slam, error_rules_of
from indoor_explorers.env.simulation.slam.step import advance_uncertain, begin_uncertain
from indoor_explorers.env.simulation.state import State


class UncertainModel:
    """Scans, estimated poses and maps of log-odds of a batch of episodes."""

    def __init__(self, scenario: Scenario, slam: Slam) -> None:
        self.rules = error_rules_of(scenario)
        self.slam = slam

    def begin(self, engine: Engine, state: State, episodes: Sequence[int], seeds: Sequence[int]) -> None:
        """Make the first scans and contacts of episodes that have just begun."""
        begun = np.array(episodes, np.int64), np.array(seeds, np.int64)
        begin_uncertain(engine, self.rules, self.slam, *begun)

    def advance(self, engine: Engine, state: State, actions: NDArray[np.int64], first: int, last: int) -> None:
        """Advance episodes first to last - 1 by one step with actions (B, N), as ``advance`` of exact worlds does."""
        advance_uncertain(engine, self.rules, self.slam, actions, first, last)

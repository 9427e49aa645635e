"""RLlib's environment of a team in training, whose episodes are kept apart from all others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv

from indoor_explorers.env.interfaces.pettingzoo_env import TeamEnv
from indoor_explorers.env.observations import Observation
from indoor_explorers.env.observations.base import Arrays
from indoor_explorers.env.scenarios.scenario import Scenario


class TrainingTeam(TeamEnv):
    """A team, or one UAV, whose episodes have the seeds of the training, whatever seeds RLlib resets with."""

    def __init__(self, scenario: Scenario, observation: Observation, seeds: Iterator[int]) -> None:
        super().__init__(scenario, observation, None, None, 0)
        self._seeds = seeds

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Arrays], dict[str, dict[str, Any]]]:
        """Start the next episode of the training."""
        return super().reset(next(self._seeds), options)


def rllib_team(scenario: Scenario, observation: Observation, seeds: Iterator[int]) -> ParallelPettingZooEnv:
    """Return the environment as RLlib wants it."""
    return ParallelPettingZooEnv(TrainingTeam(scenario, observation, seeds))

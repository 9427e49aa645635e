"""Hyperparameters that all baselines share: observation, network, rewards, evaluation."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from indoor_explorers.env.observations import Egocentric, Flat
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions.settings import LearnerSettings

#: The observation whose length does not depend on the map.
EGOCENTRIC = "egocentric"


class BaselineConfig(LearnerSettings):
    """Describe one training completely, together with its scenario and seed."""

    total_steps: int = Field(1_000_000, ge=1)
    """Moves made in training, all UAVs of all environments together; the last rollout may exceed it a little."""
    environments: int = Field(32, ge=1, le=4096)
    """Episodes flown in parallel."""
    observation: str = Field(EGOCENTRIC, min_length=1)
    """``egocentric``, or another name of :mod:`indoor_explorers.env.observations`, whose length depends on the map."""
    side: int = Field(15, ge=1)
    """Cells along a side of the egocentric crop; odd."""
    zones: int = Field(8, ge=1)
    """Zones along a side of the egocentric coarse map."""
    hidden: tuple[int, ...] = Field((256, 256), min_length=1)
    """Units of the network's hidden layers."""
    learning_rate: float = Field(3e-4, gt=0.0)
    """Step size of the optimiser."""
    gamma: float = Field(0.99, gt=0.0, le=1.0)
    """Discount factor per step."""
    goal: float = Field(0.99, gt=0.0, le=1.0)
    """Share of the reachable cells whose coverage ends a training episode."""
    reward_step: float = -0.1
    """Reward for each step."""
    reward_discovered: float = 0.1
    """Reward for each cell that the UAV's own lidar discovers."""
    reward_blocked: float = -0.1
    """Reward for a move into a wall or off the map, after which the UAV stays in place; unused with an action mask."""
    reward_goal: float = 1.0
    """Reward for reaching the goal."""
    evaluation_every: int = Field(100_000, ge=1)
    """Moves between two evaluations."""
    evaluation_episodes: int = Field(100, ge=1, le=100_000)
    """Episodes of one evaluation: greedy among the legal moves, on maps that neither training nor comparisons use."""
    checkpoint_every: int = Field(250_000, ge=1)
    """Moves between two checkpoints."""

    @model_validator(mode="after")
    def _can_be_observed(self) -> Self:
        Egocentric(side=self.side, zones=self.zones)
        return self

    @property
    def recipe(self) -> Flat:
        """The network's observation, one vector."""
        if self.observation == EGOCENTRIC:
            return Flat(Egocentric(side=self.side, zones=self.zones))
        return Flat(self.observation)

    def task(self, scenario: Scenario) -> Scenario:
        """Return a scenario with the training's goal, ``goal`` of the reachable cells, and its rewards."""
        return scenario.for_evaluation().with_settings(
            {
                "goal": self.goal,
                "on_collision": "block",
                "rewards.step": self.reward_step,
                "rewards.discovered": self.reward_discovered,
                "rewards.received": 0.0,
                "rewards.collision": self.reward_blocked,
                "rewards.out_of_bounds": self.reward_blocked,
                "rewards.goal": self.reward_goal,
            }
        )


class ActorCriticSettings(BaselineConfig):
    """Hyperparameters that A2C and PPO share in all libraries."""

    gae_lambda: float = Field(0.95, ge=0.0, le=1.0)
    """Lambda of generalised advantage estimation (Schulman et al. 2016, arXiv:1506.02438)."""
    entropy: float = Field(0.01, ge=0.0)
    """Weight of the entropy bonus in the loss."""
    value_weight: float = Field(0.5, ge=0.0)
    """Weight of the value error in the loss."""
    gradient_clip: float = Field(0.5, gt=0.0)
    """Largest Euclidean norm of a gradient; a longer one is scaled down to it."""


class PPOSettings(ActorCriticSettings):
    """Hyperparameters that PPO has in all libraries."""

    batch: int = Field(512, ge=2)
    """Moves in one minibatch."""
    epochs: int = Field(4, ge=1)
    """Passes over the moves of each rollout."""
    clip: float = Field(0.2, gt=0.0)
    """Clip range of the probability ratio: it is clipped to 1 - clip .. 1 + clip."""

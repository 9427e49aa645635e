"""Every hyperparameter of the DDDQN's training; the defaults made the weights that ship."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from indoor_explorers.env.scenario import Scenario


class TrainingConfig(BaseModel):
    """Describe one training completely, together with its scenario and seed."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)

    total_steps: int = Field(2_800_000, ge=1)
    """Moves made in training, all environments together."""
    environments: int = Field(64, ge=1, le=4096)
    """Episodes flown side by side; one update of the network follows each tick of all of them."""
    updates_per_tick: int = Field(1, ge=1, le=64)
    """Updates of the network after each tick."""
    warmup_steps: int = Field(6_400, ge=0)
    """Moves made before the first update."""
    batch: int = Field(256, ge=1)
    """Transitions in one update."""
    replay_steps: int = Field(192_000, ge=1)
    """Latest moves kept for replay."""
    return_steps: int = Field(5, ge=1, le=100)
    """Rewards summed before the network's own estimate takes over; fewer before an exploratory move."""
    gamma_first: float = Field(0.97, gt=0.0, le=1.0)
    """Discount a step at the beginning."""
    gamma_last: float = Field(0.998, gt=0.0, le=1.0)
    """Discount a step after ``gamma_share`` of the training; what lies far ahead decides about pockets left behind."""
    gamma_share: float = Field(0.4, gt=0.0, le=1.0)
    """Share of the training over which the discount rises."""
    epsilon_first: float = Field(0.25, ge=0.0, le=1.0)
    """Probability of a random legal move at the beginning."""
    epsilon_last: float = Field(0.01, ge=0.0, le=1.0)
    """The same after ``epsilon_share`` of the training."""
    epsilon_share: float = Field(0.35, gt=0.0, le=1.0)
    """Share of the training over which exploration falls."""
    learning_rate: float = Field(5e-4, gt=0.0)
    """Adam's step size at the beginning; it falls linearly."""
    learning_rate_last: float = Field(0.05, gt=0.0, le=1.0)
    """Share of the step size that is left at the end."""
    gradient_clip: float = Field(10.0, gt=0.0)
    """Longest gradient, as a Euclidean norm, that is followed unshortened."""
    target_rate: float = Field(0.005, gt=0.0, le=1.0)
    """Share of the way that the target network moves to the online one after each update."""
    average_rate: float = Field(0.001, gt=0.0, le=1.0)
    """The same for the averaged weights, which are evaluated and shipped."""
    goal: float = Field(0.99, gt=0.0, le=1.0)
    """Share of the reachable cells that ends a training episode."""
    reward_step: float = -0.1
    """Paid for each step."""
    reward_discovered: float = 0.1
    """Paid for each cell that the UAV's own lidar discovers."""
    reward_goal: float = 1.0
    """Paid for reaching the goal."""
    evaluation_every: int = Field(96_000, ge=1)
    """Moves between two evaluations."""
    evaluation_episodes: int = Field(200, ge=1, le=100_000)
    """Episodes of one evaluation: greedy, without the guard, on maps kept apart from training."""
    checkpoint_every: int = Field(384_000, ge=1)
    """Moves between two checkpoints."""

    def task(self, scenario: Scenario) -> Scenario:
        """Return the scenario as it is trained on: to ``goal`` of the reachable cells, with these rewards."""
        return scenario.for_evaluation().with_settings(
            {
                "goal": self.goal,
                "on_collision": "block",
                "rewards.step": self.reward_step,
                "rewards.discovered": self.reward_discovered,
                "rewards.received": 0.0,
                "rewards.goal": self.reward_goal,
            }
        )

    def epsilon(self, share: float) -> float:
        """Return the exploration after a ``share`` of the training."""
        return _ramp(self.epsilon_first, self.epsilon_last, share / self.epsilon_share)

    def gamma(self, share: float) -> float:
        """Return the discount after a ``share`` of the training."""
        return _ramp(self.gamma_first, self.gamma_last, share / self.gamma_share)

    def rate(self, share: float) -> float:
        """Return the step size after a ``share`` of the training."""
        return self.learning_rate * _ramp(1.0, self.learning_rate_last, share)


def _ramp(first: float, last: float, share: float) -> float:
    return first + (last - first) * min(share, 1.0)

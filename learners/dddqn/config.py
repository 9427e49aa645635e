"""The hyperparameters of a DDDQN's training; observation and network have configurations of their own."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.encoding import encoded_size
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import observation_layout
from indoor_explorers.learners.dddqn.observation.scales import REFERENCE_RANGE, sensor
from indoor_explorers.learners.sessions.settings import LearnerSettings


class TrainingConfig(LearnerSettings):
    """Describe one training completely, together with its scenario and seed."""

    observation: ObservationConfig = ObservationConfig()
    """The network's input."""
    network: NetworkConfig = NetworkConfig()
    """The network's shape."""
    also: tuple[str, ...] = ()
    """Further scenarios that the same network is trained on at the same time: presets or ``.toml`` files."""
    map_count: int = Field(0, ge=0)
    """Different maps (with their starts) in the training, flown in turn; 0: each episode draws a new one."""
    team: int | None = Field(None, ge=1)
    """UAVs in each training episode; None: as in the scenarios. The rewards of a single UAV are less noisy, and the
    network still works in teams if planner features leave cells to the teammates that are closer to them."""
    prior_notes: int = Field(1_000_000, ge=0)
    """Largest number of unknown cells near obstacles that the map prior is fitted to before the training."""
    total_steps: int = Field(3_000_000, ge=1)
    """Moves made in training, all environments together."""
    environments: int = Field(64, ge=1, le=4096)
    """Episodes flown in parallel, divided evenly among the scenarios; each of several scenarios gets at least four. A
    tick is one step of all of them."""
    updates_per_tick: int = Field(1, ge=1, le=64)
    """Updates of the network in each tick."""
    warmup_steps: int = Field(6_400, ge=0)
    """Moves made before the first update."""
    batch: int = Field(256, ge=1)
    """Transitions in one update."""
    replay_steps: int = Field(192_000, ge=1)
    """Size of the replay buffer in moves."""
    return_steps: int = Field(5, ge=1, le=100)
    """Steps of the n-step return; it is cut before an exploratory move."""
    double: bool = True
    """Double Q-learning: the online network selects the next move, the target network evaluates it (van Hasselt et
    al. 2016)."""
    action_gap: float = Field(0.0, ge=0.0, lt=1.0)
    """Advantage learning, alpha (Bellemare et al. 2016): share of the gap between a move's value and the best move's
    that is subtracted from the move's target. Larger gaps make decisions less sensitive to errors of the network."""
    prioritised: float = Field(0.0, ge=0.0, le=1.0)
    """Prioritised replay, alpha (Schaul et al. 2016): exponent of the TD error in the priority; 0 is uniform replay."""
    importance: float = Field(0.4, ge=0.0, le=1.0)
    """Initial exponent of the importance-sampling weights, beta; it rises to 1 at the end of the training."""
    symmetries: bool = True
    """Rotate and mirror each sampled transition at random."""
    mask: bool = True
    """Choose among legal moves only; if False, a move into a wall costs a step, and the network learns to avoid it."""
    gamma_first: float = Field(0.97, gt=0.0, le=1.0)
    """Initial discount factor per step."""
    gamma_last: float = Field(0.999, gt=0.0, le=1.0)
    """Discount factor from ``gamma_share`` of the training on; a high one makes it worthwhile not to leave small
    unknown pockets behind."""
    gamma_share: float = Field(0.5, gt=0.0, le=1.0)
    """Share of the training over which the discount factor rises linearly."""
    epsilon_first: float = Field(0.25, ge=0.0, le=1.0)
    """Initial probability of a random move."""
    epsilon_last: float = Field(0.01, ge=0.0, le=1.0)
    """Probability of a random move from ``epsilon_share`` of the training on."""
    epsilon_share: float = Field(0.35, gt=0.0, le=1.0)
    """Share of the training over which that probability falls linearly."""
    learning_rate: float = Field(5e-4, gt=0.0)
    """Adam's initial step size; it falls linearly over the training."""
    learning_rate_last: float = Field(0.05, gt=0.0, le=1.0)
    """Final step size as a share of the initial one."""
    gradient_clip: float = Field(10.0, gt=0.0)
    """Largest Euclidean norm of a gradient; a longer one is scaled down to it."""
    target: Literal["soft", "hard"] = "soft"
    """Updates of the target network: a soft one after each update of the online network, or a copy now and then."""
    target_rate: float = Field(0.005, gt=0.0, le=1.0)
    """Rate tau of the soft target updates."""
    target_every: int = Field(500, ge=1)
    """Updates of the online network between two copies to a hard target."""
    average_rate: float = Field(0.001, gt=0.0, le=1.0)
    """Rate of the moving average of the weights, which is evaluated and shipped."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Device that the network learns on; "auto" takes a GPU if there is one."""
    precision: Literal["auto", "full", "mixed"] = "auto"
    """Mixed precision multiplies matrices in bfloat16; "auto" uses it if the processor has instructions for it."""
    goal: float = Field(0.99, gt=0.0, le=1.0)
    """Share of the reachable cells whose coverage ends a training episode."""
    reward_step: float = -0.1
    """Reward for each step."""
    reward_early_step: float = -0.1
    """Additional reward for each step until 90 % of the reachable cells are known."""
    reward_discovered: float = 0.1
    """Reward for each cell that the UAV's own lidar discovers."""
    reward_goal: float = 1.0
    """Reward for reaching the goal."""
    scale_rewards: bool = False
    """Scale the rewards by the lidar: those of steps by 3 / range, those of cells by the number of cells in range 3
    over that in the lidar's range. Maps of the same size in lidar ranges then give similar returns; at range 3 nothing
    changes."""
    evaluation_every: int = Field(192_000, ge=1)
    """Moves between two evaluations."""
    evaluation_episodes: int = Field(200, ge=1, le=100_000)
    """Episodes of one evaluation on each scenario: greedy, without the guard, on maps that training does not use."""
    checkpoint_every: int = Field(384_000, ge=1)
    """Moves between two checkpoints."""

    @model_validator(mode="after")
    def _fits(self) -> TrainingConfig:
        encoded_size(observation_layout(self.observation), self.network)
        return self

    def task(self, scenario: Scenario) -> Scenario:
        """Return a scenario with the training's goal, ``goal`` of the reachable cells, and its rewards."""
        area = sensor(REFERENCE_RANGE).disc / sensor(scenario.lidar.range).disc if self.scale_rewards else 1.0
        return scenario.for_evaluation().with_settings(
            {
                "goal": self.goal,
                "on_collision": "block",
                "rewards.step": self.reward_step * self._pace(scenario),
                "rewards.discovered": self.reward_discovered * area,
                "rewards.received": 0.0,
                "rewards.goal": self.reward_goal,
            }
            | ({} if self.team is None else {"team": self.team})
        )

    def tasks(self, scenario: Scenario) -> list[Scenario]:
        """Return all training scenarios: this one and ``also``, with the training's goal and rewards.

        Raises :class:`InputError` if one of ``also`` is neither a preset nor a scenario file.
        """
        return [self.task(each) for each in (scenario, *map(named_scenario, self.also))]

    def early_step(self, scenario: Scenario) -> float:
        """Return the additional reward for each step of a scenario until 90 % of the reachable cells are known."""
        return self.reward_early_step * self._pace(scenario)

    def _pace(self, scenario: Scenario) -> float:
        """Return the factor on the rewards of a scenario's steps."""
        return sensor(scenario.lidar.range).rate if self.scale_rewards else 1.0

    def epsilon(self, share: float) -> float:
        """Return the probability of a random move after a ``share`` of the training."""
        return _ramp(self.epsilon_first, self.epsilon_last, share / self.epsilon_share)

    def gamma(self, share: float) -> float:
        """Return the discount factor after a ``share`` of the training."""
        return _ramp(self.gamma_first, self.gamma_last, share / self.gamma_share)

    def rate(self, share: float) -> float:
        """Return Adam's step size after a ``share`` of the training."""
        return self.learning_rate * _ramp(1.0, self.learning_rate_last, share)

    def beta(self, share: float) -> float:
        """Return the exponent of the importance-sampling weights after a ``share`` of the training."""
        return _ramp(self.importance, 1.0, share)


def _ramp(first: float, last: float, share: float) -> float:
    return first + (last - first) * min(share, 1.0)

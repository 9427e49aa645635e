"""Every hyperparameter of a DDDQN's training; what it sees and its network have configurations of their own."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.scales import REFERENCE_RANGE, sensor
from indoor_explorers.learners.sessions.settings import LearnerSettings


class TrainingConfig(LearnerSettings):
    """Describe one training completely, together with its scenario and seed."""

    observation: ObservationConfig = ObservationConfig()
    """What the network sees."""
    network: NetworkConfig = NetworkConfig()
    """The network."""
    also: tuple[str, ...] = ()
    """Further scenarios trained on side by side with the first by the same network: presets or ``.toml`` files."""
    team: int | None = Field(None, ge=1)
    """UAVs of each training episode; None for as many as the scenarios have. What a UAV learns alone is learned from
    clearer rewards, and serves teams where planner features leave to teammates what is theirs."""
    prior_notes: int = Field(1_000_000, ge=0)
    """Largest number of unknown cells near obstacles that the map prior is fitted to before the training."""
    total_steps: int = Field(3_000_000, ge=1)
    """Moves made in training, all environments together."""
    environments: int = Field(64, ge=1, le=4096)
    """Episodes flown side by side, shared out among the scenarios, at least four for each of several; the updates of
    the network follow each tick of all of them."""
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
    double: bool = True
    """Let the online network choose the move that the target network values (van Hasselt et al. 2016)."""
    action_gap: float = Field(0.0, ge=0.0, lt=1.0)
    """Share of the distance to the best move's value that is taken off the target of each other move (advantage
    learning, Bellemare et al. 2016, alpha): errors of the network then change fewer decisions. 0 takes off nothing."""
    prioritised: float = Field(0.0, ge=0.0, le=1.0)
    """Exponent of the error in the chance to be replayed (Schaul et al. 2016, alpha); 0 replays uniformly."""
    importance: float = Field(0.4, ge=0.0, le=1.0)
    """How far prioritised replay is corrected by importance sampling at first (beta); all the way at the end."""
    symmetries: bool = True
    """Turn and mirror each sampled transition at random."""
    mask: bool = True
    """Choose among legal moves alone; without, a move into a wall costs a step and is learned from."""
    gamma_first: float = Field(0.97, gt=0.0, le=1.0)
    """Discount a step at the beginning."""
    gamma_last: float = Field(0.999, gt=0.0, le=1.0)
    """Discount a step after ``gamma_share`` of the training; what lies far ahead decides about pockets left behind."""
    gamma_share: float = Field(0.5, gt=0.0, le=1.0)
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
    target: Literal["soft", "hard"] = "soft"
    """How the target network follows: a little after each update, or all the way now and then."""
    target_rate: float = Field(0.005, gt=0.0, le=1.0)
    """Share of the way that a soft target moves to the online network after each update."""
    target_every: int = Field(500, ge=1)
    """Updates between two copies of the online network to a hard target."""
    average_rate: float = Field(0.001, gt=0.0, le=1.0)
    """The same as ``target_rate`` for the averaged weights, which are evaluated and shipped."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where the network learns; "auto" takes a GPU where there is one."""
    precision: Literal["auto", "full", "mixed"] = "auto"
    """Mixed precision computes matrices in bfloat16; "auto" does where the processor has instructions for it."""
    goal: float = Field(0.99, gt=0.0, le=1.0)
    """Share of the reachable cells that ends a training episode."""
    reward_step: float = -0.1
    """Paid for each step."""
    reward_early_step: float = -0.1
    """Paid on top of it for each step until 90 % of the reachable cells are known."""
    reward_discovered: float = 0.1
    """Paid for each cell that the UAV's own lidar discovers."""
    reward_goal: float = 1.0
    """Paid for reaching the goal."""
    scale_rewards: bool = False
    """Pay by the lidar: steps in proportion to 3 / range, and cells to the cells of a disc of range 3 over those in
    range. So a map that is as many lidar ranges across is worth as much with any lidar; at range 3 nothing changes."""
    evaluation_every: int = Field(192_000, ge=1)
    """Moves between two evaluations."""
    evaluation_episodes: int = Field(200, ge=1, le=100_000)
    """Episodes of one evaluation on each scenario: greedy, without the guard, on maps kept apart from training."""
    checkpoint_every: int = Field(384_000, ge=1)
    """Moves between two checkpoints."""

    def task(self, scenario: Scenario) -> Scenario:
        """Return the scenario as it is trained on: to ``goal`` of the reachable cells, with these rewards."""
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
        """Return all scenarios as they are trained on: this one, then ``also``.

        Raises:
            InputError: one of them is no preset and no scenario file.

        """
        return [self.task(each) for each in (scenario, *map(named_scenario, self.also))]

    def early_step(self, scenario: Scenario) -> float:
        """Return what is paid on top for each step of a scenario until 90 % of the reachable cells are known."""
        return self.reward_early_step * self._pace(scenario)

    def _pace(self, scenario: Scenario) -> float:
        """Return what a step of a scenario counts."""
        return sensor(scenario.lidar.range).rate if self.scale_rewards else 1.0

    def epsilon(self, share: float) -> float:
        """Return the exploration after a ``share`` of the training."""
        return _ramp(self.epsilon_first, self.epsilon_last, share / self.epsilon_share)

    def gamma(self, share: float) -> float:
        """Return the discount after a ``share`` of the training."""
        return _ramp(self.gamma_first, self.gamma_last, share / self.gamma_share)

    def rate(self, share: float) -> float:
        """Return the step size after a ``share`` of the training."""
        return self.learning_rate * _ramp(1.0, self.learning_rate_last, share)

    def beta(self, share: float) -> float:
        """Return how far prioritised replay is corrected after a ``share`` of the training."""
        return _ramp(self.importance, 1.0, share)


def _ramp(first: float, last: float, share: float) -> float:
    return first + (last - first) * min(share, 1.0)

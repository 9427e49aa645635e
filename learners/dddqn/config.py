"""Every switch and hyperparameter of the DDDQN; the defaults made the weights that ship."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.observation.scales import REFERENCE_RANGE, sensor

#: Layers that the fine map may have, in the order in which they are written.
Layer = Literal["unknown", "free", "chance", "visits", "frontier", "distance", "mates", "mates_past"]
LAYERS: tuple[Layer, ...] = ("unknown", "free", "chance", "visits", "frontier", "distance", "mates", "mates_past")
#: States that the search for tours may keep at each step.
WIDEST = 1024


class _Config(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


class ObservationConfig(_Config):
    """What the network sees of one UAV's belief; see :mod:`indoor_explorers.learners.dddqn.observation.observe`."""

    crop: int = Field(15, ge=3, le=63)
    """Pixels a side of the fine map around the UAV, odd."""
    layers: tuple[Layer, ...] = ("unknown", "free", "chance")
    """What the fine map shows: ``unknown`` and known ``free`` cells, the ``chance`` of unknown cells to count by the
    learned map prior, ``visits`` since the last gain, ``frontier`` cells, ``distance`` by known free cells to the
    nearest of them, ``mates`` heard in this step and ``mates_past``, fading with the age of the news."""
    coarse: int = Field(11, ge=0, le=31)
    """Blocks a side of the coarse map around the UAV, each 3x3 pixels, odd; 0 leaves it out."""
    sides: bool = True
    """The unknown cells below, left of, above and right of the UAV."""
    identity: bool = False
    """Which UAV this is, one of eight, so that linked UAVs with the same map may act apart (Terry et al. 2020)."""
    progress: bool = False
    """Known share of the map, share of the steps flown and steps since the last gain."""
    frames: int = Field(1, ge=1, le=8)
    """Latest scenes shown together, the frame stack of Mnih et al. 2015."""
    visits: bool = True
    """For each move: visits of the next cell since the last gain."""
    gains: bool = True
    """For each move, as planners see it: the view gain there, and distance and discounted gains of what lies ahead."""
    tours: bool = True
    """For each move: the tours that a small beam search finds behind it, in rooms of up to 16x16 cells."""
    tour_width: int = Field(8, ge=1, le=WIDEST)
    """States that this search keeps at each step: the more, the shorter its tours and the slower each decision."""
    prospects: bool = False
    """For each move: how far it is from the best place to look from, on maps of any size, by what is in view there and
    the way to it; once by all that is in view and once with isolated cells counting more."""

    @field_validator("crop", "coarse")
    @classmethod
    def _odd(cls, value: int) -> int:
        if value and value % 2 == 0:
            raise ValueError("expected an odd number, so that the UAV is in the middle")
        return value

    @field_validator("layers")
    @classmethod
    def _in_order(cls, value: tuple[Layer, ...]) -> tuple[Layer, ...]:
        if not value:
            raise ValueError("expected at least one layer")
        return tuple(layer for layer in LAYERS if layer in value)


class NetworkConfig(_Config):
    """The network's shape; see :mod:`indoor_explorers.learners.dddqn.network.model`."""

    width: int = Field(256, ge=8, le=4096)
    """Units of both hidden layers."""
    move_width: int = Field(16, ge=1, le=256)
    """Hidden units of the small net that all moves share."""
    layer_norm: bool = True
    """Normalise both hidden layers (Ba et al. 2016)."""
    dueling: bool = True
    """Q = V + A - mean A (Wang et al. 2016); without, the last layer gives Q itself."""
    noisy: bool = False
    """Explore by noise in the weights of the last layers (Fortunato et al. 2018) on top of epsilon."""
    tour_cost: float = Field(0.1, ge=0.0)
    """Begin with what the tours say, where they are seen: each step that a move's tour takes beyond the shortest, to
    the goal and to 90 %, costs so much at first. So do prospects for each step that a move is behind the best one. The
    network learns what to put right. 0 begins with nothing."""
    tour_pull: float = Field(0.0, ge=0.0)
    """Choose moves as if each step that a move's tour to the goal takes beyond the shortest cost so much on top of what
    the network says, in training as later: of moves that are worth about the same the one that keeps to a tour. Each
    step behind the best prospect costs so much, too."""


class TrainingConfig(_Config):
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
    """Unknown cells near obstacles that the map prior is fitted to before the training, at most."""
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

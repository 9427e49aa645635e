"""Every hyperparameter of the thesis's training (its Table 4.1) and a switch for each of its mistakes."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from indoor_explorers.env.scenarios.codes import StuckRuleName
from indoor_explorers.env.scenarios.presets import REWARDS
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions.settings import LearnerSettings

#: What every switch says once its mistake is mended.
MENDED: dict[str, Any] = {
    "terminal_target": "reward",
    "advantage_mean": "actions",
    "frame_stack": 4,
    "identity": True,
    "mates": "learn",
    "received_rewarded": False,
    "budget_terminal": False,
}


class TrainingConfig(LearnerSettings):
    """Describe one training completely, together with its scenario and seed; the defaults are the thesis's."""

    episodes: int = Field(10_000, ge=1)
    """Episodes flown in training: 10,000 in the empty room, 50,000 among obstacles (section 4.2)."""
    environments: int = Field(1, ge=1, le=4096)
    """Episodes flown side by side. The thesis: 1. More are faster, since the network chooses for all at once; learning
    goes on once for every ``learn_every`` moves of all of them together."""
    batch: int = Field(32, ge=1)
    """Transitions in one update (``batch_size``)."""
    learn_every: int = Field(10, ge=1)
    """Moves between two updates (``learn_every``)."""
    target_every: int = Field(10_000, ge=1)
    """Moves between two copies of the network to the target network (``update_every``)."""
    learning_rate: float = Field(1e-4, gt=0.0)
    """Adam's step size (``alpha``)."""
    gamma: float = Field(0.99, ge=0.0, le=1.0)
    """Discount a step (``gamma``)."""
    epsilon_first: float = Field(1.0, ge=0.0, le=1.0)
    """Probability of a random move at the beginning (``epsilon``)."""
    epsilon_last: float = Field(0.01, ge=0.0, le=1.0)
    """What it does not fall below (``epsilon_min``)."""
    epsilon_decay: float = Field(0.99999, gt=0.0, le=1.0)
    """Factor of that probability after each decision in training (``epsilon_decay``): 460,000 of them to the last."""
    memory: int = Field(100_000, ge=1)
    """Latest transitions kept for replay (``memory_size``)."""

    reward_scenario: Literal[1, 2, 3] | None = None
    """The thesis's reward scenario (Table 4.2); None: the rewards of the scenario that is trained on."""
    stuck_rule: StuckRuleName | None = None
    """The thesis's "no stuck", "stuck 1" or "stuck 2" (section 4.2); None: the rule of the scenario trained on."""
    collision: Literal["end", "block"] = "end"
    """Whether a move into an obstacle or off the map ends the episode, as in the thesis, or only costs its penalty."""
    initial_weights: str | None = None
    """Weights to start from; the thesis's teams start from those of one UAV. None: drawn from the seed."""

    terminal_target: Literal["zero", "reward"] = "zero"
    """What a transition that ends the episode is learned towards. ``zero``: 0, so that neither the bonus nor any
    penalty is ever learned, and a crash looks no worse than a goal. Right: its ``reward``."""
    advantage_mean: Literal["batch", "actions"] = "batch"
    """Over what the advantages' mean is taken. ``batch``: all actions of all states that happen to be in the batch, so
    that V and A are not told apart and a value depends on its neighbours. Right: the ``actions`` (equation 3.2)."""
    frame_stack: int = Field(1, ge=1, le=16)
    """Images seen at once, the latest last. 1: nothing tells where the UAV came from, and it swings between two cells.
    Right: the 4 that the network was made for (Mnih et al. 2015)."""
    identity: bool = False
    """False: UAVs are painted by their number, so linked UAVs, whose maps are merged, see the same image and act alike,
    and the network, trained on the first UAV, has never seen another one fly. Right (True): each sees itself as 1
    and every mate as 2."""
    mates: Literal["random", "learn"] = "random"
    """What the team-mates do in training. ``random``: the first UAV learns while the others move at random, and soon
    crash. Right: all ``learn``, one network from everybody's experience."""
    received_rewarded: bool = True
    """Whether a cell received by radio is paid like one that the UAV discovered itself; what it is paid for then is
    none of its doing. Right: False."""
    budget_terminal: bool = True
    """Whether an episode that is cut by its budget of steps counts as ended: what could have followed is then taken for
    nothing, though nothing in the observation tells how many steps are left. Right: False."""

    evaluation_every: int = Field(500, ge=1)
    """Training episodes between two evaluations; the thesis: 200 or 500."""
    evaluation_episodes: int = Field(100, ge=1, le=100_000)
    """Episodes of one evaluation, all UAVs greedy, on maps kept apart from training; the thesis: 1."""
    checkpoint_every: int = Field(2_500, ge=1)
    """Training episodes between two checkpoints."""

    def task(self, scenario: Scenario) -> Scenario:
        """Return the scenario as it is trained and evaluated on."""
        settings: dict[str, Any] = {"on_collision": self.collision}
        rewards = scenario.rewards if self.reward_scenario is None else REWARDS[self.reward_scenario]
        received = rewards.discovered if self.received_rewarded else 0.0
        settings["rewards"] = rewards.model_dump() | {"received": received}
        if self.stuck_rule is not None:
            settings["stuck.rule"] = self.stuck_rule
        return scenario.with_settings(settings)

    def epsilon(self, decisions: int) -> float:
        """Return the exploration after this many decisions in training."""
        return float(max(self.epsilon_last, self.epsilon_first * self.epsilon_decay**decisions))

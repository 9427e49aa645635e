"""The hyperparameters of the thesis's training (its Table 4.1) and a switch for each of its mistakes."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from indoor_explorers.env.scenarios.codes import StuckRuleName
from indoor_explorers.env.scenarios.presets import REWARDS
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.sessions.settings import LearnerSettings

#: The value of every switch that corrects its mistake.
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
    """Episodes flown in parallel; the thesis: 1. More are faster, since the network chooses for all of them in one
    batch; ``learn_every`` counts the moves of all of them together."""
    batch: int = Field(32, ge=1)
    """Transitions in one update (``batch_size``)."""
    learn_every: int = Field(10, ge=1)
    """Moves between two updates (``learn_every``)."""
    target_every: int = Field(10_000, ge=1)
    """Moves between two updates of the target network (``update_every``)."""
    learning_rate: float = Field(1e-4, gt=0.0)
    """Adam's step size (``alpha``)."""
    gamma: float = Field(0.99, ge=0.0, le=1.0)
    """Discount factor per step (``gamma``)."""
    epsilon_first: float = Field(1.0, ge=0.0, le=1.0)
    """Initial probability of a random move (``epsilon``)."""
    epsilon_last: float = Field(0.01, ge=0.0, le=1.0)
    """Lower bound of that probability (``epsilon_min``)."""
    epsilon_decay: float = Field(0.99999, gt=0.0, le=1.0)
    """Factor of it after each decision in training (``epsilon_decay``); it reaches the bound after 460,000."""
    memory: int = Field(100_000, ge=1)
    """Size of the replay memory in transitions (``memory_size``)."""

    reward_scenario: Literal[1, 2, 3] | None = None
    """The thesis's reward scenario (Table 4.2); None: the rewards of the training scenario."""
    stuck_rule: StuckRuleName | None = None
    """The thesis's "no stuck", "stuck 1" or "stuck 2" (section 4.2); None: the rule of the training scenario."""
    collision: Literal["end", "block"] = "end"
    """Whether a move into an obstacle or off the map ends the episode, as in the thesis, or only costs its penalty."""
    initial_weights: str | None = None
    """Path of initial weights; the thesis's teams start from those of one UAV. None: random weights from the seed."""

    terminal_target: Literal["zero", "reward"] = "zero"
    """Target of a transition that ends the episode. ``zero``: 0, so that neither the bonus nor any penalty is ever
    learned, and a crash is worth as much as the goal. Correct: its ``reward``."""
    advantage_mean: Literal["batch", "actions"] = "batch"
    """Set over which the mean advantage is taken. ``batch``: all actions of all states in the batch, so that V and A
    are not separated and a value depends on the other states. Correct: the state's ``actions`` (equation 3.2)."""
    frame_stack: int = Field(1, ge=1, le=16)
    """Stacked images, the latest last. 1: the image does not show where the UAV came from, and the UAV oscillates
    between two cells. Correct: 4, for which the network was designed (Mnih et al. 2015)."""
    identity: bool = False
    """False: UAVs are drawn by their numbers. Linked UAVs share a map, so they see the same image and act alike; and
    the network, trained on the first UAV, never saw the image from another one's view. Correct: True; each UAV sees
    itself as 1 and every teammate as 2."""
    mates: Literal["random", "learn"] = "random"
    """What the teammates do in training. ``random``: they move at random and soon crash, while the first UAV learns.
    Correct: all ``learn``, one network from the experience of all UAVs."""
    received_rewarded: bool = True
    """Whether a cell received by radio earns the reward of a cell that the UAV discovered itself. True rewards the UAV
    for what others did. Correct: False."""
    budget_terminal: bool = True
    """Whether an episode that its step budget truncates counts as terminated. True sets the value of its last state to
    zero, although the observation does not show the remaining steps. Correct: False."""

    centred: bool = False
    """Whether the image is centred on the UAV and twice as wide, with obstacles around the map. No mistake of the
    thesis's, but a change that its network needs: after its three convolutions one cell of 64 numbers is left, which
    cannot tell where in the map the UAV is."""
    loss: Literal["squared", "huber"] = "squared"
    """The loss of a temporal difference: ``squared`` (the thesis) or ``huber``, linear from 1 on (Mnih et al.
    2015)."""
    reward_scale: float = Field(1.0, gt=0.0)
    """Factor of all rewards in the targets; 1 in the thesis, whose targets are some hundreds."""
    terminal_reward: float | None = Field(None, gt=0.0)
    """Reward for the goal, and penalty for a crash and for being stuck; None: those of the reward scenario, which are
    100 to 10,000 times the reward of a cell, so that errors in their values hide what a cell is worth."""

    evaluation_every: int = Field(500, ge=1)
    """Training episodes between two evaluations; the thesis: 200 or 500."""
    evaluation_episodes: int = Field(100, ge=1, le=100_000)
    """Episodes of one evaluation, all UAVs greedy, on maps that training does not use; the thesis: 1."""
    checkpoint_every: int = Field(2_500, ge=1)
    """Training episodes between two checkpoints."""

    def task(self, scenario: Scenario) -> Scenario:
        """Return a scenario with the rewards and rules of the training."""
        settings: dict[str, Any] = {"on_collision": self.collision}
        rewards = scenario.rewards if self.reward_scenario is None else REWARDS[self.reward_scenario]
        received = rewards.discovered if self.received_rewarded else 0.0
        settings["rewards"] = rewards.model_dump() | {"received": received} | self._terminal_rewards()
        if self.stuck_rule is not None:
            settings["stuck.rule"] = self.stuck_rule
        return scenario.with_settings(settings)

    def _terminal_rewards(self) -> dict[str, float]:
        if self.terminal_reward is None:
            return {}
        penalties = dict.fromkeys(("collision", "out_of_bounds", "stuck"), -self.terminal_reward)
        return penalties | {"goal": self.terminal_reward}

    def epsilon(self, decisions: int) -> float:
        """Return the probability of a random move after a number of decisions in training."""
        return float(max(self.epsilon_last, self.epsilon_first * self.epsilon_decay**decisions))

"""Discrete soft actor-critic with two critics, target networks and automatic temperature.

P. Christodoulou, "Soft Actor-Critic for Discrete Action Settings", 2019 (arXiv:1910.07207), as ARiADNE trains its
policy. Time between choices varies, so the discount of a choice is that of its duration. The rewards of several choices
are summed before the critics' estimate of what follows (n-step returns, Hessel et al. 2018, "Rainbow",
arXiv:1710.02298), as the estimates of neighbouring nodes differ by little. What is evaluated and kept is a moving
average of the policy, as single updates of small batches change it much (B. Polyak and A. Juditsky, "Acceleration of
Stochastic Approximation by Averaging", 1992, doi:10.1137/0330046). With a privileged critic the
critics see the graph of the true map, and the policy that of the known one (RA-L 2024; L. Pinto et al. 2018,
"Asymmetric Actor Critic", arXiv:1710.06542).
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import Field
from torch import Tensor, nn
from torch.nn import functional
from torch.optim.swa_utils import AveragedModel

from indoor_explorers.learners.attention.flights import Choice
from indoor_explorers.learners.attention.graph import FEATURES, TRUE_FEATURES
from indoor_explorers.learners.attention.model import Batch, CriticNet, PolicyNet, batch_of
from indoor_explorers.learners.attention.network import NetworkSettings
from indoor_explorers.learners.sessions.networks import learner_tensors, restore_learner
from indoor_explorers.learners.sessions.settings import Settings

#: Logarithm of the temperature at the beginning.
FIRST_TEMPERATURE = -3.0


class SacSettings(Settings):
    """Hyperparameters of soft actor-critic."""

    privileged_critic: bool = True
    """Let the critics see the graph of the true map."""
    batch: int = Field(32, ge=1)
    """Choices in an update."""
    rate: float = Field(5e-4, gt=0.0)
    """Learning rate of the networks (the papers: 1e-5, with 16 processes that fly)."""
    temperature_rate: float = Field(3e-3, gt=0.0)
    """Learning rate of the logarithm of the temperature."""
    ahead: int = Field(5, ge=1)
    """Choices whose rewards are summed before the critics' estimate of what follows."""
    discount: float = Field(0.97, gt=0.0, le=1.0)
    """Discount factor per lidar range of flight."""
    step_cost: float = Field(0.3, ge=0.0)
    """Cost of a lidar range of flight; discovering as many cells as the square of the lidar range has the reward 1."""
    target_rate: float = Field(0.01, gt=0.0, le=1.0)
    """Share of the critics that the target networks take over in an update."""
    entropy: float = Field(0.2, ge=0.0, le=1.0)
    """Entropy that the temperature is adjusted to, as a share of that of an even choice."""
    average: float = Field(0.998, ge=0.0, lt=1.0)
    """Share that the moving average of the policy keeps in an update; 0: it is the present policy."""
    clip: float = Field(5.0, gt=0.0)
    """Largest norm of a network's gradient."""


class Losses(NamedTuple):
    """Figures of one update."""

    critic: float
    """Mean squared error of both critics."""
    policy: float
    entropy: float
    """Mean entropy of the policy in nats."""
    temperature: float


def soft_values(log_p: Tensor, values: Tensor, temperature: Tensor | float) -> Tensor:
    """Return the values (B,) of states, from log-probabilities (B, K) and action values (B, K)."""
    return (log_p.exp() * (values - temperature * log_p)).sum(dim=1)


def summed(trail: Sequence[Choice], settings: SacSettings) -> tuple[float, float]:
    """Return the discounted rewards of a trail, and the discount of what follows.

    A trail is up to ``ahead`` choices of one UAV in a row, and the one that follows them; it ends early with the last
    choice of a flight. What follows is at the last choice, but for a flight that reached its goal: there the last
    choice is rewarded as well, and the discount is 0.
    """
    ended = len(trail) <= settings.ahead and trail[-1].follows == 0
    total, discount = 0.0, 1.0
    for choice in trail if ended else trail[:-1]:
        total += discount * (choice.gain - settings.step_cost * choice.duration)
        discount *= settings.discount**choice.duration
    return total, 0.0 if ended else discount


class Sac:
    """The networks and their updates."""

    def __init__(self, settings: SacSettings, network: NetworkSettings, seed: int) -> None:
        torch.manual_seed(seed)
        self.settings = settings
        inputs = TRUE_FEATURES if settings.privileged_critic else FEATURES
        self.policy = PolicyNet(FEATURES, network)
        self.averaged = AveragedModel(self.policy, avg_fn=self._averaged)
        self.critics = nn.ModuleList(CriticNet(inputs, network) for _ in range(2))
        self.targets = copy.deepcopy(self.critics).requires_grad_(False)
        self.temperature = nn.ParameterDict({"log": nn.Parameter(torch.tensor([FIRST_TEMPERATURE]))})
        networks = [*self.policy.parameters(), *self.critics.parameters()]
        groups: list[dict[str, Any]] = [
            {"params": networks, "lr": settings.rate},
            {"params": self.temperature.parameters(), "lr": settings.temperature_rate},
        ]
        self.optimiser = torch.optim.Adam(groups, fused=True)

    @property
    def networks(self) -> dict[str, nn.Module]:
        """All networks by name."""
        return {
            "policy": self.policy,
            "averaged": self.averaged,
            "critics": self.critics,
            "targets": self.targets,
            "temperature": self.temperature,
        }

    def update(self, trails: Sequence[Sequence[Choice]]) -> Losses:
        """Learn from the first choices of B trails, see :func:`summed`."""
        choices = [trail[0] for trail in trails]
        settings, alpha = self.settings, self.temperature["log"].exp().detach()
        seen, critic_seen = self._batches(choices)
        chosen = torch.tensor([choice.chosen for choice in choices])[:, None]
        aims = self._aims(trails, alpha)
        values = [critic(critic_seen) for critic in self.critics]
        errors = [functional.mse_loss(each.gather(1, chosen).squeeze(1), aims) for each in values]
        log_p = self.policy(seen)
        worth = torch.minimum(*values).detach()
        policy_loss = -soft_values(log_p, worth, alpha).mean()
        entropy = -(log_p.detach().exp() * log_p.detach()).sum(dim=1)
        wanted = settings.entropy * seen.legal.sum(dim=1).clamp(min=1).log()
        temperature_loss = self.temperature["log"].sum() * (entropy - wanted).mean()
        self.optimiser.zero_grad()
        (errors[0] + errors[1] + policy_loss + temperature_loss).backward()
        for network in (self.policy, *self.critics):
            nn.utils.clip_grad_norm_(network.parameters(), settings.clip)
        self.optimiser.step()
        self._move_targets()
        self.averaged.update_parameters(self.policy)
        error = float((errors[0] + errors[1]).detach()) / 2
        return Losses(error, float(policy_loss.detach()), float(entropy.mean()), float(alpha))

    @torch.no_grad()
    def _aims(self, trails: Sequence[Sequence[Choice]], alpha: Tensor) -> Tensor:
        """Return what the critics learn, (B,)."""
        rewards, discounts = torch.tensor([summed(trail, self.settings) for trail in trails]).T
        seen, critic_seen = self._batches([trail[-1] for trail in trails])
        values = torch.minimum(*(target(critic_seen) for target in self.targets))
        aims: Tensor = rewards + discounts * soft_values(self.policy(seen), values, alpha)
        return aims

    def _batches(self, choices: Sequence[Choice]) -> tuple[Batch, Batch]:
        """Return choices as the policy sees them, and as the critics do."""
        actions = [choice.actions for choice in choices]
        seen = batch_of([choice.features for choice in choices], [choice.neighbours for choice in choices], actions)
        if not self.settings.privileged_critic:
            return seen, seen
        features = [choice.true_features for choice in choices]
        return seen, batch_of(features, [choice.true_neighbours for choice in choices], actions)

    def _averaged(self, average: Tensor, present: Tensor, updates: Tensor | int) -> Tensor:
        """Return the next average: that of all policies at first, later one that forgets the oldest."""
        return average.lerp(present, max(1.0 - self.settings.average, 1.0 / (1.0 + float(updates))))

    @torch.no_grad()
    def _move_targets(self) -> None:
        for target, critic in zip(self.targets.parameters(), self.critics.parameters(), strict=True):
            target.lerp_(critic, self.settings.target_rate)

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return everything that :meth:`restore` needs, by name."""
        return learner_tensors(self.networks, self.optimiser)

    def restore(self, tensors: Mapping[str, NDArray[Any]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        restore_learner({name: np.asarray(array) for name, array in tensors.items()}, self.networks, self.optimiser)

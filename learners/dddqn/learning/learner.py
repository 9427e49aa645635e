"""The networks of a training and one update of them."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.optim.swa_utils import get_ema_multi_avg_fn

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.replay import Batch
from indoor_explorers.learners.dddqn.learning.targets import masked, q_target, shortfall
from indoor_explorers.learners.dddqn.network.model import DuelingNetwork, new_network
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import BLOCKED_AT, observation_layout, tour_costs
from indoor_explorers.learners.sessions.networks import learner_tensors, restore_learner

#: Processor instructions that make bfloat16 matrix products faster than float32 ones.
_FAST = ("avx512_bf16", "amx_bf16")


class Learner:
    """Hold the networks and the optimiser.

    ``online`` learns, ``target`` evaluates the next states, ``average`` is the moving average that is evaluated and
    shipped, ``best`` the average that did best so far. ``acting`` is a copy of the online network made by
    :meth:`refresh`, which chooses moves while the online network learns in another thread. Noisy layers have noise in
    learning and acting, not in the average.

    Raises:
        InputError: the configuration asks for a GPU and torch finds none.

    """

    def __init__(self, observation: ObservationConfig, config: TrainingConfig, seed: int) -> None:
        self.config = config
        self.device = _device(config.device)
        self.mixed = config.precision == "mixed" or (config.precision == "auto" and _fast_bfloat16(self.device))
        self.updates = 0
        self.online = new_network(observation_layout(observation), config.network, seed).to(self.device)
        self.target = copy.deepcopy(self.online).requires_grad_(False)
        self.acting = copy.deepcopy(self.target)
        self.average = copy.deepcopy(self.target).eval()
        self.best = copy.deepcopy(self.average)
        self.optimiser = torch.optim.Adam(self.online.parameters(), lr=config.learning_rate, fused=True)
        self._noise = torch.Generator().manual_seed(seed)
        pull = tour_costs(observation_layout(observation), config.network.tour_pull, 0.0, kinds=config.network.kinds)
        self._pull = None if pull is None else torch.from_numpy(pull).to(self.device)

    def refresh(self) -> None:
        """Copy the online network to the acting one, with new noise."""
        _copy(self.acting, self.online)
        self.acting.draw_noise(self._noise)

    def update(self, batch: Batch, share: float) -> tuple[float, NDArray[np.float32]]:
        """Learn from a batch after a ``share`` of the training; return the loss and the TD errors (B,)."""
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.rate(share)
        self.online.draw_noise(self._noise)
        self.target.draw_noise(self._noise)
        loss, errors_B = self.td_loss(batch)
        self.optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]  # torch gives it no types
        nn.utils.clip_grad_norm_(self.online.parameters(), self.config.gradient_clip)
        self.optimiser.step()
        self.updates += 1
        self._follow()
        return loss.item(), errors_B.cpu().numpy()

    def td_loss(self, batch: Batch) -> tuple[Tensor, Tensor]:
        """Return the weighted mean Huber loss of the chosen moves' values, and the TD errors (B,)."""
        kind = torch.bfloat16 if self.mixed else torch.float32
        scenes_BI, next_scenes_BI = (x.to(self.device, kind) for x in (batch.scenes_BI, batch.next_scenes_BI))
        moves_BAF, next_moves_BAF = batch.moves_BAF.to(self.device), batch.next_moves_BAF.to(self.device)
        action_B, return_B, discount_B, weight_B = (
            x.to(self.device) for x in (batch.action_B, batch.return_B, batch.discount_B, batch.weight_B)
        )
        with self._precision():
            q_B = self.online(scenes_BI, moves_BAF).gather(1, action_B[:, None]).squeeze(1)
            with torch.no_grad():
                following_BA = self.target(next_scenes_BI, next_moves_BAF)
                chosen_BA = self.online(next_scenes_BI, next_moves_BAF) if self.config.double else following_BA
                here_BA = self.target(scenes_BI, moves_BAF) if self.config.action_gap > 0.0 else None
        rank_BA = self._ranked(chosen_BA, next_moves_BAF, mask=self.config.mask)
        target_B = q_target(return_B, discount_B, rank_BA, following_BA)
        if here_BA is not None:
            best_B = self._ranked(here_BA, moves_BAF, mask=self.config.mask).argmax(dim=1)
            target_B = target_B - self.config.action_gap * shortfall(here_BA, best_B, action_B)
        loss_B = nn.functional.smooth_l1_loss(q_B, target_B, reduction="none")
        return (weight_B * loss_B).mean(), (target_B - q_B).detach()

    def _ranked(self, q_BA: Tensor, moves_BAF: Tensor, *, mask: bool) -> Tensor:
        """Return the values that moves are chosen by: Q with the pull of the tours, the minimum for blocked moves."""
        if self._pull is not None:
            q_BA = q_BA + moves_BAF @ self._pull
        return masked(q_BA, moves_BAF[:, :, BLOCKED_AT] > 0.5 if mask else None)

    def _precision(self) -> torch.autocast:
        return torch.autocast(self.device.type, torch.bfloat16, enabled=self.mixed)

    def _follow(self) -> None:
        follow(self.average, self.online, self.config.average_rate)
        if self.config.target == "soft":
            follow(self.target, self.online, self.config.target_rate)
        elif self.updates % self.config.target_every == 0:
            _copy(self.target, self.online)

    @torch.no_grad()
    def greedy(
        self, network: DuelingNetwork, scenes: NDArray[np.uint8], moves: NDArray[np.float32], *, mask: bool
    ) -> NDArray[np.int64]:
        """Return the best moves (B,), with ``mask`` the best legal ones.

        ``scenes`` (B, inputs) uint8 and ``moves`` (B, 4, features) float32; computed on the learner's device and in
        its precision.
        """
        moves_BAF = torch.from_numpy(moves).to(self.device)
        scenes_BI = torch.from_numpy(scenes).to(self.device).float().mul_(1.0 / 255.0)
        with self._precision():
            q_BA = network(scenes_BI, moves_BAF)
        return np.asarray(self._ranked(q_BA, moves_BAF, mask=mask).argmax(dim=1).cpu().numpy())

    def networks(self) -> dict[str, DuelingNetwork]:
        """Return the networks that a checkpoint holds, by name; the acting one is a copy of the online one."""
        return {"online": self.online, "target": self.target, "average": self.average, "best": self.best}

    def tensors(self) -> dict[str, NDArray[Any]]:
        """Return copies of everything that :meth:`restore` needs, by name."""
        own = {"noise": self._noise.get_state().numpy(), "updates": np.array(self.updates)}
        return learner_tensors(self.networks(), self.optimiser) | own

    def restore(self, tensors: dict[str, NDArray[Any]]) -> None:
        """Restore the state that :meth:`tensors` returned."""
        restore_learner(tensors, self.networks(), self.optimiser)
        self._noise.set_state(torch.from_numpy(tensors["noise"]))
        self.updates = int(tensors["updates"].item())


def follow(network: DuelingNetwork, leader: DuelingNetwork, rate: float) -> None:
    """Update the weights of ``network``: weights += rate * (leader's weights - weights)."""
    step = get_ema_multi_avg_fn(1.0 - rate)  # type: ignore[no-untyped-call]  # torch gives it no types
    step(list(network.parameters()), list(leader.parameters()), None)


@torch.no_grad()
def _copy(network: DuelingNetwork, leader: DuelingNetwork) -> None:
    for own, other in zip(network.parameters(), leader.parameters(), strict=True):
        own.copy_(other)


def _device(requested: str) -> torch.device:
    available = torch.cuda.is_available()
    if requested == "cuda" and not available:
        raise InputError("expected a GPU that torch can use for device 'cuda', found none; set device to 'cpu'")
    return torch.device("cuda" if available and requested != "cpu" else "cpu")


def _fast_bfloat16(device: torch.device) -> bool:
    """Tell whether the device has instructions for bfloat16 matrices."""
    if device.type == "cuda":
        return bool(torch.cuda.is_bf16_supported(including_emulation=False))
    if not hasattr(torch.cpu, "get_capabilities"):  # before torch 2.10
        return False
    return any(torch.cpu.get_capabilities().get(name) for name in _FAST)

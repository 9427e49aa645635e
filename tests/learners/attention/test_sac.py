from __future__ import annotations

import numpy as np
import pytest
import torch

from indoor_explorers.learners.attention.flights import Choice
from indoor_explorers.learners.attention.graph import FEATURES, TRUE_FEATURES
from indoor_explorers.learners.attention.network import NetworkSettings
from indoor_explorers.learners.attention.sac import Sac, SacSettings, soft_values, targets
from indoor_explorers.learners.attention.train import Replay
from tests.learners.attention.test_network import random_graph

SMALL = NetworkSettings(units=16, heads=2, layers=1)


def choice(seed: int, *, follows: int = 1, gain: float = 0.5, duration: float = 2.0, chosen: int = 0) -> Choice:
    graph, rng = random_graph(6 + seed % 3, seed), np.random.default_rng(seed)
    edges = graph.neighbours.astype(np.int16)
    true = rng.normal(size=(len(edges), TRUE_FEATURES)).astype(np.float16)
    return Choice(graph.features.astype(np.float16), edges, true, edges, edges[0], chosen, gain, duration, follows)


def test_values_and_targets_by_hand() -> None:
    log_p = torch.log(torch.tensor([[0.25, 0.75]]))
    values = torch.tensor([[1.0, 2.0]])
    by_hand = 0.25 * (1.0 - 0.1 * np.log(0.25)) + 0.75 * (2.0 - 0.1 * np.log(0.75))
    assert soft_values(log_p, values, 0.1).item() == pytest.approx(by_hand)
    absent = torch.tensor([[0.0, -1e8]])
    assert soft_values(absent, torch.tensor([[3.0, 0.0]]), 0.1).item() == pytest.approx(3.0)
    found = targets(torch.tensor([1.0, 1.0]), torch.tensor([0.9, 0.0]), torch.tensor([10.0, 10.0]))
    assert found.tolist() == pytest.approx([10.0, 1.0])


@pytest.mark.parametrize("privileged", [True, False])
def test_the_critics_learn_the_reward_and_what_follows(privileged: bool) -> None:
    settings = SacSettings(privileged_critic=privileged, discount=0.9, step_cost=0.3)
    sac, now, after = Sac(settings, SMALL, 1), [choice(1), choice(2, follows=0)], [choice(3), choice(4)]
    alpha = sac.temperature["log"].exp().detach()
    aims = sac._aims(now, after, alpha)
    seen, critic_seen = sac._batches(after)
    assert critic_seen.features.shape[-1] == (TRUE_FEATURES if privileged else FEATURES)
    worth = torch.minimum(*(target(critic_seen) for target in sac.targets)).detach()
    following = soft_values(sac.policy(seen).detach(), worth, alpha)
    assert aims[0].item() == pytest.approx(0.5 - 0.3 * 2.0 + 0.9**2 * following[0].item(), rel=1e-5)
    assert aims[1].item() == pytest.approx(0.5 - 0.3 * 2.0, rel=1e-5)


def test_the_better_neighbour_becomes_likelier_and_the_temperature_moves() -> None:
    sac = Sac(SacSettings(rate=3e-3, batch=8, entropy=0.5), SMALL, 1)
    flights = [choice(1, follows=0, chosen=k, gain=float(k == 2)) for k in range(4)] * 2
    first = sac.update(flights, flights)
    for _ in range(150):
        last = sac.update(flights, flights)
    assert last.critic < 0.2 * first.critic
    seen, _ = sac._batches(flights[:1])
    assert sac.policy(seen).argmax().item() == 2
    assert last.temperature != first.temperature
    assert last.entropy < first.entropy


def test_target_networks_follow_slowly() -> None:
    sac = Sac(SacSettings(target_rate=0.25), SMALL, 1)
    before = [each.clone() for each in sac.targets.parameters()]
    sac.update([choice(1), choice(2)], [choice(3), choice(4)])
    for old, now, critic in zip(before, sac.targets.parameters(), sac.critics.parameters(), strict=True):
        torch.testing.assert_close(now, 0.75 * old + 0.25 * critic.detach())


def test_the_replay_drops_the_oldest_and_draws_no_choice_with_an_unknown_end() -> None:
    replay = Replay(5)
    replay.add([choice(0), choice(1, follows=-1)])
    replay.add([choice(2), choice(3), choice(4), choice(5, follows=0)])
    assert len(replay.choices) == 5
    now, after = replay.drawn(50, np.random.default_rng(1))
    place = {id(each): k for k, each in enumerate(replay.choices)}
    assert {place[id(each)] for each in now} == {1, 2, 3, 4}
    assert all(place[id(b)] == min(place[id(a)] + 1, 4) for a, b in zip(now, after, strict=True))
    other = Replay(5)
    other.restore(replay.tensors())
    for one, two in zip(replay.choices, other.choices, strict=True):
        assert all(np.array_equal(getattr(one, name), getattr(two, name)) for name in Choice._fields)

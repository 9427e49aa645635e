from __future__ import annotations

import numpy as np
import pytest
import torch

from indoor_explorers.learners.attention.flights import Choice
from indoor_explorers.learners.attention.graph import FEATURES, TRUE_FEATURES
from indoor_explorers.learners.attention.network import NetworkSettings
from indoor_explorers.learners.attention.sac import Sac, SacSettings, soft_values, summed
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


def test_rewards_of_a_trail_are_summed_until_the_estimate_or_the_goal() -> None:
    settings = SacSettings(discount=0.9, step_cost=0.3, ahead=2)
    first, second, last = choice(1, gain=2.0), choice(2, duration=1.0), choice(3)
    assert summed([first, second, last], settings) == pytest.approx((1.4 + 0.81 * 0.2, 0.9**3))
    reached = second._replace(follows=0)
    assert summed([first, reached], settings) == pytest.approx((1.4 + 0.81 * 0.2, 0.0))
    assert summed([first, second, last._replace(follows=0)], settings) == pytest.approx((1.4 + 0.81 * 0.2, 0.9**3))
    assert summed([first, second._replace(follows=-1)], settings) == pytest.approx((1.4, 0.81))


@pytest.mark.parametrize("privileged", [True, False])
def test_the_critics_learn_the_reward_and_what_follows(privileged: bool) -> None:
    settings = SacSettings(privileged_critic=privileged, discount=0.9, step_cost=0.3, ahead=1)
    sac, after = Sac(settings, SMALL, 1), [choice(3), choice(2, follows=0)]
    alpha = sac.temperature["log"].exp().detach()
    aims = sac._aims([[choice(1), after[0]], after[1:]], alpha)
    seen, critic_seen = sac._batches(after)
    assert critic_seen.features.shape[-1] == (TRUE_FEATURES if privileged else FEATURES)
    worth = torch.minimum(*(target(critic_seen) for target in sac.targets)).detach()
    following = soft_values(sac.policy(seen).detach(), worth, alpha)
    assert aims[0].item() == pytest.approx(0.5 - 0.3 * 2.0 + 0.9**2 * following[0].item(), rel=1e-5)
    assert aims[1].item() == pytest.approx(0.5 - 0.3 * 2.0, rel=1e-5)


def test_the_better_neighbour_becomes_likelier_and_the_temperature_moves() -> None:
    sac = Sac(SacSettings(rate=3e-3, batch=8, entropy=0.5), SMALL, 1)
    trails = [[choice(1, follows=0, chosen=k, gain=float(k == 2))] for k in range(4)] * 2
    first = sac.update(trails)
    for _ in range(150):
        last = sac.update(trails)
    assert last.critic < 0.2 * first.critic
    seen, _ = sac._batches(trails[0])
    assert sac.policy(seen).argmax().item() == 2
    assert last.temperature != first.temperature
    assert last.entropy < first.entropy


def test_target_networks_follow_slowly() -> None:
    sac = Sac(SacSettings(target_rate=0.25), SMALL, 1)
    before = [each.clone() for each in sac.targets.parameters()]
    sac.update([[choice(1), choice(3)], [choice(2), choice(4)]])
    for old, now, critic in zip(before, sac.targets.parameters(), sac.critics.parameters(), strict=True):
        torch.testing.assert_close(now, 0.75 * old + 0.25 * critic.detach())


def test_the_replay_drops_the_oldest_and_draws_no_choice_with_an_unknown_end() -> None:
    replay = Replay(5)
    replay.add([choice(0), choice(1, follows=-1)])
    replay.add([choice(2), choice(3), choice(4), choice(5, follows=0)])
    assert len(replay.choices) == 5
    place = {id(each): k for k, each in enumerate(replay.choices)}
    drawn = [[place[id(each)] for each in trail] for trail in replay.drawn(50, 2, np.random.default_rng(1))]
    assert {tuple(trail) for trail in drawn} == {(1, 2, 3), (2, 3, 4), (3, 4), (4,)}
    other = Replay(5)
    other.restore(replay.tensors())
    for one, two in zip(replay.choices, other.choices, strict=True):
        assert all(np.array_equal(getattr(one, name), getattr(two, name)) for name in Choice._fields)

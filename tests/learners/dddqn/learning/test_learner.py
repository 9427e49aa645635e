"""One update of the network: every switch does what it says, and nothing is lost in a checkpoint."""

from typing import Any

import numpy as np
import pytest
import torch

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.learning.learner import Learner
from indoor_explorers.learners.dddqn.learning.replay import Batch
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.inference import q_values, weights_from
from indoor_explorers.learners.dddqn.network.model import DuelingNetwork, arrays
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import TOURS, observation_layout

SMALL = ObservationConfig(crop=5, coarse=3, layers=("unknown",), tours=False)
PLAN = observation_layout(SMALL)
NARROW = NetworkConfig(width=32, move_width=4)


def learner(seed: int = 1, **settings: Any) -> Learner:
    settings = {"network": NARROW, "device": "cpu", "precision": "full", "observation": SMALL} | settings
    return Learner(SMALL, TrainingConfig(**settings), seed)


def batch(size: int = 16, seed: int = 0, **parts: Any) -> Batch:
    rng = np.random.default_rng(seed)

    def numbers(*shape: int) -> torch.Tensor:
        return torch.from_numpy(rng.random(shape, dtype=np.float32))

    moves, following = numbers(size, 4, PLAN.features), numbers(size, 4, PLAN.features)
    moves[:, :, 0], following[:, :, 0] = 0.0, 0.0
    found = Batch(
        numbers(size, PLAN.inputs),
        moves,
        torch.from_numpy(rng.integers(0, 4, size)),
        numbers(size),
        torch.full((size,), 0.9),
        numbers(size, PLAN.inputs),
        following,
        torch.ones(size),
        np.arange(size),
    )
    return found._replace(**parts)


def parameters(network: DuelingNetwork) -> torch.Tensor:
    return torch.cat([parameter.detach().flatten() for parameter in network.parameters()])


def apart(one: Learner) -> Learner:
    """Make the target network another one than the online network."""
    with torch.no_grad():
        for parameter in one.target.parameters():
            parameter.mul_(-1.5)
    return one


@pytest.mark.parametrize("bonus", [400.0, -400.0])
@pytest.mark.parametrize("precision", ["full", "mixed"])
def test_terminal_rewards_are_learned(bonus: float, precision: str) -> None:
    always = torch.zeros(8, dtype=torch.int64)
    final = batch(8, action_B=always, return_B=torch.full((8,), bonus), discount_B=torch.zeros(8))
    one = learner(learning_rate=0.02, learning_rate_last=1.0, precision=precision)
    losses = [one.update(final, 0.0)[0] for _ in range(250)]
    q_B = one.online(final.scenes_BI, final.moves_BAF).gather(1, final.action_B[:, None])
    assert torch.allclose(q_B, torch.full((8, 1), bonus), rtol=0.05)
    assert losses[-1] < 20.0


@pytest.mark.parametrize("double", [True, False])
@pytest.mark.parametrize("mask", [True, False])
def test_errors_are_distances_to_the_target_of_the_switches(double: bool, mask: bool) -> None:
    one, some = apart(learner(double=double, mask=mask)), batch()
    some.next_moves_BAF[:, 1:3, 0] = 1.0
    with torch.no_grad():
        q_B = one.online(some.scenes_BI, some.moves_BAF).gather(1, some.action_B[:, None]).squeeze(1).numpy()
        online, target = (
            network(some.next_scenes_BI, some.next_moves_BAF).numpy() for network in (one.online, one.target)
        )
    choosing = online.copy() if double else target.copy()
    if mask:
        choosing[:, 1:3] = -1e9
    expected = some.return_B.numpy() + 0.9 * target[np.arange(16), choosing.argmax(axis=1)] - q_B
    loss, errors_B = one.update(some, 0.0)
    np.testing.assert_allclose(errors_B, expected, atol=1e-5)
    assert loss == pytest.approx(
        np.where(np.abs(expected) < 1, expected**2 / 2, np.abs(expected) - 0.5).mean(), abs=1e-5
    )


def test_moves_are_pulled_to_the_tours_in_choosing_alone() -> None:
    sight = SMALL.model_copy(update={"tours": True})
    layout = observation_layout(sight)
    pulled, free = (
        Learner(sight, TrainingConfig(network=NARROW.model_copy(update={"tour_pull": pull}), device="cpu"), 1)
        for pull in (100.0, 0.0)
    )
    rng = np.random.default_rng(2)
    scenes, moves = (
        rng.integers(0, 256, (32, layout.inputs), np.uint8),
        rng.random((32, 4, layout.features), np.float32),
    )
    beyond = moves[:, :, layout.tours_at + TOURS.index("its steps beyond the shortest")]
    assert np.array_equal(pulled.greedy(pulled.online, scenes, moves, mask=False), beyond.argmin(axis=1))
    assert not np.array_equal(free.greedy(free.online, scenes, moves, mask=False), beyond.argmin(axis=1))
    assert torch.equal(parameters(pulled.online), parameters(free.online))
    weights = (weights_from(arrays(one.online), layout, one.config.network) for one in (pulled, free))
    q = [np.empty((32, 4), np.float32) for _ in range(2)]
    for one, values in zip(weights, q, strict=True):
        q_values(scenes, moves, one, values)
    pull = q[1] - q[0]  # less its mean over the moves, which chooses nothing
    np.testing.assert_allclose(pull - pull[:, :1], 800.0 * (beyond - beyond[:, :1]), rtol=1e-3, atol=1e-3)


def test_the_action_gap_is_taken_off_the_targets_of_moves_that_are_not_the_best() -> None:
    plain, wide = (apart(learner(action_gap=gap)) for gap in (0.0, 0.6))
    found = batch(64)
    errors, widened = plain.td_loss(found)[1], wide.td_loss(found)[1]
    with torch.no_grad():
        q_BA = plain.target(found.scenes_BI, found.moves_BAF)
    behind = q_BA.amax(dim=1) - q_BA[torch.arange(64), found.action_B]
    assert torch.allclose(errors - widened, 0.6 * behind, atol=1e-5)
    best = behind == 0
    assert 0 < best.sum() < 64
    assert torch.equal(errors[best], widened[best])


def test_weights_say_how_much_each_transition_counts() -> None:
    some = batch()
    nothing = some._replace(weight_B=torch.zeros(16))
    one = learner()
    before = parameters(one.online).clone()
    assert one.update(nothing, 0.0)[0] == 0.0
    assert torch.equal(parameters(one.online), before)
    half = learner().update(some._replace(weight_B=torch.full((16,), 0.5)), 0.0)[0]
    assert half == pytest.approx(learner().update(some, 0.0)[0] / 2)


def test_the_step_size_falls_with_the_share_of_the_training() -> None:
    def step(share: float) -> float:
        one = learner(learning_rate=0.01, learning_rate_last=0.1)
        before = parameters(one.online).clone()
        one.update(batch(), share)
        return float((parameters(one.online) - before).abs().max())

    assert step(0.0) == pytest.approx(0.01, rel=0.05)
    assert step(1.0) == pytest.approx(0.001, rel=0.05)


def test_the_gradient_is_shortened_to_the_clip() -> None:
    far = batch(return_B=torch.full((16,), 1e4))
    for clip in (0.5, 1e6):
        one = learner(gradient_clip=clip)
        one.update(far, 0.0)
        length = torch.cat([p.grad.flatten() for p in one.online.parameters() if p.grad is not None]).norm().item()
        assert length == pytest.approx(0.5, rel=1e-3) if clip == 0.5 else length > 0.5


def test_a_soft_target_and_the_average_follow_by_their_rates() -> None:
    one = learner(target_rate=0.25, average_rate=0.125)
    before = parameters(one.online).clone()
    one.update(batch(), 0.0)
    moved = parameters(one.online) - before
    assert torch.allclose(parameters(one.target) - before, 0.25 * moved, atol=1e-7)
    assert torch.allclose(parameters(one.average) - before, 0.125 * moved, atol=1e-7)
    assert torch.equal(parameters(one.best), before)


def test_a_hard_target_stays_until_it_is_copied() -> None:
    one = learner(target="hard", target_every=3)
    before = parameters(one.online).clone()
    for update in range(1, 7):
        one.update(batch(seed=update), 0.0)
        assert torch.equal(parameters(one.target), parameters(one.online)) == (update % 3 == 0)
        assert torch.equal(parameters(one.target), before) == (update < 3)


@pytest.mark.parametrize("precision", ["full", "mixed"])
def test_the_greedy_move_is_the_best_one_that_may_be_made(precision: str) -> None:
    one, rng = learner(precision=precision), np.random.default_rng(0)
    scenes = rng.integers(0, 256, (40, PLAN.inputs), dtype=np.uint8)
    moves = rng.random((40, 4, PLAN.features), dtype=np.float32)
    moves[:, :, 0] = rng.random((40, 4)) < 0.4
    moves[:, 3, 0] = 0.0
    with torch.no_grad(), torch.autocast("cpu", torch.bfloat16, enabled=precision == "mixed"):
        q = one.online(torch.from_numpy(scenes).float() / 255, torch.from_numpy(moves)).numpy()
    assert np.array_equal(one.greedy(one.online, scenes, moves, mask=False), q.argmax(axis=1))
    legal = np.where(moves[:, :, 0] > 0, -np.inf, q)
    assert np.array_equal(one.greedy(one.online, scenes, moves, mask=True), legal.argmax(axis=1))
    assert not np.array_equal(legal.argmax(axis=1), q.argmax(axis=1))


def test_the_acting_network_is_the_online_one_of_the_last_refresh() -> None:
    one = learner()
    before = parameters(one.online).clone()
    one.update(batch(), 0.0)
    assert torch.equal(parameters(one.acting), before)
    one.refresh()
    assert torch.equal(parameters(one.acting), parameters(one.online))
    one.update(batch(), 0.0)
    assert not torch.equal(parameters(one.acting), parameters(one.online))


def test_noise_is_new_in_each_refresh_and_never_in_the_average() -> None:
    one, some = learner(network=NARROW.model_copy(update={"noisy": True})), batch()

    def q(network: DuelingNetwork) -> torch.Tensor:
        with torch.no_grad():
            q_BA: torch.Tensor = network(some.scenes_BI, some.moves_BAF)
        return q_BA

    means = q(one.average)
    seen = []
    for _ in range(3):
        one.refresh()
        seen.append(q(one.acting))
    one.update(some, 0.0)
    assert len({tuple(values.flatten().tolist()) for values in [means, *seen]}) == 4
    assert torch.equal(q(one.acting), seen[-1]), "updates leave the noise of those who fly alone"
    drawn = [dict(network.named_buffers())["think.noise_in"] for network in (one.online, one.target, one.average)]
    assert not torch.equal(drawn[0], drawn[1])
    assert not drawn[2].any()
    assert not one.average.training
    assert not one.best.training


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"target": "hard", "target_every": 4},
        {"network": NARROW.model_copy(update={"noisy": True})},
        {"precision": "mixed"},
    ],
    ids=str,
)
def test_a_restored_learner_goes_on_bit_for_bit(settings: dict[str, Any]) -> None:
    first, second = learner(1, **settings), learner(2, **settings)
    for update in range(6):
        first.update(batch(seed=update), 0.1)
    kept = first.tensors()
    for update in range(2):
        first.update(batch(seed=9 + update), 0.1)
    for update in range(3):
        second.update(batch(seed=20 + update), 0.1)
    second.restore(kept)
    for update in range(2):
        second.update(batch(seed=9 + update), 0.1)
    first.refresh()
    second.refresh()
    ends, others = first.tensors(), second.tensors()
    assert ends.keys() == others.keys()
    assert all(np.array_equal(ends[name], others[name]) for name in ends)
    assert not np.array_equal(kept["online/look.weight"], ends["online/look.weight"])


def test_mixed_precision_learns_nearly_the_same() -> None:
    full, mixed = learner(precision="full"), learner(precision="mixed")
    for update in range(5):
        one, other = (each.update(batch(seed=update), 0.0) for each in (full, mixed))
        assert other[0] == pytest.approx(one[0], rel=0.1)
        np.testing.assert_allclose(other[1], one[1], atol=0.05)
    assert (full.mixed, mixed.mixed) == (False, True)
    assert all(parameter.dtype == torch.float32 for parameter in mixed.online.parameters())


@pytest.mark.parametrize(
    ("capabilities", "expected"),
    [({"avx512_bf16": True}, True), ({"amx_bf16": True}, True), ({"avx2": True}, False), (None, False)],
)
def test_auto_mixes_where_torch_tells_that_the_processor_is_made_for_it(
    capabilities: dict[str, bool] | None, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: capabilities, raising=False)
    if capabilities is None:
        monkeypatch.delattr(torch.cpu, "get_capabilities")
    assert learner(precision="auto").mixed == expected


def test_a_gpu_that_is_not_there_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert learner(device="auto").device.type == "cpu"
    with pytest.raises(InputError, match="found none; set device to 'cpu'"):
        learner(device="cuda")

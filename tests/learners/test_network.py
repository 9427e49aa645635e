"""The dueling network and its compiled twin."""

from __future__ import annotations

import numpy as np
import torch

from indoor_explorers.learners.dddqn.inference import SHAPES, q_values, weights_from
from indoor_explorers.learners.dddqn.network import duel, new_network
from indoor_explorers.learners.dddqn.observation import MOVE_FEATURES, SCENE


def inputs(size: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    scene = rng.integers(0, 256, (size, SCENE), dtype=np.uint8)
    return scene, rng.random((size, 4, len(MOVE_FEATURES)), dtype=np.float32)


def test_the_mean_advantage_is_over_the_actions() -> None:
    value_B1 = torch.tensor([[1.0], [2.0]])
    advantage_BA = torch.tensor([[4.0, 0.0, 0.0, 0.0], [0.0, 8.0, 0.0, 0.0]])
    expected = torch.tensor([[4.0, 0.0, 0.0, 0.0], [0.0, 8.0, 0.0, 0.0]])
    assert torch.equal(duel(value_B1, advantage_BA), expected)
    assert torch.equal(duel(value_B1, advantage_BA).mean(dim=1, keepdim=True), value_B1)


def test_one_sample_of_a_batch_never_changes_anothers_values() -> None:
    scene, moves = (torch.from_numpy(array).float() for array in inputs(8))
    network = new_network(1)
    before = network(scene / 255, moves)
    scene[3], moves[3] = 0.0, 9.0
    after = network(scene / 255, moves)
    others = torch.arange(8) != 3
    assert torch.equal(before[others], after[others])
    assert not torch.equal(before[3], after[3])


def test_the_network_depends_on_its_seed_alone_and_leaves_the_global_generator() -> None:
    torch.manual_seed(1)
    first = new_network(7).look.weight
    drawn = torch.rand(1)
    torch.manual_seed(1)
    assert torch.equal(torch.rand(1), drawn)
    assert torch.equal(new_network(7).look.weight, first)
    assert not torch.equal(new_network(8).look.weight, first)


def test_the_compiled_network_equals_the_torch_network() -> None:
    scene, moves = inputs(16)
    network = new_network(2)
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.add_(torch.randn_like(parameter), alpha=0.05)
        expected = network(torch.from_numpy(scene).float() / 255, torch.from_numpy(moves)).numpy()
    arrays = {name: value.numpy() for name, value in network.state_dict().items()}
    assert {name: array.shape for name, array in arrays.items()} == dict(SHAPES)
    q = np.empty((16, 4), np.float32)
    q_values(scene, moves, weights_from(arrays), q)
    np.testing.assert_allclose(q, expected, rtol=1e-4, atol=1e-4)


def test_the_compiled_network_gives_a_row_the_same_bits_in_any_batch() -> None:
    scene, moves = inputs(16)
    weights = weights_from({name: value.numpy() for name, value in new_network(2).state_dict().items()})
    together, alone = np.empty((16, 4), np.float32), np.empty((16, 4), np.float32)
    q_values(scene, moves, weights, together)
    for b in range(16):
        q_values(scene[b : b + 1], moves[b : b + 1], weights, alone[b : b + 1])
    assert np.array_equal(together, alone)

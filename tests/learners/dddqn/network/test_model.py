"""The dueling network, its switches and its compiled twin."""

import itertools
from typing import Any

import numpy as np
import pytest
import torch

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.inference import q_values, shapes, weights_from
from indoor_explorers.learners.dddqn.network.model import DuelingNetwork, NoisyLinear, arrays, duel, new_network
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import TOURS, observation_layout

SMALL = observation_layout(ObservationConfig(crop=5, coarse=3, layers=("unknown",), tours=False))
NARROW = NetworkConfig(width=32, move_width=4)
SWITCHES = [
    NetworkConfig(width=24, move_width=3, layer_norm=norm, dueling=dueling, noisy=noisy)
    for norm, dueling, noisy in itertools.product((True, False), repeat=3)
]
ENCODERS = [
    NetworkConfig(width=24, move_width=3, encoder="convolution"),
    NetworkConfig(width=24, move_width=3, encoder="attention", residual_blocks=1),
    NetworkConfig(width=24, move_width=3, residual_blocks=2, layer_norm=False),
]


def inputs(size: int, layout=SMALL) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    scenes = rng.integers(0, 256, (size, layout.inputs), dtype=np.uint8)
    scenes[rng.random(scenes.shape) < 0.5] = 0
    return scenes, rng.random((size, 4, layout.features), dtype=np.float32)


def q_of(network: DuelingNetwork, scenes: np.ndarray, moves: np.ndarray) -> torch.Tensor:
    with torch.no_grad():
        q_BA: torch.Tensor = network(torch.from_numpy(scenes).float() / 255, torch.from_numpy(moves))
    return q_BA


def noisy_layers(network: DuelingNetwork) -> list[NoisyLinear]:
    return [layer for layer in (network.think, network.value, network.advantage) if isinstance(layer, NoisyLinear)]


def shaken(network: DuelingNetwork) -> DuelingNetwork:
    """Move all weights away from where they begin, biases of 0 and scales of 1 among them."""
    generator = torch.Generator().manual_seed(3)
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.add_(torch.randn(parameter.shape, generator=generator), alpha=0.05)
    return network


def test_the_mean_advantage_is_over_the_actions() -> None:
    value_B1 = torch.tensor([[1.0], [2.0]])
    advantage_BA = torch.tensor([[4.0, 0.0, 0.0, 0.0], [0.0, 8.0, 0.0, 0.0]])
    expected = torch.tensor([[4.0, 0.0, 0.0, 0.0], [0.0, 8.0, 0.0, 0.0]])
    assert torch.equal(duel(value_B1, advantage_BA), expected)
    assert torch.equal(duel(value_B1, advantage_BA).mean(dim=1, keepdim=True), value_B1)


def test_one_sample_of_a_batch_never_changes_anothers_values() -> None:
    scenes, moves = inputs(8)
    network = new_network(SMALL, NARROW, 1)
    before = q_of(network, scenes, moves)
    scenes[3], moves[3] = 0, 9.0
    after = q_of(network, scenes, moves)
    others = torch.arange(8) != 3
    assert torch.equal(before[others], after[others])
    assert not torch.equal(before[3], after[3])


def test_the_network_depends_on_its_seed_alone_and_leaves_the_global_generator() -> None:
    torch.manual_seed(1)
    first = new_network(SMALL, NARROW, 7).look.weight
    drawn = torch.rand(1)
    torch.manual_seed(1)
    assert torch.equal(torch.rand(1), drawn)
    assert torch.equal(new_network(SMALL, NARROW, 7).look.weight, first)
    assert not torch.equal(new_network(SMALL, NARROW, 8).look.weight, first)


@pytest.mark.parametrize(
    ("config", "crop"), [*((config, 5) for config in SWITCHES), *((config, 9) for config in ENCODERS)], ids=str
)
@pytest.mark.parametrize("frames", [1, 3])
def test_the_compiled_network_equals_the_torch_network(config: NetworkConfig, crop: int, frames: int) -> None:
    layout = observation_layout(ObservationConfig(crop=crop, coarse=3, layers=("unknown", "mates"), frames=frames))
    scenes, moves = inputs(16, layout)
    network = shaken(new_network(layout, config, 2))
    network.draw_noise(torch.Generator().manual_seed(1))
    found = arrays(network)
    assert {name: array.shape for name, array in found.items()} == shapes(layout, config)
    q = np.empty((16, 4), np.float32)
    q_values(scenes, moves, weights_from(found, layout, config), q)
    np.testing.assert_allclose(q, q_of(network.eval(), scenes, moves).numpy(), rtol=1e-4, atol=1e-4)


def test_the_compiled_network_gives_a_row_the_same_bits_in_any_batch() -> None:
    scenes, moves = inputs(16)
    weights = weights_from(arrays(new_network(SMALL, NARROW, 2)), SMALL, NARROW)
    together, alone = np.empty((16, 4), np.float32), np.empty((16, 4), np.float32)
    q_values(scenes, moves, weights, together)
    for b in range(16):
        q_values(scenes[b : b + 1], moves[b : b + 1], weights, alone[b : b + 1])
    assert np.array_equal(together, alone)


@pytest.mark.parametrize(
    ("encoder", "crop", "message"), [("convolution", 3, "at least 5"), ("attention", 5, "multiple of 3")]
)
def test_a_map_that_does_not_fit_the_encoder_is_refused(encoder: Any, crop: int, message: str) -> None:
    layout = observation_layout(ObservationConfig(crop=crop))
    with pytest.raises(InputError, match=message):
        new_network(layout, NetworkConfig(encoder=encoder), 1)
    with pytest.raises(InputError, match=message):
        shapes(layout, NetworkConfig(encoder=encoder))
    with pytest.raises(ValueError, match=message):
        TrainingConfig(observation=ObservationConfig(crop=crop), network=NetworkConfig(encoder=encoder))


def test_without_dueling_the_last_layer_gives_the_values_themselves() -> None:
    scenes, moves = inputs(8)
    network = new_network(SMALL, NARROW.model_copy(update={"dueling": False}), 1)
    before = q_of(network, scenes, moves)
    with torch.no_grad():
        network.advantage.bias[2] += 1.0
    after = q_of(network, scenes, moves)
    assert torch.allclose(after - before, torch.tensor([0.0, 0.0, 1.0, 0.0]).expand(8, 4), atol=1e-5)
    assert "value.weight" not in arrays(network)


def test_at_first_the_network_flies_the_tours() -> None:
    layout = observation_layout(ObservationConfig(crop=5, coarse=3, layers=("unknown",)))
    scenes, moves = inputs(8, layout)
    q = q_of(new_network(layout, NARROW.model_copy(update={"tour_cost": 0.25}), 1), scenes, moves)
    beyond = [layout.tours_at + k for k, name in enumerate(TOURS) if "beyond the shortest" in name]
    assert len(beyond) == 2
    cost = torch.from_numpy(0.25 * 8 * moves[:, :, beyond].sum(axis=2))
    assert torch.allclose(q - q[:, :1], cost[:, :1] - cost, atol=1e-5)
    for switched_off in (
        new_network(SMALL, NARROW, 1),
        new_network(layout, NARROW.model_copy(update={"tour_cost": 0}), 1),
    ):
        assert switched_off.tours is None
        assert switched_off.advantage.weight.abs().sum() > 0


def test_layer_norm_makes_the_scale_of_the_first_layer_irrelevant() -> None:
    scenes, moves = inputs(8)
    for norm in (True, False):
        network = new_network(SMALL, NARROW.model_copy(update={"layer_norm": norm}), 1)
        before = q_of(network, scenes, moves)
        with torch.no_grad():
            network.look.weight.mul_(3.0)
            network.look.bias.mul_(3.0)
        assert torch.allclose(q_of(network, scenes, moves), before, atol=1e-3) == norm


def test_noise_is_there_in_training_alone_and_has_the_stated_spread() -> None:
    scenes, moves = inputs(8)
    noisy = new_network(SMALL, NARROW.model_copy(update={"noisy": True}), 1)
    generator = torch.Generator().manual_seed(5)
    means = q_of(noisy.eval(), scenes, moves)
    draws, last = [], noisy_layers(noisy)[-1]
    for _ in range(3000):
        noisy.draw_noise(generator)
        draws.append(torch.outer(last.noise_out, last.noise_in))
    assert torch.equal(q_of(noisy, scenes, moves), means)
    noise = torch.stack(draws)
    # |x| of a normal variable has mean sqrt(2 / pi): so has the variance of sgn(x) sqrt|x|, and a product its square.
    assert noise.var().item() == pytest.approx(2 / np.pi, rel=0.03)
    assert noise.mean(dim=0).abs().max() < 0.1
    assert torch.allclose(last.weight_sigma, torch.tensor(0.5 / 32**0.5))
    first = q_of(noisy.train(), scenes, moves)
    assert torch.equal(q_of(noisy, scenes, moves), first)
    noisy.draw_noise(generator)
    assert not torch.allclose(q_of(noisy, scenes, moves), first)


def test_the_spread_of_the_noise_is_learned() -> None:
    scenes, moves = inputs(8)
    noisy = new_network(SMALL, NARROW.model_copy(update={"noisy": True}), 1)
    noisy.draw_noise(torch.Generator().manual_seed(5))
    noisy(torch.from_numpy(scenes).float() / 255, torch.from_numpy(moves)).square().mean().backward()
    gradients = [layer.weight_sigma.grad for layer in noisy_layers(noisy)]
    assert len(gradients) == 3
    assert all(gradient is not None and gradient.abs().sum() > 0 for gradient in gradients)


@pytest.mark.parametrize("config", SWITCHES, ids=str)
def test_mixed_precision_stays_near_full_precision(config: NetworkConfig) -> None:
    scenes, moves = inputs(32)
    network = shaken(new_network(SMALL, config, 2))
    network.draw_noise(torch.Generator().manual_seed(1))
    full = q_of(network, scenes, moves)
    with torch.autocast("cpu", torch.bfloat16):
        mixed = q_of(network, scenes, moves)
    assert mixed.dtype == torch.float32
    assert not torch.equal(mixed, full)
    assert (mixed - full).abs().max() < 0.05 * full.abs().max()

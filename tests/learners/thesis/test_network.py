"""The thesis's network: its layers, its two ways to take the mean advantage, and its compiled forward pass."""

import numpy as np
import pytest
import torch

from indoor_explorers.env import InputError
from indoor_explorers.learners.thesis.inference import ImageFormat, q_values, weights_from
from indoor_explorers.learners.thesis.learner import duel, new_network
from indoor_explorers.learners.thesis.observation import LEVELS

from .rooms import MENDED_FORMAT, THESIS


def images(image_format, size=5):
    codes = np.random.default_rng(2).integers(
        0, 5, (size, image_format.frames, image_format.height, image_format.width), dtype=np.uint8
    )
    return codes, torch.from_numpy(LEVELS[codes])


def test_the_layers_are_those_of_the_thesis():
    network = new_network(THESIS, "batch", 1)
    shapes = {name: tuple(value.shape) for name, value in network.state_dict().items()}
    assert shapes == THESIS.shapes()
    assert [shapes[f"convolutions.{k}.weight"] for k in range(3)] == [(32, 1, 8, 8), (64, 32, 4, 4), (64, 64, 3, 3)]
    assert (shapes["first.weight"], shapes["second.weight"]) == ((1024, 64), (512, 1024))
    assert (shapes["value.weight"], shapes["advantage.weight"]) == ((1, 512), (4, 512))
    assert sum(value.numel() for value in network.state_dict().values()) == 665_765


def test_the_sizes_after_each_convolution():
    sizes, x = [], images(THESIS, 1)[1]
    for layer in new_network(THESIS, "batch", 1).convolutions:
        x = layer(x)
        sizes.append(tuple(x.shape[1:]))
    assert sizes == [(32, 9, 9), (64, 3, 3), (64, 1, 1)]


def test_too_small_a_map_is_refused():
    assert ImageFormat(15, 15, 1, False).view() == (1, 1)
    with pytest.raises(InputError, match="expected a map of at least 15 x 15 cells, got 14 x 16"):
        new_network(ImageFormat(14, 16, 1, False), "batch", 1)


def test_the_mean_advantage_over_the_actions_and_over_the_batch():
    value_B1, advantage_BA = torch.tensor([[1.0], [2.0]]), torch.tensor([[4.0, 0, 0, 0], [0, 8.0, 0, 0]])
    assert duel(value_B1, advantage_BA, "actions").tolist() == [[4.0, 0, 0, 0], [0, 8.0, 0, 0]]
    assert duel(value_B1, advantage_BA, "batch").tolist() == [[3.5, -0.5, -0.5, -0.5], [0.5, 8.5, 0.5, 0.5]]
    assert torch.equal(duel(value_B1[:1], advantage_BA[:1], "batch"), duel(value_B1[:1], advantage_BA[:1], "actions"))


@pytest.mark.parametrize(("mean", "alone"), [("batch", False), ("actions", True)])
def test_only_the_mistake_makes_values_depend_on_the_rest_of_the_batch(mean, alone):
    network, (_, x) = new_network(THESIS, mean, 1), images(THESIS)
    before = network(x)[:2]
    x[3] = 9.0
    assert torch.equal(before, network(x)[:2]) is alone


def test_the_network_depends_on_its_seed_alone():
    torch.manual_seed(1)
    first = new_network(THESIS, "batch", 7).state_dict()
    torch.manual_seed(2)
    state = torch.random.get_rng_state()
    second = new_network(THESIS, "actions", 7).state_dict()
    assert all(torch.equal(first[name], second[name]) for name in first)
    assert torch.equal(state, torch.random.get_rng_state())
    assert all(not first[name].any() for name in first if name.endswith("bias"))


@pytest.mark.parametrize("image_format", [THESIS, MENDED_FORMAT, ImageFormat(24, 33, 2, False)])
def test_the_compiled_twin_gives_the_same_values(image_format):
    network, (codes, x) = new_network(image_format, "actions", 3), images(image_format)
    for parameter in network.parameters():
        parameter.data += 0.01 * torch.randn(parameter.shape, generator=torch.Generator().manual_seed(1))
    arrays = {name: value.numpy() for name, value in network.state_dict().items()}
    q_BA = np.empty((len(codes), 4), np.float32)
    q_values(codes, LEVELS, weights_from(arrays, image_format.view()), q_BA)
    assert np.allclose(q_BA, network(x).detach().numpy(), rtol=1e-4, atol=1e-5)

from pathlib import Path

import numpy as np
import pytest
import torch

from indoor_explorers.env import InputError
from indoor_explorers.learners.places.model import AdvantageNet, Batch, load_into, weights_of
from indoor_explorers.learners.places.network import WIDTH, Loaded, load_weights, shapes, values, write_weights
from indoor_explorers.learners.places.truth import TRUE_COMMON, TRUE_PLACE
from indoor_explorers.planners.toolbox.networks.tensors import write_tensors
from tests.learners.places.small import random_scene, with_some_options


def some_network(seed: int = 0, width: int = WIDTH, options: bool = False) -> AdvantageNet:
    torch.manual_seed(seed)
    network = AdvantageNet(width, options=options, prior=0.5)
    torch.nn.init.normal_(network.out.weight)
    if options:
        torch.nn.init.normal_(network.option_out.weight)
    return network


@pytest.mark.parametrize("options", [False, True])
def test_it_computes_what_torch_computes(options: bool) -> None:
    network, scene = some_network(options=options), random_scene(5)
    scene = with_some_options(scene) if options else scene
    padded = [np.zeros((1, 12, *each.shape[1:]), np.float32) for each in (scene.places, scene.costs)]
    padded[0][0, :5], padded[1][0, :5] = scene.places, scene.costs
    there = torch.cat([torch.arange(12) < 5, torch.from_numpy(np.isfinite(scene.rules))])[None]
    places, costs = map(torch.from_numpy, padded)
    nothing = torch.zeros(1, 12, TRUE_PLACE), torch.zeros(1, TRUE_COMMON)
    batch = Batch(places, torch.from_numpy(scene.common)[None], there, costs, *nothing)
    with torch.no_grad():
        whole = network(batch)[0].numpy()
    assert (whole[5:12] == 0.0).all()
    expected = np.concatenate([whole[:5] - 0.5 * scene.costs, whole[12:] + scene.rules])
    found = values(scene, Loaded(weights_of(network), 0.5, guess=True, others=True, options=options))
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-4)
    assert len(found) == 5 + 3 * options


def test_options_are_compared_with_the_best_place() -> None:
    """Whatever the level of the places' values, rules of a silent network decide."""
    network = some_network(options=True)
    torch.nn.init.zeros_(network.option_out.weight)
    torch.nn.init.constant_(network.out.bias, 100.0)
    found = values(
        with_some_options(random_scene(5)), Loaded(weights_of(network), 0.5, guess=True, others=True, options=True)
    )
    np.testing.assert_allclose(found[5:] - found[:5].max(), [0.5, -np.inf, 2.0], atol=1e-4)


def test_the_order_of_the_places_does_not_matter() -> None:
    loaded, scene = Loaded(weights_of(some_network()), 0.5, guess=True, others=True), random_scene(6)
    order = np.array([3, 0, 5, 1, 4, 2])
    mixed = scene._replace(places=scene.places[order], costs=scene.costs[order])
    np.testing.assert_allclose(values(mixed, loaded), values(scene, loaded)[order], rtol=1e-5)


@pytest.mark.parametrize(("width", "options"), [(WIDTH, False), (24, False), (24, True)])
def test_weights_are_kept_in_files(tmp_path: Path, width: int, options: bool) -> None:
    weights = weights_of(some_network(width=width, options=options))
    loaded = Loaded(weights, 0.25, guess=False, others=True, lookouts=8, options=options)
    write_weights(tmp_path / "a.safetensors", loaded)
    found = load_weights(tmp_path / "a.safetensors")
    assert found[1:] == loaded[1:]
    assert all(np.array_equal(a, b) for a, b in zip(found.weights, loaded.weights, strict=True))
    again = some_network(1, width, options)
    load_into(again, found.weights)
    assert all(np.array_equal(a, b) for a, b in zip(weights_of(again), loaded.weights, strict=True))


def test_other_networks_are_refused(tmp_path: Path) -> None:
    arrays = {name: np.zeros(shape, np.float32) for name, shape in shapes().items()}
    write_tensors(tmp_path / "no-about.safetensors", arrays)
    write_tensors(tmp_path / "other.safetensors", {"out": arrays["out"]}, {"about": "{}"})
    for name in ("no-about", "other", "missing"):
        with pytest.raises(InputError, match=rf"{name}.safetensors: expected"):
            load_weights(tmp_path / f"{name}.safetensors")

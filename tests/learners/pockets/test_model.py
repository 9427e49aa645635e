import numpy as np
import pytest
import torch

from indoor_explorers.learners.pockets.learning import PocketNet
from indoor_explorers.learners.sessions.networks import network_arrays as arrays
from indoor_explorers.planners.toolbox.pockets.features import LEVELS, PLAIN, Kind
from indoor_explorers.planners.toolbox.pockets.network import outputs, shapes, weights_from


@pytest.mark.parametrize("kind", [PLAIN, LEVELS])
def test_the_compiled_network_computes_what_torch_does(kind: Kind) -> None:
    torch.manual_seed(0)
    network, rng, levels = PocketNet(kind), np.random.default_rng(0), kind.levels
    assert {name: array.shape for name, array in arrays(network).items()} == shapes(kind)
    fine = rng.integers(0, 2, (7, 5 * levels, 25, 25)).astype(np.uint8)
    fine[:, 4::5] = rng.integers(0, 256, (7, levels, 25, 25))
    coarse = rng.integers(0, 10, (7, 2 * levels, 25, 25)).astype(np.uint8)
    numbers = rng.random((7, kind.numbers)).astype(np.float32)
    with torch.no_grad():
        expected = network(*map(torch.from_numpy, (fine, coarse, numbers))).numpy()
    np.testing.assert_allclose(outputs(fine, coarse, numbers, weights_from(arrays(network))), expected, atol=1e-5)

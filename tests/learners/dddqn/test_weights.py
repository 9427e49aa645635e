"""Weights files: their content, and the errors about other files."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.learners.dddqn import weights as module
from indoor_explorers.learners.dddqn.network.config import NetworkConfig
from indoor_explorers.learners.dddqn.network.model import arrays, new_network
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import observation_layout
from indoor_explorers.learners.dddqn.observation.map_prior import prior_arrays
from indoor_explorers.learners.dddqn.weights import FORMAT, load_weights, shipped, write_weights
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors
from indoor_explorers.planners.toolbox.networks.weights_file import ABOUT
from tests.learners.dddqn.rooms import some_prior

PLAIN = ObservationConfig(crop=5, coarse=3, layers=("unknown",), tours=False)
NETWORK = NetworkConfig(width=16, move_width=4, noisy=True)


def network_arrays(seed: int = 1) -> dict[str, NDArray[np.float32]]:
    return arrays(new_network(observation_layout(PLAIN), NETWORK, seed))


def prior() -> dict[str, NDArray[np.float32]]:
    return prior_arrays(some_prior())


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    write_weights(tmp_path / "plain.safetensors", network_arrays(), {}, PLAIN, NETWORK)
    return tmp_path / "plain.safetensors"


def test_a_file_tells_all_that_flying_needs(tmp_path: Path) -> None:
    observation = PLAIN.model_copy(update={"layers": ("unknown", "chance"), "frames": 2})
    own = arrays(new_network(observation_layout(observation), NETWORK, 1))
    write_weights(tmp_path / "w.safetensors", own, prior(), observation, NETWORK)
    loaded = load_weights(tmp_path / "w.safetensors")
    assert (loaded.observation, loaded.network, loaded.layout) == (
        observation,
        NETWORK,
        observation_layout(observation),
    )
    assert np.array_equal(loaded.weights.look, own["look.weight"].T)
    assert loaded.prior.keys() == prior().keys()
    assert all(np.array_equal(loaded.prior[name], array) for name, array in prior().items())


def test_shipped_weights_are_found_by_name(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_FOLDER", plain.parent)
    plain.with_suffix(".json").write_text("{}", encoding="utf-8")
    assert shipped() == {"plain": plain}


def refused(path: Path, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        load_weights(path)
    assert str(caught.value).startswith(f"{path}: expected ")
    assert "\n" not in str(caught.value)


def test_a_file_that_does_not_describe_itself_is_refused(plain: Path) -> None:
    tensors, metadata = read_tensors(plain)
    about = json.loads(metadata[ABOUT])
    for changed, match in (
        ({}, "'format'"),
        (about | {"format": 7}, "format 7 instead of 2"),
        ({"format": FORMAT, "network": about["network"]}, "'observation'"),
        (about | {"network": "wide"}, "does not know"),
        (about | {"network": {"depth": 3}}, "depth "),
    ):
        path = plain.with_name(f"{len(str(changed))}.safetensors")
        write_tensors(path, tensors, {ABOUT: json.dumps(changed)})
        refused(path, f"{match}.*train again with this version")


def test_another_network_than_the_one_described_is_refused(plain: Path) -> None:
    path, own = plain.with_name("other.safetensors"), network_arrays()
    seeing = PLAIN.model_copy(update={"layers": ("chance",)})
    for stamp, (found, priors, observation, match) in enumerate(
        (
            (own | {"look.bias": own["look.weight"]}, {}, PLAIN, r"dddqn with 'look.bias' of shape \(16,\), got"),
            (own, {"prior.out": own["look.bias"]}, PLAIN, r"with 'prior.hidden' of shape \(147, 32\), got none"),
            (own, prior() | {"prior.out": np.zeros(8, np.float32)}, seeing, "with 'prior.out' of shape"),
        )
    ):
        write_weights(path, found, priors, observation, NETWORK)
        os.utime(path, ns=(stamp, stamp))
        refused(path, match)

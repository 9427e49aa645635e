"""Weights files: what they hold, and what is said of those that hold something else."""

from __future__ import annotations

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
from indoor_explorers.learners.dddqn.weights import (
    ABOUT,
    load_weights,
    shipped,
    write_weights,
)
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors, write_tensors
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


def test_half_the_size_gives_nearly_the_same_numbers(plain: Path) -> None:
    halved = plain.with_name("half.safetensors")
    write_weights(halved, network_arrays(), {}, PLAIN, NETWORK, half=True)
    full, half = load_weights(plain).weights, load_weights(halved).weights
    assert halved.stat().st_size < 0.6 * plain.stat().st_size
    assert half.look.dtype == np.float32
    np.testing.assert_allclose(half.look, full.look, rtol=1e-3, atol=1e-6)


def test_a_file_is_read_once_until_it_changes(plain: Path) -> None:
    first = load_weights(plain)
    assert load_weights(plain) is first
    write_weights(plain, network_arrays(2), {}, PLAIN, NETWORK)
    os.utime(plain, ns=(1, 1))
    assert not np.array_equal(load_weights(plain).weights.look, first.weights.look)


def test_what_ships_is_found_by_name(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_FOLDER", plain.parent)
    plain.with_suffix(".json").write_text("{}", encoding="utf-8")
    assert shipped() == {"plain": plain}


def refused(path: Path, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        load_weights(path)
    assert str(caught.value).startswith(f"{path}: expected ")
    assert "\n" not in str(caught.value)


def test_a_missing_a_damaged_and_a_huge_file_are_refused(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused(plain.with_name("none.safetensors"), "found none")
    damaged = plain.with_name("damaged.safetensors")
    damaged.write_bytes(plain.read_bytes()[:100])
    refused(damaged, "got something else")
    monkeypatch.setattr(module, "MOST_BYTES", 1000)
    os.utime(plain, ns=(2, 2))
    refused(plain, "not a checkpoint")


def test_a_file_that_does_not_describe_itself_is_refused(plain: Path) -> None:
    tensors, metadata = read_tensors(plain)
    about = json.loads(metadata[ABOUT])
    for changed, match in (
        ({}, "got a file without a format; .*train again with this version"),
        (about | {"format": 7}, "got 7"),
        ({"format": module.FORMAT, "network": about["network"]}, "'observation'"),
        (about | {"network": "wide"}, "train again with this version"),
        (about | {"network": {"depth": 3}}, "depth .*train again with this version"),
    ):
        path = plain.with_name(f"{len(match)}.safetensors")
        write_tensors(path, tensors, {ABOUT: json.dumps(changed)})
        refused(path, match)
    broken = plain.with_name("broken.safetensors")
    write_tensors(broken, tensors, {ABOUT: "{"})
    refused(broken, "train again with this version")


def test_another_network_than_the_one_described_is_refused(plain: Path) -> None:
    path, own = plain.with_name("other.safetensors"), network_arrays()
    seeing = PLAIN.model_copy(update={"layers": ("chance",)})
    without = {name: array for name, array in own.items() if name != "look.bias"}
    for stamp, (found, priors, observation, match) in enumerate(
        (
            (without, {}, PLAIN, "'look.bias' is missing"),
            (own | {"more": own["look.bias"]}, {}, PLAIN, "'more' is unknown"),
            (own | {"look.bias": own["look.weight"]}, {}, PLAIN, r"'look.bias' to be numbers of shape \(16,\), got"),
            (own, {"prior.out": own["look.bias"]}, PLAIN, "'prior.hidden' is missing"),
            (own, prior() | {"prior.out": np.zeros(8, np.float32)}, seeing, "'prior.out' to be numbers of shape"),
        )
    ):
        write_weights(path, found, priors, observation, NETWORK)
        os.utime(path, ns=(stamp, stamp))
        refused(path, match)


def test_whole_numbers_are_no_weights(plain: Path) -> None:
    tensors, metadata = read_tensors(plain)
    write_tensors(plain, {name: array.astype(np.int32) for name, array in tensors.items()}, metadata)
    os.utime(plain, ns=(3, 3))
    refused(plain, "got int32")

"""Weights files: what they hold, and what is said of those that hold something else."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.registry import make_policy
from indoor_explorers.planners.toolbox.networks import weights_file as module
from indoor_explorers.planners.toolbox.networks.tensors import write_tensors
from indoor_explorers.planners.toolbox.networks.weights_file import (
    ABOUT,
    FORMER_ABOUT,
    read_once,
    read_weights_file,
    write_weights_file,
)

SHAPES = {"out.weight": (3, 2), "out.bias": (3,)}
DESCRIPTION = {"prior": 0.5}


def some_arrays(seed: int = 1) -> dict[str, NDArray[Any]]:
    rng = np.random.default_rng(seed)
    return {name: rng.normal(size=shape).astype(np.float32) for name, shape in SHAPES.items()}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_weights_file(tmp_path / "w.safetensors", some_arrays(), DESCRIPTION)
    return tmp_path / "w.safetensors"


def loaded(path: Path) -> tuple[Mapping[str, Any], dict[str, NDArray[np.float32]]]:
    file = read_weights_file(path, "this test")
    return file.about, file.checked(SHAPES)


def refused(path: Path, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        loaded(path)
    assert str(caught.value).startswith(f"{path}: expected ")
    assert "\n" not in str(caught.value)


def test_a_file_holds_arrays_and_what_else_is_needed(path: Path) -> None:
    about, arrays = loaded(path)
    assert about == DESCRIPTION
    assert list(arrays) == list(SHAPES)
    assert all(np.array_equal(arrays[name], array) for name, array in some_arrays().items())


def test_half_the_size_gives_nearly_the_same_numbers(path: Path) -> None:
    halved, many = path.with_name("half.safetensors"), {"out": np.random.default_rng(0).normal(size=1000)}
    write_weights_file(path, many, {})
    write_weights_file(halved, many, {}, half=True)
    assert halved.stat().st_size < 0.6 * path.stat().st_size
    found = read_weights_file(halved, "this test").checked({"out": (1000,)})["out"]
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, many["out"], rtol=1e-3, atol=1e-6)


def test_a_file_is_read_once_until_it_changes(path: Path) -> None:
    load = read_once(loaded)
    first = load(path)
    assert load(path) is first
    write_weights_file(path, some_arrays(2), DESCRIPTION)
    os.utime(path, ns=(1, 1))
    assert not np.array_equal(load(path)[1]["out.bias"], first[1]["out.bias"])


@pytest.mark.parametrize(
    ("metadata", "expected"),
    [
        (None, {}),
        ({FORMER_ABOUT: '{"height": 16}'}, {"height": 16}),
        ({ABOUT: '{"prior": 0.5}'}, {"prior": 0.5}),
    ],
)
def test_files_of_version_0_2_0_are_read(
    path: Path, metadata: dict[str, str] | None, expected: Mapping[str, Any]
) -> None:
    write_tensors(path, some_arrays(), metadata)
    assert loaded(path)[0] == expected


def test_a_missing_a_damaged_and_a_huge_file_are_refused(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused(path.with_name("none.safetensors"), "found none")
    damaged = path.with_name("damaged.safetensors")
    damaged.write_bytes(path.read_bytes()[:100])
    refused(damaged, "got something else")
    monkeypatch.setattr(module, "MOST_BYTES", 100)
    refused(path, "not a checkpoint")


@pytest.mark.parametrize("about", ["{", "7", "[3]", "null"])
def test_a_damaged_description_is_refused(path: Path, about: str) -> None:
    write_tensors(path, some_arrays(), {ABOUT: about})
    refused(path, "weights of this test with its description, got .*; give weights that its training wrote")


def test_what_a_network_cannot_read_is_refused_as_its_file(path: Path) -> None:
    with pytest.raises(InputError, match=r"w.safetensors: expected .*'guess'.*; give weights"):
        read_weights_file(path, "this test").described(lambda about: about["guess"])


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"out.bias": None}, r"with 'out.bias' of shape \(3,\), got none"),
        ({"out.bias": np.zeros(4, np.float32)}, r"with 'out.bias' of shape \(3,\), got float32 of shape \(4,\)"),
        ({"out.bias": np.zeros(3, np.int32)}, r"with 'out.bias' of shape \(3,\), got int32 of shape \(3,\)"),
        ({"more": np.zeros(4, np.float32)}, r"without 'more', got float32 of shape \(4,\)"),
    ],
)
def test_other_arrays_are_refused(path: Path, changed: dict[str, NDArray[Any] | None], match: str) -> None:
    arrays = {name: array for name, array in (some_arrays() | changed).items() if array is not None}
    write_tensors(path, arrays)
    refused(path, f"expected weights of this test {match}; give weights that its training wrote, or train again")


@pytest.mark.parametrize("name", ["dddqn-places", "dddqn", "dddqn-thesis"])
def test_a_path_that_is_none_is_told(name: str) -> None:
    with pytest.raises(InputError, match="expected a path, got 3"):
        make_policy(name, weights=3)

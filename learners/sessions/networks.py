"""Torch networks and the state of their optimiser as arrays, for checkpoints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch
from numpy.typing import NDArray
from torch import nn


def network_arrays(network: nn.Module) -> dict[str, NDArray[Any]]:
    """Return copies of the weights of a network by name, as torch stores them."""
    return {name: value.detach().cpu().numpy().copy() for name, value in network.state_dict().items()}


def learner_tensors(networks: Mapping[str, nn.Module], optimiser: torch.optim.Optimizer) -> dict[str, NDArray[Any]]:
    """Return copies of the weights of networks and of their optimiser's state, by name."""
    found: dict[str, NDArray[Any]] = {}
    for name, network in networks.items():
        found |= {f"{name}/{key}": array for key, array in network_arrays(network).items()}
    for place, entries in optimiser.state_dict()["state"].items():
        found |= {f"optimiser/{place}/{key}": value.cpu().numpy().copy() for key, value in entries.items()}
    return found


def restore_learner(
    tensors: Mapping[str, NDArray[Any]], networks: Mapping[str, nn.Module], optimiser: torch.optim.Optimizer
) -> None:
    """Restore the networks and the optimiser from the arrays of :func:`learner_tensors`."""
    for name, network in networks.items():
        network.load_state_dict({key: torch.from_numpy(tensors[f"{name}/{key}"]) for key in network.state_dict()})
    state: dict[int, dict[str, torch.Tensor]] = {}
    for name, array in tensors.items():
        if name.startswith("optimiser/"):
            _, place, key = name.split("/")
            state.setdefault(int(place), {})[key] = torch.from_numpy(array)
    optimiser.load_state_dict(optimiser.state_dict() | {"state": state})

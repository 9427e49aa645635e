"""The network that values flying home, without torch: outputs are the same, bit for bit, on every machine."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.learners.reports.situation import NUMBERS, Situation
from indoor_explorers.planners.toolbox.networks.layers import perceptron
from indoor_explorers.planners.toolbox.networks.weights_file import read_once, read_weights_file, write_weights_file

#: Units of each hidden layer.
WIDTH = 48


class NetworkWeights(NamedTuple):
    """Weights (inputs, outputs) and biases (outputs,) of the layers, float32."""

    first: NDArray[np.float32]
    first_bias: NDArray[np.float32]
    second: NDArray[np.float32]
    second_bias: NDArray[np.float32]
    out: NDArray[np.float32]
    out_bias: NDArray[np.float32]


def shapes() -> dict[str, tuple[int, ...]]:
    """Return the shapes of the weights by name."""
    sizes = {"first": (NUMBERS, WIDTH), "second": (WIDTH, WIDTH), "out": (WIDTH, 1)}
    biases = {f"{name}_bias": (shape[1],) for name, shape in sizes.items()}
    return {name: (sizes | biases)[name] for name in NetworkWeights._fields}


def value(situation: Situation, weights: NetworkWeights) -> float:
    """Return the value of flying home now beyond that of exploring on: the logarithm of the odds that it is better."""
    return situation.rule + float(perceptron(situation.numbers, *weights)[0])


def write_weights(path: Path, weights: NetworkWeights) -> None:
    """Write a weights file."""
    write_weights_file(path, weights._asdict(), {})


@read_once
def load_weights(path: Path) -> NetworkWeights:
    """Return the content of a weights file; a process reads the file once, and again when it changes.

    Raises :class:`InputError` if the file is missing or holds another network.
    """
    return NetworkWeights(**read_weights_file(path, "dddqn-reports").checked(shapes()))

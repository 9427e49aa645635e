"""The network that values places, without torch: outputs are the same, bit for bit, on every machine.

Each place goes through the same two layers, together with the numbers common to all; the mean and the maximum over the
places are inputs of the next layer for each (Zaheer et al. 2017, "Deep Sets", arXiv:1703.06114). So neither the order
of the places nor their number matters.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.learners.places.options import CLOSURE, OPTION_COMMON, Option
from indoor_explorers.learners.places.scene import Scene, input_sizes
from indoor_explorers.learners.reports.network import NetworkWeights as ReportsWeights
from indoor_explorers.planners.toolbox.networks.layers import linear, perceptron, relu
from indoor_explorers.planners.toolbox.networks.weights_file import read_once, read_weights_file, write_weights_file

#: Default width of every hidden layer.
WIDTH = 64


class NetworkWeights(NamedTuple):
    """Weights (inputs, outputs) and biases (outputs,) of the layers, float32."""

    first: NDArray[np.float32]
    first_bias: NDArray[np.float32]
    second: NDArray[np.float32]
    second_bias: NDArray[np.float32]
    joined: NDArray[np.float32]
    joined_bias: NDArray[np.float32]
    out: NDArray[np.float32]
    out_bias: NDArray[np.float32]


class OptionWeights(NamedTuple):
    """The same with the layers of the options, which see the mean and the maximum over the places."""

    first: NDArray[np.float32]
    first_bias: NDArray[np.float32]
    second: NDArray[np.float32]
    second_bias: NDArray[np.float32]
    joined: NDArray[np.float32]
    joined_bias: NDArray[np.float32]
    out: NDArray[np.float32]
    out_bias: NDArray[np.float32]
    option: NDArray[np.float32]
    option_bias: NDArray[np.float32]
    option_second: NDArray[np.float32]
    option_second_bias: NDArray[np.float32]
    option_out: NDArray[np.float32]
    option_out_bias: NDArray[np.float32]


Weights = NetworkWeights | OptionWeights


class Loaded(NamedTuple):
    """The content of a weights file."""

    weights: Weights
    prior: float
    """Weight of the planner's costs in the values of places."""
    guess: bool
    """Whether the network sees the estimates of the free space behind the clusters."""
    others: bool
    """Whether the network sees the other places beside each place."""
    lookouts: int = 0
    """Most places near the UAV that need not be at a frontier."""
    task: bool = False
    """Whether the network sees what is harder about the task, see :mod:`.task_inputs`."""
    options: bool = False
    """Whether the network values options beside the places, see :class:`~.options.Option`."""

    @property
    def width(self) -> int:
        """Units of each hidden layer."""
        return self.weights.second_bias.size


#: Fields of :class:`Loaded` that a file has only where they are set, as files of older versions have none of them.
_ONLY_IF_SET = ("lookouts", "task", "options")


def layout_of(options: bool) -> type[NetworkWeights] | type[OptionWeights]:
    """Return the named tuple of a network with or without options."""
    return OptionWeights if options else NetworkWeights


def shapes(width: int = WIDTH, task: bool = False, options: bool = False) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the weights by name, for hidden layers of ``width`` units.

    ``task`` and ``options`` tell whether there are the task's inputs, and options.
    """
    place, common = input_sizes(task, options)
    sizes = {"first": (place + common, width), "second": (width, width), "joined": (3 * width, width)}
    sizes |= {"out": (width, 1), "option": (2 * width + common, width), "option_second": (width, width)}
    sizes |= {"option_out": (width, len(Option))}
    biases = {f"{name}_bias": (shape[1],) for name, shape in sizes.items()}
    return {name: (sizes | biases)[name] for name in layout_of(options)._fields}


@kernel()
def _values(places: np.ndarray, common: np.ndarray, weights: Weights) -> tuple[np.ndarray, np.ndarray]:
    count, hidden = places.shape[0], weights.second.shape[0]
    inside, seen = np.empty((count, hidden), np.float32), np.empty(hidden, np.float32)
    row = np.empty(places.shape[1] + common.shape[0], np.float32)
    for k in range(count):
        row[: places.shape[1]], row[places.shape[1] :] = places[k], common
        linear(row, weights.first, weights.first_bias, seen)
        relu(seen)
        linear(seen, weights.second, weights.second_bias, inside[k])
        relu(inside[k])
    joined, values = np.zeros(3 * hidden, np.float32), np.empty(count, np.float32)
    for k in range(count):
        for j in range(hidden):
            joined[hidden + j] += inside[k, j] / np.float32(count)
            joined[2 * hidden + j] = max(joined[2 * hidden + j], inside[k, j])
    for k in range(count):
        joined[:hidden] = inside[k]
        linear(joined, weights.joined, weights.joined_bias, seen)
        relu(seen)
        linear(seen, weights.out, weights.out_bias, values[k : k + 1])
    return values, joined[hidden:]


def values(scene: Scene, loaded: Loaded) -> NDArray[np.float32]:
    """Return the values of the places of a scene: the network's, less the planner's costs, (K,).

    Behind them are those of the options, if the network has any: that of the best place, with the rules' and the
    network's values of preferring the option to it, (K + O,).
    """
    learned, pooled = _values(scene.places, scene.common, loaded.weights)
    of_places = np.asarray(learned - np.float32(loaded.prior) * scene.costs)
    if not isinstance(loaded.weights, OptionWeights):
        return of_places
    of_options = perceptron(np.concatenate([pooled, scene.common]), *loaded.weights[len(NetworkWeights._fields) :])
    return np.concatenate([of_places, of_places.max() + scene.rules + of_options])


def without_network(loaded: Loaded) -> Loaded:
    """Return weights by which the values of places are the planner's costs alone."""
    last = ("out", "out_bias", "option_out", "option_out_bias")
    silent = {name: np.zeros_like(array) for name, array in loaded.weights._asdict().items() if name in last}
    return loaded._replace(weights=loaded.weights._replace(**silent), prior=1.0)


def grown(loaded: Loaded, untrained: Weights, task: bool) -> Weights:
    """Return weights by which places have the same values, with the inputs and options of an untrained network.

    Nothing is made of inputs that ``loaded`` has not; ``task`` tells whether the untrained network sees the task's.
    """
    first = loaded.weights.first
    place, grown_place = input_sizes(loaded.task)[0], input_sizes(task)[0]
    unseen = np.zeros((len(untrained.first) - len(first), first.shape[1]), np.float32)
    of_places, of_all = np.split(unseen, [grown_place - place])
    known = {**loaded.weights._asdict(), "first": np.concatenate([first[:place], of_places, first[place:], of_all])}
    return untrained._replace(**known)


def reporting_as(reports: ReportsWeights, untrained: OptionWeights) -> OptionWeights:
    """Return weights by which a report has the value that a network of ``dddqn-reports`` gives it.

    That network's units are the first ones of each layer of the options, and see what they saw; the others are those
    of ``untrained``, so far without weight in any value.
    """
    width = reports.first_bias.size
    layers = {name: getattr(untrained, name).copy() for name in OptionWeights._fields if name.startswith("option")}
    situation = slice(len(layers["option"]) - OPTION_COMMON, len(layers["option"]) - CLOSURE)
    for name in ("option", "option_second"):
        layers[name][:, :width] = 0.0
    layers["option"][situation, :width], layers["option_bias"][:width] = reports.first, reports.first_bias
    layers["option_second"][:width, :width] = reports.second
    layers["option_second_bias"][:width] = reports.second_bias
    layers["option_out"][:width, Option.REPORT] = reports.out[:, 0]
    layers["option_out"][width:, Option.REPORT] = 0.0
    layers["option_out_bias"][Option.REPORT] = reports.out_bias[0]
    return untrained._replace(**layers)


def write_weights(path: Path, loaded: Loaded) -> None:
    """Write weights with the settings that flying them needs."""
    about = loaded._asdict()
    weights = about.pop("weights")
    about = {name: value for name, value in about.items() if value or name not in _ONLY_IF_SET}
    write_weights_file(path, weights._asdict(), about)


@read_once
def load_weights(path: Path) -> Loaded:
    """Return the content of a weights file; a process reads the file once, and again when it changes.

    Raises :class:`InputError` if the file is missing or holds another network.
    """
    file = read_weights_file(path, "dddqn-places")
    settings = file.described(
        lambda about: (
            float(about["prior"]),
            bool(about["guess"]),
            bool(about["others"]),
            int(about.get("lookouts", 0)),
            bool(about.get("task", False)),
            bool(about.get("options", False)),
        )
    )
    *_, task, options = settings
    width = file.arrays["second_bias"].size if "second_bias" in file.arrays else WIDTH
    return Loaded(layout_of(options)(**file.checked(shapes(width, task, options))), *settings)

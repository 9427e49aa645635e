"""Train the pocket network: fly planners over training maps, note what was behind each cluster, learn from that.

    python -m indoor_explorers.learners.pockets --suites floors,dungeons --data ~/maps --out results/pockets

Flights are kept in ``OUT/examples``, so that an interrupted run goes on where it was. ``OUT`` then has the weights and,
beside them, how they were made.
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded, written_whole
from indoor_explorers.env.provenance import source_commit, versions
from indoor_explorers.env.scenarios.suites.suite import Part
from indoor_explorers.learners.pockets.examples import read_examples, write_examples
from indoor_explorers.learners.pockets.maps import TrainingMaps, map_files
from indoor_explorers.learners.pockets.model import arrays
from indoor_explorers.learners.pockets.train import train
from indoor_explorers.learners.pockets.validation import as_table, judge
from indoor_explorers.planners.toolbox.networks.weights_file import write_weights_file

#: The file of the weights; a JSON file of the same name says how they were made.
NAME = "pockets"


def main(arguments: list[str] | None = None) -> int:
    """Run the training; return the exit status."""
    asked = _parser().parse_args(arguments)
    try:
        _train(asked)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m indoor_explorers.learners.pockets", description=__doc__)
    parser.add_argument("--suites", default="", help="suites whose train parts to learn from, besides generated maps")
    parser.add_argument("--data", type=expanded, nargs="+", default=[], help="clones of the repositories of the suites")
    parser.add_argument("--flights", type=int, default=1500, help="flights to learn from (default 1500)")
    parser.add_argument("--learn-from", choices=("both", "real", "generated"), default="both", help="of these flights")
    parser.add_argument("--epochs", type=int, default=8, help="passes over their examples (default 8)")
    parser.add_argument("--seed", type=int, default=1, help="of the network (default 1); flights have their numbers")
    parser.add_argument("--out", type=expanded, required=True, help="folder of examples and weights")
    return parser


def _train(asked: argparse.Namespace) -> None:
    names = [name for name in asked.suites.split(",") if name]
    paths = [path for name in names for path in map_files(name, Part.TRAIN, asked.data).paths]
    folder = asked.out / "examples"
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{seed}.npz" for seed in range(asked.flights)]
    maps = TrainingMaps(paths=tuple(paths))
    for seed, path in enumerate(files):
        write_examples(maps, path, seed)
        if (seed + 1) % 50 == 0:
            _tell(f"{seed + 1} of {asked.flights} flights")
    examples = chosen_examples(read_examples(files), asked.learn_from)
    losses: list[dict[str, float]] = []
    for network, epoch in train(examples, epochs=asked.epochs, seed=asked.seed):
        _tell(", ".join(f"{name} {value:.4g}" for name, value in epoch.items()))
        losses.append(epoch)
        write_weights_file(asked.out / f"{NAME}.safetensors", arrays(network), {})
    about: dict[str, Any] = {
        "command": " ".join(
            (
                f"python -m indoor_explorers.learners.pockets --suites {asked.suites} --data DIR",
                f"--flights {asked.flights} --learn-from {asked.learn_from}",
                f"--epochs {asked.epochs} --seed {asked.seed}",
            )
        ),
        "seed": asked.seed,
        "commit": source_commit(),
        "seen_maps": {"training": [f"{name}/train" for name in names]},
        "files": len(paths),
        "examples": len(examples["sizes"]),
        "losses": losses,
        "versions": versions(("python", "indoor-explorers", "numpy", "numba", "scipy", "torch")),
    }
    with written_whole(asked.out / f"{NAME}.json") as partial:
        partial.write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
    if "floors" in names:
        unseen = map_files("floors", Part.VALIDATION, asked.data)
        _tell(as_table(judge(unseen, asked.out / f"{NAME}.safetensors")))


def _tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def chosen_examples(examples: dict[str, NDArray[Any]], learn_from: str) -> dict[str, NDArray[Any]]:
    """Return the examples, each array (K, ...), of real maps, of generated ones, or of both."""
    if learn_from == "both":
        return examples
    chosen = examples["real"] == (learn_from == "real")
    return {name: each[chosen] for name, each in examples.items()}


if __name__ == "__main__":
    sys.exit(main())

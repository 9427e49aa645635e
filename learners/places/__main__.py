"""Train the network that chooses places: fly over training maps, learn from the choices, and again.

    python -m indoor_explorers.learners.places --suites floors,dungeons --data ~/maps --out results/places

``OUT`` has the network after each round and the flights of the present one, so that an interrupted run goes on where it
was; in the end the mean of the later networks and, beside it, how it was made.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded, written_whole
from indoor_explorers.env.provenance import source_commit, versions
from indoor_explorers.env.scenarios.suites.suite import Part
from indoor_explorers.learners.places.network import write_weights
from indoor_explorers.learners.places.rounds import Training
from indoor_explorers.learners.pockets.maps import TrainingMaps, map_files
from indoor_explorers.learners.sessions.process import one_thread

#: The file of the weights; a JSON file of the same name says how they were made.
NAME = "places"
#: The record of the rounds in the folder of a training.
ROUNDS = "rounds.json"


def main(arguments: list[str] | None = None) -> int:
    """Run the training; return the exit status."""
    asked = _parser().parse_args(arguments)
    try:
        with one_thread():
            _train(asked)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m indoor_explorers.learners.places", description=__doc__)
    parser.add_argument("--suites", default="", help="suites whose train parts to learn from, besides generated maps")
    parser.add_argument("--data", type=expanded, nargs="+", default=[], help="clones of the repositories of the suites")
    parser.add_argument("--rounds", type=int, default=3, help="rounds of flying and learning (default 3)")
    parser.add_argument("--flights", type=int, default=800, help="flights of a round (default 800)")
    parser.add_argument("--prior", type=float, default=0.45, help="weight of the planner's costs (default .45)")
    parser.add_argument("--no-guess", action="store_true", help="without estimates of what is behind the clusters")
    parser.add_argument("--no-others", action="store_true", help="without sight of the other places")
    parser.add_argument("--seed", type=int, default=1, help="of the training (default 1)")
    parser.add_argument("--workers", type=int, default=2, help="processes that fly (default 2)")
    parser.add_argument("--out", type=expanded, required=True, help="folder of flights and weights")
    return parser


def _train(asked: argparse.Namespace) -> None:
    names = [name for name in asked.suites.split(",") if name]
    paths = [path for name in names for path in map_files(name, Part.TRAIN, asked.data).paths]
    asked.out.mkdir(parents=True, exist_ok=True)
    training = Training(
        folder=asked.out,
        maps=TrainingMaps(paths=tuple(paths)),
        flights=asked.flights,
        rounds=asked.rounds,
        seed=asked.seed,
        prior=asked.prior,
        guess=not asked.no_guess,
        others=not asked.no_others,
        workers=asked.workers,
    )
    record = asked.out / ROUNDS
    rounds: list[dict[str, Any]] = json.loads(record.read_text("utf-8")) if record.exists() else []
    for figures in training.run(_tell):
        _tell(", ".join(f"{name} {value:g}" for name, value in figures.items()))
        rounds.append(figures)
        _write(record, rounds)
    write_weights(asked.out / f"{NAME}.safetensors", training.mean())
    about: dict[str, Any] = {
        "command": _command(asked),
        "seed": asked.seed,
        "commit": source_commit(),
        "seen_maps": {"training": [f"{name}/train" for name in names]},
        "files": len(paths),
        "rounds": rounds,
        "versions": versions(("python", "indoor-explorers", "numpy", "numba", "scipy", "torch")),
    }
    _write(asked.out / f"{NAME}.json", about)


def _command(asked: argparse.Namespace) -> str:
    words = ["python -m indoor_explorers.learners.places", f"--suites {asked.suites} --data DIR"]
    words += [f"--rounds {asked.rounds} --flights {asked.flights} --prior {asked.prior:g} --seed {asked.seed}"]
    words += ["--no-guess"] * asked.no_guess + ["--no-others"] * asked.no_others
    return " ".join(words)


def _write(path: Path, content: Any) -> None:
    with written_whole(path) as partial:
        partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())

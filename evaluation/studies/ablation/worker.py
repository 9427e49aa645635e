"""The process of one training; it reads the run as JSON from stdin."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

from indoor_explorers.env import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.scenarios.loading import named_scenario
from indoor_explorers.env.scenarios.validation import validated
from indoor_explorers.evaluation.studies.ablation.runs import STATE, TrainingRun, read_state
from indoor_explorers.evaluation.studies.training import find_learner, nested


def train_one(run: TrainingRun) -> None:
    """Train or resume; write the minutes, and at the end the weights, to the state file."""
    module = find_learner(run.learner)
    config = validated(module.TrainingConfig, nested(run.settings), f"settings of learner {run.learner!r}")
    before = read_state(run).get("minutes", 0.0)
    folder, began = Path(run.folder), time.monotonic()
    weights: Path | None = None
    try:
        weights = module.train(config, named_scenario(run.scenario), folder, seed=run.seed, resume=True)
    finally:
        if folder.is_dir():
            state: dict[str, Any] = {"order": run.identity, "minutes": before + (time.monotonic() - began) / 60}
            _write(folder / STATE, state if weights is None else state | {"weights": weights.name})


def _write(path: Path, state: dict[str, Any]) -> None:
    with written_whole(path) as partial:
        partial.write_text(json.dumps(state, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Train the run that stdin describes; returns the exit status."""
    try:
        train_one(TrainingRun(**json.load(sys.stdin)))
    except InputError as error:
        sys.stderr.write(" ".join(str(error).split()) + "\n")
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Trainings of a moment, and episodes flown beside the environments of a training."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import Policy
from indoor_explorers.evaluation.cli.parser import main
from tests.learners.dddqn.rooms import flight_of, small_room

#: Settings that every learner has, for a training of a moment.
TINY = ("side=5", "zones=2", "hidden=[16]", "evaluation_episodes=2", "evaluation_every=150", "checkpoint_every=150")


def train(learner: str, out: Path, *settings: str, team: int = 1, words: tuple[str, ...] = ()) -> int:
    """Train in a small room, as the command line does; return the exit status."""
    task = small_room().with_settings({"team": team, "radio.model": "square", "radio.range": 3.0})
    toml = out.parent / f"room-{team}.toml"
    toml.write_text(task.to_toml(), encoding="utf-8")
    scenario = ("--scenario", str(toml), "--out", str(out), "--seed", "3")
    return main(["train", "--learner", learner, *scenario, "--set", *TINY, *settings, *words])


def record_of(out: Path) -> Any:
    """Return what a folder says about its training."""
    return json.loads((out / "training.json").read_text(encoding="utf-8"))


def flown(policy: Policy, seeds: list[int], *, together: bool) -> NDArray[np.int64]:
    """Return the cells (T, B, N, 2) of short episodes of two UAVs, whose pilots act in one batch, or one by one."""
    return flight_of(policy, small_room().with_settings({"team": 2, "budget": 30}), seeds, together=together)

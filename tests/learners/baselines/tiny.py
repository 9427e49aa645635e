"""Trainings of a moment, and episodes flown beside the environments of a training."""

import json
import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import InputError, Policy, World, make_policy
from indoor_explorers.evaluation.cli.parser import main
from tests.learners.dddqn.rooms import cells_flown, small_room

#: Settings that every learner has, for a training of a moment.
TINY = ("side=5", "zones=2", "hidden=[16]", "evaluation_episodes=2", "evaluation_every=150", "checkpoint_every=150")


def train(learner: str, out: Path, *settings: str, team: int = 1, words: tuple[str, ...] = ()) -> int:
    """Train in a small room, as the command line does; return the exit status."""
    task = small_room().with_settings({"team": team, "radio.model": "square", "radio.range": 3.0})
    toml = out.parent / f"room-{team}.toml"
    toml.write_text(task.to_toml(), encoding="utf-8")
    scenario = ("--scenario", str(toml), "--out", str(out), "--seed", "3")
    return main(["train", "--learner", learner, *scenario, "--set", *TINY, *settings, *words])


def cut_and_resume(learner: str, out: Path, settings: tuple[str, ...], after: int, patch: pytest.MonkeyPatch) -> Any:
    """Interrupt a training by a Ctrl-C after some steps, fly its network, and resume it; return both records."""

    def interrupt(session: Any, trainee: Any) -> None:
        if trainee.steps >= after and session.checkpoint is None:
            os.kill(os.getpid(), signal.SIGINT)

    with patch.context() as patched:
        patched.setattr("indoor_explorers.learners.sessions.session.Session.report", interrupt)
        assert train(learner, out, *settings) == 130
    cut = record_of(out)
    make_policy(f"{learner.partition('-')[0]}:{out}")
    assert train(learner, out, *settings, words=("--resume",)) == 0
    return cut, record_of(out)


def refusal(use: str) -> str:
    """Return the line that says why a path is no policy."""
    with pytest.raises(InputError) as caught:
        make_policy(use)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def record_of(out: Path) -> Any:
    """Return what a folder says about its training."""
    return json.loads((out / "training.json").read_text(encoding="utf-8"))


def flown(policy: Policy, seeds: list[int]) -> NDArray[np.int64]:
    """Return the cells (T, B, 2, 2) of short episodes of two UAVs."""
    world = World(small_room().with_settings({"team": 2, "budget": 30}), len(seeds))
    world.reset(seeds)
    return cells_flown(policy, world)

"""The session around a training: schedules, the best network, resuming, and records written before."""

import itertools
import json
import os
import signal
from collections.abc import Mapping
from pathlib import Path

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.provenance import RECORD
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.sessions.record import TrainingRecord, new_record, read_record
from indoor_explorers.learners.sessions.session import Session, Trainee, TrainingStatus, crossed_multiple
from tests.learners.dddqn.rooms import small_room

CHECKPOINT = "checkpoint.txt"
CONFIG = TrainingConfig(evaluation_every=10, checkpoint_every=20)


class Counter(Trainee):
    """Counts to 50 by threes; its evaluations are as bad as ``costs`` say."""

    steps = 0
    done = False

    def __init__(self, session: Session, costs: Mapping[int, float] | None = None) -> None:
        self.costs = costs or {}
        self.kept: list[int] = []
        if session.checkpoint is not None:
            self.steps = int(session.checkpoint.read_text())

    def update(self) -> None:
        self.steps += 3
        self.done = self.steps >= 50

    def status(self) -> TrainingStatus:
        return TrainingStatus(total_steps=50)

    def evaluate(self) -> dict[str, int | float]:
        return {"steps": self.steps, "cost": self.costs.get(self.steps, 0.0)}

    def rank(self, evaluation: Mapping[str, int | float]) -> tuple[float, ...]:
        return (evaluation["cost"],)

    def keep(self, folder: Path) -> None:
        self.kept.append(self.steps)

    def save(self, folder: Path) -> None:
        (folder / CHECKPOINT).write_text(str(self.steps))


def session(out: Path, seed: int = 1, *, batch: int = 256, obstacles: int = 2, resume: bool = False) -> Session:
    config = CONFIG.model_copy(update={"batch": batch})
    record = new_record("counter", config, small_room(obstacles), seed)
    return Session(record, config, out, CHECKPOINT, resume=resume, report=None)


def steps(out: Path) -> list[float]:
    return [evaluation["steps"] for evaluation in read_record(out, TrainingRecord, ["counter"]).evaluations]


def test_a_multiple_is_crossed_once() -> None:
    counts = [0, 3, 9, 10, 11, 19, 20, 45]
    assert [b for a, b in itertools.pairwise(counts) if crossed_multiple(a, b, 10)] == [10, 20, 45]


def test_evaluations_are_due_by_steps_and_at_the_end_and_the_best_is_kept(tmp_path: Path) -> None:
    run = session(tmp_path)
    trainee = Counter(run, {12: 3.0, 21: 2.0, 30: 4.0, 42: 2.0, 51: 5.0})
    run.run(trainee)
    assert steps(tmp_path) == [12, 21, 30, 42, 51]
    assert trainee.kept == [12, 21, 42]
    record = read_record(tmp_path, TrainingRecord, ["counter"])
    assert (record.steps, record.done) == (51, True)


def test_a_killed_training_goes_on_from_its_checkpoint_and_evaluates_again(tmp_path: Path) -> None:
    class Killed(Counter):
        def update(self) -> None:
            super().update()
            if self.steps > 40:
                raise MemoryError

    run = session(tmp_path)
    with pytest.raises(MemoryError):
        run.run(Killed(run))
    assert (steps(tmp_path), (tmp_path / CHECKPOINT).read_text()) == ([12, 21, 30], "21")
    run = session(tmp_path, resume=True)
    trainee = Counter(run)
    assert trainee.steps == 21
    run.run(trainee)
    assert steps(tmp_path) == [12, 21, 30, 42, 51]


def test_an_interrupt_waits_for_the_update_and_everything_is_written(tmp_path: Path) -> None:
    class Interrupted(Counter):
        def update(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            super().update()

    run = session(tmp_path)
    trainee = Interrupted(run)
    with pytest.raises(KeyboardInterrupt):
        run.run(trainee)
    assert ((tmp_path / CHECKPOINT).read_text(), trainee.kept) == ("3", [3])
    assert (read_record(tmp_path, TrainingRecord, ["counter"]).done, steps(tmp_path)) == (False, [])


def test_each_commit_that_a_training_ran_under_is_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    commits = iter(["first", "second", "second", "third"])
    monkeypatch.setattr("indoor_explorers.learners.sessions.record.source_commit", lambda: next(commits))
    for _ in range(4):
        run = session(tmp_path, resume=True)
        run.write(Counter(run))
    record = read_record(tmp_path, TrainingRecord, ["counter"])
    assert (record.commit, record.commits) == ("first", ("first", "second", "third"))


def test_other_trainings_are_refused(tmp_path: Path) -> None:
    run = session(tmp_path)
    trainee = Counter(run)
    run.run(trainee)
    with pytest.raises(InputError, match="already holds a training; give --resume"):
        session(tmp_path)
    for change, match in (
        ({"seed": 2}, "with seed 1, expected 2"),
        ({"batch": 8}, "with batch 256, expected 8"),
        ({"obstacles": 3}, "with task"),
    ):
        with pytest.raises(InputError, match=match):
            session(tmp_path, **change, resume=True)
    with pytest.raises(InputError, match="expected a training of dddqn, got one of counter"):
        read_record(tmp_path, TrainingRecord, ["dddqn"])


def test_a_record_of_before_is_resumed(tmp_path: Path) -> None:
    """It had neither a task nor, in some, commits, and said ``policy``."""
    run = session(tmp_path)
    trainee = Counter(run)
    run.run(trainee)
    facts = json.loads((tmp_path / RECORD).read_text())
    facts["policy"], facts["commit"] = facts.pop("learner"), "first"
    for name in ("task", "commits", "done", "seconds"):
        del facts[name]
    del facts["config"]["action_gap"], facts["config"]["network"]["candidates"]  # settings that were added since
    (tmp_path / RECORD).write_text(json.dumps(facts))
    record = session(tmp_path, resume=True).record
    assert (record.learner, record.steps, len(record.evaluations)) == ("counter", 51, 5)
    assert (record.commit, record.commits[0], len(record.commits)) == ("first", "first", 2)
    facts["config"]["network"]["width"] = 8
    (tmp_path / RECORD).write_text(json.dumps(facts))
    with pytest.raises(InputError, match="with network"):
        session(tmp_path, resume=True)

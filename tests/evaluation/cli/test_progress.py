"""What a run says about itself while it goes on."""

import io
import os
from dataclasses import replace

import pytest
from rich.console import Console

from indoor_explorers.env import PRESETS
from indoor_explorers.env.grid import compile_cache
from indoor_explorers.evaluation.cli import progress
from indoor_explorers.evaluation.cli.progress import ProgressBar, RunningMeans
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.coverage_threshold import CoverageThreshold
from tests.evaluation.plugins import Wander, WrongAction

ROOM = PRESETS["thesis-obstacles"].for_evaluation()


@pytest.fixture(scope="module")
def records():
    tasks = [Task(ROOM.name, 0, seed) for seed in range(4)]
    return [*fly(Wander(), "[b]wander", ROOM, tasks), *fly(WrongAction(), "broken", ROOM, tasks[:1])]


def test_means_are_over_the_tasks_that_all_have_flown(records):
    """The second policy is flown last and on fewer tasks; until it has begun, the first one stands alone."""
    means, other = RunningMeans(), [replace(record, policy="other") for record in records[:4]]
    for record in records[:4]:
        means.add(record, record.metrics["t99"] is not None)
    (alone,) = means.means().values()
    assert means.tasks == 4
    assert alone.auc == pytest.approx(sum(record.metrics["auc"] for record in records[:4]) / 4)
    assert alone.coverage == pytest.approx(sum(record.curve[-1] for record in records[:4]) / 4)
    assert alone.reached == sum(record.metrics["t99"] is not None for record in records[:4]) / 4
    easier = replace(other[0], task=other[0].task._replace(scenario="easier"), metrics={"auc": 1.0})
    means.add(easier, True)
    assert (means.tasks, set(means.means().values())) == (0, {None})
    for record in other[1:3]:
        means.add(record, False)
    first, second = means.means().values()
    assert means.tasks == 2
    assert first.auc == second.auc == pytest.approx(sum(record.metrics["auc"] for record in records[1:3]) / 2)
    assert means.episodes == {"[b]wander": 4, "other": 3}


def test_failed_episodes_are_counted(records):
    means = RunningMeans()
    for record in records:
        means.add(record, False)
    assert means.failed == {"[b]wander": 0, "broken": 1}


def test_what_is_reached_is_the_threshold_of_the_scenario(records):
    for key in ("t99", "t50"):
        screen, thresholds = io.StringIO(), {} if key == "t99" else {ROOM.name: CoverageThreshold(key)}
        bar = ProgressBar(Console(file=screen, width=100), thresholds)
        bar.begin(5, 4)
        bar.flown(records[:3])
        Console(file=screen, width=100).print(bar._shown())
        assert f"{key[1:]} % reached" in screen.getvalue()
        share = sum(record.metrics[key] is not None for record in records[:3]) / 3
        assert f"{share:.0%}" in screen.getvalue().splitlines()[-2]
        assert "means over the 3 tasks that all these policies have flown" in screen.getvalue()


def test_a_terminal_sees_every_policy(records):
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=True, width=100)
    with ProgressBar(console) as bar:
        bar.begin(9, 6)
        bar.flown(records)
        console.print(bar._shown())
        bar.begin(9, 5)
        console.print(bar._shown())
    shown = screen.getvalue()
    assert "[b]wander" in shown
    assert "broken" in shown
    assert "episodes/s" in shown
    assert "writing the report" in shown


def test_what_is_compiled_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(compile_cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(progress, "CHECK_INTERVAL", 0.0)
    missing = {"view_gain-1a", "beam-2b", "learn-3c"}
    monkeypatch.setattr(progress, "not_compiled", lambda: missing)
    (tmp_path / "ab").mkdir()
    stale = tmp_path / "ab" / "left_behind-0f-0.lock"
    stale.touch()
    os.utime(stale, (0, 0))
    screen = io.StringIO()
    bar = ProgressBar(Console(file=screen, width=100))
    assert bar._compiling.line() == ""
    lock = tmp_path / "ab" / "view_gain-1a-1.lock"
    lock.touch()
    assert bar._compiling.line() == "compiling view_gain: 0 of at most 3 functions done, once per machine"
    (tmp_path / "ab" / "beam-2b-2.lock").touch()
    lock.unlink()
    missing.remove("view_gain-1a")
    Console(file=screen, width=100).print(bar._shown())
    assert "compiling beam: 1 of at most 3 functions done" in screen.getvalue()


def test_a_log_file_gets_lines(records, monkeypatch):
    monkeypatch.setattr(progress, "LINE_INTERVAL", -1.0)
    screen = io.StringIO()
    with ProgressBar(Console(file=screen, width=100)) as bar:
        bar.begin(5, 5)
        bar.flown(records)
    lines = screen.getvalue().splitlines()
    assert lines[0] == "flying 5 episodes"
    assert lines[1].startswith("5 of 5 episodes, ")
    assert "; mean AUC over 1 task: [b]wander 0." in lines[1]


def test_one_episode_is_one_episode(records, monkeypatch):
    monkeypatch.setattr(progress, "LINE_INTERVAL", -1.0)
    screen = io.StringIO()
    with ProgressBar(Console(file=screen, width=100)) as bar:
        bar.begin(1, 1)
        bar.flown(records[:1])
    assert screen.getvalue().startswith("flying 1 episode\n1 of 1 episode, ")

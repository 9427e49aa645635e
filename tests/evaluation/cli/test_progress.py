"""What a run says about itself while it goes on."""

import io

import pytest
from rich.console import Console

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.cli import progress
from indoor_explorers.evaluation.cli.progress import Means, ProgressBar
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.experiment.experiment import Task
from indoor_explorers.evaluation.results.coverage_threshold import CoverageThreshold
from tests.evaluation.plugins import Wander, WrongAction

ROOM = PRESETS["thesis-obstacles"].for_evaluation()


@pytest.fixture(scope="module")
def records():
    tasks = [Task(ROOM.name, 0, seed) for seed in range(4)]
    return [*fly(Wander(), "[b]wander", ROOM, tasks), *fly(WrongAction(), "broken", ROOM, tasks[:1])]


def test_means_are_those_of_the_records(records):
    means = Means()
    for record in records[:4]:
        means.add(record)
    area, covered, reached, failed = means.cells()
    assert float(area) == pytest.approx(sum(r.metrics["auc"] for r in records[:4]) / 4, abs=5e-4)
    assert covered == f"{sum(r.curve[-1] for r in records[:4]) / 4:.1%}"
    assert reached == f"{sum(r.metrics['t99'] is not None for r in records[:4]) / 4:.0%}"
    assert failed == ""


def test_what_is_reached_is_the_level_of_the_scenario(records):
    means, screen = Means(), io.StringIO()
    for record in records[:4]:
        means.add(record, CoverageThreshold("t50"))
    assert means.cells()[2] == f"{sum(r.metrics['t50'] is not None for r in records[:4]) / 4:.0%}"
    for levels, words in (({}, "99 % reached"), ({ROOM.name: CoverageThreshold("t90")}, "90 % reached")):
        bar = ProgressBar(Console(file=screen, width=100), levels)
        bar.begin(5, 9)
        bar.flown(records)
        Console(file=screen, width=100).print(bar._shown())
        assert words in screen.getvalue()


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


def test_a_log_file_gets_lines(records, monkeypatch):
    monkeypatch.setattr(progress, "SAY_EVERY", -1.0)
    screen = io.StringIO()
    with ProgressBar(Console(file=screen, width=100)) as bar:
        bar.begin(5, 5)
        bar.flown(records)
    lines = screen.getvalue().splitlines()
    assert lines[0] == "flying 5 episodes"
    assert lines[1].startswith("5 of 5 episodes, ")
    assert "mean AUC so far: [b]wander 0." in lines[1]

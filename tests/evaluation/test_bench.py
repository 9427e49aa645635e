"""The benchmark names its figures as agreed; the figures themselves are never tested."""

import json

from indoor_explorers.env import PRESETS, policy_names
from indoor_explorers.evaluation import bench
from indoor_explorers.evaluation.cli import main


def test_it_prints_and_writes_every_figure(monkeypatch, capsys, tmp_path):
    measures = ("first_compile", "world_speed", "gymnasium_step", "pettingzoo_step", "decision_time", "comparison_time")
    for name in measures:
        monkeypatch.setattr(bench, name, lambda *arguments: 1.5)
    assert main(["bench", "--json", str(tmp_path / "bench.json")]) == 0
    figures = json.loads((tmp_path / "bench.json").read_text())
    names = [figure["name"] for figure in figures]
    assert {"first-compile", "gym-step", "pettingzoo-step-team4", "harness-1000-episodes", *bench.WORLDS} <= set(names)
    assert {f"decide-{policy}-{size}" for policy in policy_names() for size in ("16x16", "250x250")} <= set(names)
    assert all(figure["value"] == 1.5 and figure["unit"] for figure in figures)
    printed = capsys.readouterr().out
    assert all(name in printed for name in names)


def test_its_worlds_are_what_their_names_say():
    for name, (task, _) in bench.WORLDS.items():
        assert name == f"world-{task.name}-lidar{task.lidar.range:g}-team{task.team}"


def test_measuring_measures():
    task = PRESETS["thesis-team-2"].with_settings({"budget": 5, "on_collision": "block"})
    assert bench.world_speed(task, batch=2, steps=12) > 0
    assert bench.decision_time("random", 16, 3.0) > 0
    assert bench.gymnasium_step(20) > 0
    assert bench.pettingzoo_step(20) > 0

"""The command and the function: which episode, where to, and nothing half-written."""

import os
import resource
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import RunError
from indoor_explorers.evaluation import export_episode
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.exports.episodes import csv_tables, topics
from indoor_explorers.evaluation.exports.episodes.moments import moments
from tests.evaluation.exports.episodes.reading import SECOND, messages, record_of

WORDS = ("--policy", "frontier", "--map", "hall", "--seed", "1")
CHOICE = {"policy": "frontier", "map": "hall", "seed": 1}


def run(capsys, *words):
    """Run the command in this process; returns (status, standard output, standard error)."""
    status = main(["export", *map(str, words)])
    return status, *capsys.readouterr()


def test_the_command_writes_what_the_function_does(folder, tmp_path, capsys):
    status, printed, errors = run(capsys, folder, *WORDS, "--out", tmp_path / "new" / "a.mcap")
    assert (status, errors) == (0, "")
    assert f"Episode: {tmp_path / 'new' / 'a.mcap'}" in printed
    export_episode(folder, tmp_path / "a.mcap", **CHOICE)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "new" / "a.mcap").read_bytes()
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["a.mcap"]


@pytest.mark.parametrize(("option", "seconds"), [({"step_seconds": 0.25}, 0.25), ({"speed": 0.2}, 2.5)])
def test_a_step_lasts_as_long_as_asked_for(folder, results, tmp_path, option, seconds):
    found = list(messages(export_episode(folder, tmp_path / "a.mcap", **option, **CHOICE)))
    record, _ = record_of(results, *CHOICE.values())
    assert found[-1].stamp == SECOND * (1 + seconds * record.steps)


def test_a_map_that_does_not_say_has_cells_of_one_metre(folder, tmp_path):
    found = messages(export_episode(folder, tmp_path / "a.mcap", policy="frontier", map="room", seed=0, speed=0.5))
    grids = [message.content for message in found if message.topic == "/true_map"]
    assert grids[0].info.resolution == 1.0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            ["--policy", "frontier"],
            "expected one episode, got 4: maps hall, room; seeds 0, 1; choose with --map and --seed",
        ),
        (["--policy", "frontier", "--map", "room"], "expected one episode, got 2: seeds 0, 1; choose with --seed"),
        (["--policy", "fronteir"], "with policy fronteir, got none; did you mean 'frontier'?"),
        (["--policy", "frontier", "--scenario", "office"], "with scenario office, got none; known: 2 maps"),
        (["--policy", "frontier", "--map", "hal", "--seed", "1"], "with map hal, got none; did you mean 'hall'?"),
        (["--policy", "frontier", "--map", "hall", "--seed", "7"], "with seed 7, got none; there are seeds 0, 1"),
        ([*WORDS, "--step-seconds", "2", "--speed", "1"], "expected the seconds of a step or a speed, got both"),
        ([*WORDS, "--format", "csv"], "expected the name of a folder as --out of format csv"),
        ([*WORDS, "--out", "a.bag"], "expected a file that ends in .mcap as --out of format mcap, got a.bag"),
        ([*WORDS, "--speed", "0"], "expected a number of metres a second"),
    ],
)
def test_what_is_not_clear_is_told_in_a_line(words, told, folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, _, errors = run(capsys, folder, "--out", "a.mcap", *words)
    assert (status, errors.count("\n")) == (2, 1)
    assert told in errors
    assert list(tmp_path.iterdir()) == []


def test_values_in_python_are_checked_as_well(folder, tmp_path):
    with pytest.raises(InputError, match="expected one episode, got 8: policies frontier, frontier-nearest; maps"):
        export_episode(folder, tmp_path / "a.mcap")
    with pytest.raises(InputError, match="expected a format of mcap, rosbag2, csv, got 'bag'"):
        export_episode(folder, tmp_path / "a.mcap", format="bag", **CHOICE)
    with pytest.raises(InputError, match=r"expected 0\.001 to 1000 seconds or metres a second, got -1"):
        export_episode(folder, tmp_path / "a.mcap", speed=-1.0, **CHOICE)


@pytest.mark.parametrize("format", ["rosbag2", "csv"])
def test_an_earlier_export_is_replaced_and_nothing_else(format, folder, tmp_path):
    for seed in (0, 1):
        export_episode(folder, tmp_path / "out", format=format, **{**CHOICE, "seed": seed})
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    told = (tmp_path / "out" / ("meta.json" if format == "csv" else "metadata.yaml")).read_text()
    assert '"seed": 1' in told.replace("\n      ", " ")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="expected no folder, or one that an export has written"):
        export_episode(folder, tmp_path / "out", format=format, **CHOICE)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="expected the name of a folder, got a file"):
        export_episode(folder, tmp_path / "file", format=format, **CHOICE)


def test_pipes_and_links_stay(folder, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="expected the name of a folder, got a file"):
        export_episode(folder, tmp_path / "pipe", format="csv", **CHOICE)
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    export_episode(folder, tmp_path / "link", format="csv", **CHOICE)
    assert (tmp_path / "pipe").is_fifo()
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "meta.json").is_file()


@pytest.mark.parametrize(("format", "name"), [("mcap", "a.mcap"), ("rosbag2", "a"), ("csv", "a")])
def test_nothing_half_written_is_left_behind(format, name, folder, tmp_path, monkeypatch):
    def broken(record, scenario):
        for moment in moments(record, scenario):
            if moment.step == 5:
                raise RunError("no more")
            yield moment

    export_episode(folder, tmp_path / name, format=format, **CHOICE)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    for module in (topics, csv_tables):
        monkeypatch.setattr(module, "moments", broken)
    with pytest.raises(RunError, match="no more"):
        export_episode(folder, tmp_path / name, format=format, **CHOICE)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_place_that_cannot_be_written_is_told_in_a_line(folder, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    status, _, errors = run(capsys, folder, *WORDS, "--out", tmp_path / "file" / "a.mcap")
    assert (status, errors.count("\n")) == (2, 1)
    assert "cannot be written: Not a directory; choose another --out" in errors


@pytest.fixture
def small_files():
    """Let no file of this process grow above 4096 bytes, as on a full disk."""
    ignored, room = signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, room[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, room)
    signal.signal(signal.SIGXFSZ, ignored)


@pytest.mark.parametrize("format", ["mcap", "rosbag2"])
def test_a_full_disk_is_told_in_a_line(format, folder, small_files, tmp_path, capsys):
    name = "a.mcap" if format == "mcap" else "a"
    status, _, errors = run(capsys, folder, *WORDS, "--format", format, "--out", tmp_path / name)
    assert status == 2
    assert "cannot be written" in errors.splitlines()[-1]
    assert list(tmp_path.iterdir()) == []


def test_an_episode_that_the_world_does_not_give_again_is_refused(results):
    record, scenario = record_of(results, *CHOICE.values())
    with pytest.raises(RunError, match=r"frontier on .*, seed 1: the episode is not as stored"):
        list(moments(replace(record, cells=record.cells + 1), scenario))


@pytest.mark.slow
def test_without_rosbags_csv_is_written_and_bags_say_what_to_install(folder, tmp_path):
    code = f"""
import sys
sys.modules["rosbags"] = None
from indoor_explorers.evaluation.cli.parser import main
words = ["export", {str(folder)!r}, *{WORDS!r}, "--out"]
print(main([*words, "a.mcap"]), main([*words, "a", "--format", "csv"]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout.splitlines()[-1] == "2 0", done.stderr
    assert "rosbags is not installed; pip install 'indoor-explorers[ros]'" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a"]

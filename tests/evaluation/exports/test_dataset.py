"""The dataset holds the episodes as they were stored, and says where they are from."""

import hashlib
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.exports import dataset
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS
from indoor_explorers.evaluation.harness.results.results import Results
from tests.documents import ROOT


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A comparison of two policies on tasks of a suite, and one that never reaches 99 %."""
    root = tmp_path_factory.mktemp("flown")
    options = {"policies": ["frontier-nearest", "random"], "workers": 0}
    suite = {"suite": "rooms", "part": "validation", "team": 1, "episodes": 2}
    compare(root / "suite", **options, **suite, command="indoor-explorers compare a | b")
    compare(root / "short", **options, scenario="thesis-open", episodes=3, settings={"budget": 12})
    return [root / "suite", root / "short"]


@pytest.fixture(scope="module")
def written(folders, tmp_path_factory):
    return dataset.write_dataset(folders, tmp_path_factory.mktemp("dataset"))


def test_what_is_read_back_equals_what_was_stored(folders, written):
    read = pd.read_parquet(written / "episodes.parquet")
    pd.testing.assert_frame_equal(
        read, dataset.episode_table({folder.name: folder for folder in folders}), check_dtype=False
    )
    stored = [
        (folder.name, record)
        for folder in folders
        for group in Results.load(folder).groups.values()
        for record in group
    ]
    assert len(read) == len(stored) == read["seed"].size > 6
    for row, (name, record) in zip(read.to_dict("records"), stored, strict=True):
        assert (row["results"], row["policy"], row["scenario"]) == (name, record.policy, record.task.scenario)
        assert (row["seed"], row["team"], row["steps"]) == (record.task.seed, record.team, record.steps)
        assert (row["map_digest"], row["outcome"]) == (record.floorplan.digest, record.outcome)
        for metric, value in record.metrics.items():
            assert pd.isna(row[metric]) if value is None else row[metric] == value


def test_rows_say_where_they_are_from(folders, written):
    read = pd.read_parquet(written / "episodes.parquet").set_index("results")
    runs = {folder.name: Results.load(folder).runs[0] for folder in folders}
    for name, run in runs.items():
        assert set(read.loc[name, "commit"]) == {run["commit"]}
        assert set(read.loc[name, "version"]) == {run["indoor-explorers version"]}
    assert set(read.loc["suite", "command"]) == {"indoor-explorers compare a | b"}
    assert set(zip(read.loc["suite", "suite"], read.loc["suite", "part"], strict=True)) == {("rooms 1", "validation")}
    assert read.loc["short", ["suite", "part", "t99"]].isna().all(axis=None)
    assert not read.loc["short", "steps"].isna().any()


def test_the_card_explains_every_column_and_the_sums_hold(folders, written):
    card = (written / "datacard.md").read_text()
    read = pd.read_parquet(written / "episodes.parquet")
    assert all(f"\n| `{column}` |" in card for column in read)
    assert f"# Data card: {len(read)} flown episodes" in card
    assert "compare a \\| b" in card
    assert not [line for line in card.splitlines() if "counts as its budget" in line and line.startswith("| `t")]
    assert set(LEVELS) <= set(read)
    for line in (written / "SHA256SUMS").read_text().splitlines():
        digest, name = line.split("  ")
        assert hashlib.sha256((written / name).read_bytes()).hexdigest() == digest


def test_equal_results_give_equal_bytes(folders, written, tmp_path):
    again = dataset.write_dataset(folders, tmp_path / "again")
    for path in written.iterdir():
        assert path.read_bytes() == (again / path.name).read_bytes(), path.name


@pytest.mark.slow
def test_the_command_writes_what_make_asks_for(folders, tmp_path):
    words = [sys.executable, "-P", "-m", dataset.__name__, folders[1], "--out", tmp_path / "one"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert np.unique(pd.read_parquet(tmp_path / "one" / "episodes.parquet")["results"]).tolist() == ["short"]
    refused = subprocess.run([*words[:4], tmp_path, *words[5:]], capture_output=True, text=True, timeout=60)
    assert refused.returncode == 1
    assert "expected a folder with a results.db" in refused.stderr
    planned = subprocess.run(
        ["make", "-n", "-C", ROOT, "dataset", "RESULTS=results/a results/b"], capture_output=True, text=True, timeout=60
    )
    assert f"-m {dataset.__name__} results/a results/b --out results/dataset" in planned.stdout


def test_folders_of_one_name_and_a_missing_pyarrow_are_refused(folders, tmp_path, monkeypatch):
    with pytest.raises(InputError, match="different names, got short, short"):
        dataset.write_dataset([folders[1], folders[1]], tmp_path)
    with pytest.raises(InputError, match="got none"):
        dataset.write_dataset([], tmp_path)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"install indoor-explorers\[dataset\]"):
        dataset.write_dataset([folders[1]], tmp_path / "none")
    assert not (tmp_path / "none" / "episodes.parquet").exists()

"""The database for Planner Arena, asked what Planner Arena asks of it."""

import contextlib
import sqlite3

import numpy as np
import pandas as pd
import pytest

from indoor_explorers.evaluation.exports.planner_arena import write_planner_arena
from indoor_explorers.evaluation.harness.episodes.metrics import LEVELS
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from tests.evaluation.special_names import NAMES, SCENARIO, results

#: Columns that OMPL's benchmark databases have, in their order, and the types they are declared with.
OMPL = {
    "experiments": [
        *[("id", "INTEGER"), ("name", "VARCHAR(512)"), ("totaltime", "REAL"), ("timelimit", "REAL")],
        *[("memorylimit", "REAL"), ("runcount", "INTEGER"), ("version", "VARCHAR(128)"), ("hostname", "VARCHAR(1024)")],
        *[("cpuinfo", "TEXT"), ("date", "DATETIME"), ("seed", "VARCHAR(24)"), ("setup", "TEXT")],
    ],
    "plannerConfigs": [("id", "INTEGER"), ("name", "VARCHAR(512)"), ("settings", "TEXT")],
    "enums": [("name", "VARCHAR(512)"), ("value", "INTEGER"), ("description", "TEXT")],
    "runs": [("id", "INTEGER"), ("experimentid", "INTEGER"), ("plannerid", "INTEGER")],
    "progress": [("runid", "INTEGER"), ("time", "REAL")],
}
#: What Planner Arena leaves out of the experiments that it joins to the runs.
DROPPED = ["totaltime", "timelimit", "memorylimit", "runcount", "hostname", "cpuinfo", "date", "seed", "setup"]


@pytest.fixture(scope="module")
def held():
    return results()


@pytest.fixture(scope="module")
def path(held, tmp_path_factory):
    path = tmp_path_factory.mktemp("arena") / "planner-arena.db"
    write_planner_arena(held, path)
    return path


@pytest.fixture(scope="module")
def arena(path):
    """The tables as Planner Arena reads them, and its runs joined with planner and experiment."""
    with contextlib.closing(sqlite3.connect(path)) as database:
        found = {table: pd.read_sql(f"SELECT * FROM {table}", database) for table in OMPL}
    found = {name: table.rename(columns=lambda name: name.replace("_", " ")) for name, table in found.items()}
    planners = found["plannerConfigs"].rename(columns={"name": "planner"})[["id", "planner"]]
    experiments = found["experiments"].rename(columns={"name": "experiment"}).drop(columns=DROPPED)
    joined = found["runs"].merge(planners, left_on="plannerid", right_on="id", suffixes=("", "_planner"))
    found["joined"] = joined.merge(experiments, left_on="experimentid", right_on="id", suffixes=("", "_experiment"))
    return found


def test_tables_are_those_of_ompl(path):
    with contextlib.closing(sqlite3.connect(path)) as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert database.execute("PRAGMA foreign_key_check").fetchall() == []
        for table, columns in OMPL.items():
            found = [(name, kind) for _, name, kind, *_ in database.execute(f"PRAGMA table_info({table})")]
            assert found[: len(columns)] == columns, table
            assert len({name.lower().replace("_", " ") for name, _ in found}) == len(found)
            assert {kind for _, kind in found[len(columns) :]} <= {"REAL", "INTEGER", "BOOLEAN", "ENUM"}
        kinds = {name: kind for _, name, kind, *_ in database.execute("PRAGMA table_info(runs)")}
    assert (kinds["time"], kinds["solved"], kinds["status"]) == ("REAL", "BOOLEAN", "ENUM")


def test_every_episode_is_a_run(held, arena):
    runs = arena["joined"]
    assert len(runs) == len(held.records)
    assert arena["experiments"]["name"].tolist() == [SCENARIO]
    assert arena["experiments"].columns.size == 12  # more would be taken for parameters of the problem
    assert runs["version"].unique().tolist() == ["indoor-explorers 0.1.0"]
    status = dict(zip(arena["enums"]["value"], arena["enums"]["description"], strict=True))
    for policy in NAMES:
        mine, records = runs[runs.planner == policy], held.groups[SCENARIO, policy]
        assert mine["seed"].tolist() == [record.task.seed for record in records]
        assert mine["time"].tolist() == [float(record.steps) for record in records]
        assert mine["solved"].tolist() == [record.outcome is Outcome.COMPLETE for record in records]
        failed = [status[value] == "Policy failed" for value in mine["status"]]
        assert failed == [record.outcome is Outcome.FAILED for record in records]
    assert {"Policy failed", "Budget ran out"} <= {status[value] for value in runs["status"]}


def test_box_plots_show_the_metrics_and_leave_nobody_out(held, arena):
    runs = arena["joined"].drop(columns=["id_planner", "id_experiment"])
    for policy in NAMES:
        mine = runs[runs.planner == policy]
        for metric in ("auc", "path_length", "overlap", *LEVELS):
            expected = held.values(SCENARIO, policy, metric)
            np.testing.assert_allclose(mine[metric.replace("_", " ")], expected, rtol=1e-12)
        for level in LEVELS:
            assert mine[f"{level} reached"].mean() == pytest.approx(held.success(SCENARIO, policy, level).mean)
            assert mine[level].isna().sum() == 0
    odd = runs[runs.planner == NAMES[1]]
    assert {name: odd[name].unique().tolist() for name in runs if "pilot" in name and "drop" in name} == {
        "pilot drop table runs": [1.0]
    }
    assert sorted(odd[name].iloc[0] for name in runs if name.startswith("pilot a b")) == [2.0, 3.0]


def test_progress_is_coverage_by_step_up_to_the_budget(held, arena):
    names = ["id", "planner", "seed"]
    progress = arena["progress"].merge(arena["joined"][names], left_on="runid", right_on="id")
    assert progress.groupby("runid")["time"].agg(["min", "max"]).drop_duplicates().to_numpy().tolist() == [[0.0, 60.0]]
    for policy in NAMES:
        for column, who in (("coverage", "team"), ("coverage worst", "worst"), ("coverage mean", "mean")):
            mean = progress[progress.planner == policy].groupby("time")[column].mean()
            steps = mean.index.to_numpy().astype(int)
            np.testing.assert_allclose(mean, held.curves(SCENARIO, policy, who).mean(axis=0)[steps], rtol=1e-12)


def test_an_interrupted_export_is_written_anew(held, path, tmp_path):
    (tmp_path / ".planner-arena.db.partial").write_bytes(path.read_bytes())
    write_planner_arena(held, tmp_path / "planner-arena.db")
    assert (tmp_path / "planner-arena.db").read_bytes() == path.read_bytes()

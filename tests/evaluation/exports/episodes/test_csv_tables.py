"""CSV holds the episode: what is read back is what was recorded."""

import json

import numpy as np
import pandas as pd
import pytest

from indoor_explorers.evaluation import export_episode
from indoor_explorers.evaluation.exports.episodes.csv_tables import COLUMNS
from indoor_explorers.evaluation.harness.episodes.resimulate import resimulate
from tests.evaluation.exports.episodes.reading import RESOLUTION, SHAPE, record_of

CHOICE = {"policy": "frontier-nearest", "map": "hall", "seed": 0}


@pytest.fixture(scope="module")
def written(folder, tmp_path_factory):
    return export_episode(folder, tmp_path_factory.mktemp("csv") / "hall", format="csv", speed=0.25, **CHOICE)


@pytest.fixture(scope="module")
def table(written):
    return pd.read_csv(written / "steps.csv", dtype={"linked": str}, keep_default_na=False, na_values={"action": ""})


def test_a_row_for_every_uav_and_step(table, results):
    record, _ = record_of(results, *CHOICE.values())
    assert tuple(table.columns) == COLUMNS
    shape = (record.steps + 1, record.team)
    assert table["step"].tolist() == np.repeat(np.arange(shape[0]), shape[1]).tolist()
    assert table["uav"].tolist() == [*range(shape[1])] * shape[0]
    np.testing.assert_array_equal(table[["row", "col"]].to_numpy().reshape(*shape, 2), record.cells)
    np.testing.assert_allclose(table["x"], (table["col"] + 0.5) * RESOLUTION)
    np.testing.assert_allclose(table["y"], (SHAPE[0] - table["row"] - 0.5) * RESOLUTION)
    actions = table["action"].to_numpy().reshape(shape)
    assert np.isnan(actions[0]).all()
    np.testing.assert_array_equal(actions[1:], record.actions)
    coverage = table["team_coverage"].to_numpy().reshape(shape)
    np.testing.assert_allclose(coverage, np.repeat(record.curve[:, None], shape[1], axis=1), atol=1e-6)


def test_new_cells_and_links_are_those_of_the_world(table, results):
    record, scenario = record_of(results, *CHOICE.values())
    known = np.zeros(record.team, int)
    for step, world in enumerate(resimulate(record, scenario)):
        rows, state = table[table["step"] == step], world.state
        assert rows["linked"].tolist() == [" ".join(map(str, np.flatnonzero(row))) for row in state.linked[0]]
        assert rows["discovered"].tolist() == state.discovered[0].tolist()
        known += (rows["discovered"] + rows["received"]).to_numpy()
        assert known.tolist() == np.count_nonzero(state.belief[0], axis=(1, 2)).tolist()


def test_the_file_beside_it_says_what_it_is(written, results):
    record, scenario = record_of(results, *CHOICE.values())
    told = json.loads((written / "meta.json").read_text())
    assert {key: told[key] for key in CHOICE} == CHOICE
    assert (told["rows"], told["columns"], told["resolution"]) == (*SHAPE, RESOLUTION)
    assert (told["steps"], told["budget"], told["reachable"]) == (record.steps, record.budget, record.reachable)
    assert told["step_seconds"] == RESOLUTION / 0.25
    assert told["metrics"] == record.metrics
    assert told["settings"]["lidar"]["range"] == scenario.lidar.range

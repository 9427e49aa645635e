"""The table that a comparison returns prints itself on a screen, and is an ordinary DataFrame in all else."""

import numpy as np
import pandas as pd
import pytest

from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, percent
from indoor_explorers.evaluation.exports.summary_table import SummaryTable

OPTIONS = {"policies": ["random", "frontier-nearest"], "workers": 0, "settings": {"budget": 120}}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    out = tmp_path_factory.mktemp("table")
    return compare(out, scenario=["thesis-open", "thesis-team-2"], episodes=6, **OPTIONS)


def test_a_print_has_a_line_for_each_policy_with_intervals(table):
    lines = str(table).splitlines()
    assert len(lines) == 6  # titles, names of the index, four rows
    assert max(map(len, lines)) <= 120
    assert all(title in lines[0] for title in ("T90", "T99", "99 % reached", "AUC"))
    success = table.query("metric == 't99'").set_index(["scenario", "policy"])["success"]
    assert [percent(share) in line for share, line in zip(success, lines[2:], strict=True)] == [True] * 4
    row = table.query("scenario == 'thesis-team-2' and policy == 'random' and metric == 'auc'").iloc[0]
    assert f"{row['mean']:.3f} [{row['low']:.3f}, {row['high']:.3f}]" in str(table)
    assert "<table" in table._repr_html_()


def test_wide_has_the_means_in_the_order_of_the_rows(table):
    wide = table.wide(["path_length", "t90"])
    assert list(wide.columns) == ["path_length", "t90"]
    assert list(wide.index.names) == ["scenario", "policy"]
    assert wide.index[0] == ("thesis-open", "random")
    mean = table.query("scenario == 'thesis-open' and policy == 'random' and metric == 'path_length'")["mean"].iloc[0]
    assert wide.loc[("thesis-open", "random"), "path_length"] == mean


def test_what_is_made_of_it_is_ordinary(table):
    one = table[table.scenario == "thesis-open"]
    assert type(one) is type(table.groupby("policy")["mean"].mean().to_frame()) is pd.DataFrame
    assert isinstance(table, SummaryTable)
    assert np.isfinite(table["mean"]).all()


@pytest.mark.parametrize("scenarios", [("thesis-open",), ("thesis-open", "thesis-team-2")])
def test_a_goal_below_99_percent_has_dashes(table, scenarios):
    lower = SummaryTable(table[(table.metric != "t99") & table.scenario.isin(scenarios)])
    assert [line.count(EN_DASH) for line in str(lower).splitlines()[-2 * len(scenarios) :]] == [2, 2] * len(scenarios)


def test_one_scenario_is_not_named_and_missing_metrics_are_dashes(tmp_path):
    table = compare(tmp_path, scenario="thesis-open", episodes=2, **OPTIONS | {"settings": {"budget": 60, "goal": 0.9}})
    assert "thesis-open" not in str(table)
    assert list(table.wide().index) == ["random", "frontier-nearest"]

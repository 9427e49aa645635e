"""Results: ratios to a policy that knows the map, and intervals that agree wherever they are shown."""

from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import bootstrap_mean
from tests.evaluation.plugins import Wander

ROOM = PRESETS["thesis-open"].for_evaluation()
TASKS = [Task(ROOM.name, 0, seed) for seed in range(6)]


@pytest.fixture(scope="module")
def results():
    records = [record for name in ("slow", "knows") for record in fly(Wander(), name, ROOM, TASKS)]
    late = {("slow", 2): None}
    records = [
        replace(r, metrics=r.metrics | {"t99": late.get((r.policy, r.task.seed), 100.0 * (1 + (r.policy == "slow")))})
        for r in records
    ]
    policies = {"slow": {"privileged": False}, "knows": {"privileged": True}}
    return Results(policies, {ROOM.name: {"fingerprint": "", **ROOM.model_dump(mode="json")}}, [], records)


def test_ratios_are_to_the_policy_that_knows_the_map_task_by_task(results):
    assert results.values(ROOM.name, "slow", "t99_to_reference").tolist() == [2, 2, 4, 2, 2, 2]
    assert results.values(ROOM.name, "knows", "t99_to_reference").tolist() == [1] * 6


def test_there_is_no_ratio_without_such_a_policy_or_its_flight(results):
    alone = replace(results, policies={"slow": {}, "knows": {}})
    assert np.isnan(alone.values(ROOM.name, "slow", "t99_to_reference")).all()
    assert "t99_to_reference" not in set(alone.summary()["metric"])
    partly = replace(results, records=[r for r in results.records if (r.policy, r.task.seed) != ("knows", 0)])
    assert np.isnan(partly.values(ROOM.name, "slow", "t99_to_reference")).tolist() == [True] + [False] * 5
    row = partly.summary().query("metric == 't99_to_reference' and policy == 'slow'").iloc[0]
    assert (row["episodes"], row["mean"]) == (5, pytest.approx(2.4))


def test_the_summary_the_page_and_the_statistics_give_one_interval(results):
    comparison = Comparison(results, ROOM.name)
    for policy in results.policies:
        for metric in ("auc", "t90", "path_length"):
            row = results.summary().query(f"metric == '{metric}' and policy == '{policy}'").iloc[0]
            shown = comparison.estimate(policy, metric)
            values = results.values(ROOM.name, policy, metric)
            alone = bootstrap_mean(values, maps=results.maps(ROOM.name, policy))
            assert (row["mean"], row["low"], row["high"]) == pytest.approx(tuple(shown))
            assert tuple(shown) == pytest.approx(tuple(alone))


@pytest.mark.parametrize("width", [90, 160])
def test_the_terminal_shows_the_ratio_where_somebody_knows_the_map(results, width):
    def printed(shown):
        console = Console(width=width)
        with console.capture() as capture:
            console.print(headline_table(shown, width))
        return capture.get()

    assert "T99 / knows" in printed(results)
    assert "> 2.33 " in printed(results)
    assert ">: a bound, as some episodes never reached it." in printed(results)
    assert "2.00 [" in printed(replace(results, records=[r for r in results.records if r.task.seed != 2]))
    assert "T99 / knows" not in printed(replace(results, policies={"slow": {}, "knows": {}}))
    assert ("T99 / bound" in printed(results)) == (width == 160)
    assert ("> 9.04" in printed(results)) == (width == 160)

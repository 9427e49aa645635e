"""Metrics and panels of plug-ins are worked out from results, and stand beside the others."""

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation import Metric
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.tables.results_table import measures_table
from indoor_explorers.evaluation.harness.results.custom_metrics import with_metrics
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.custom_panels import custom_panels
from indoor_explorers.evaluation.report.page import render

HERE = __name__
LATE = Metric(title="lateness", unit="steps", definition="steps flown", value=lambda record: record.steps)
EVEN = Metric(title="even", unit="", definition="even seeds", value=lambda record: None if record.task.seed % 2 else 1)
FAILS = Metric(title="fails", unit="", definition="", value=lambda record: 1 / 0)
ENDLESS = Metric(title="endless", unit="", definition="", value=lambda record: float("inf"))
auc = LATE


def panel(results: Results) -> str:
    """How many there are.

    More.
    """
    return f"<p id='mine'>{len(results.records)} episodes</p>"


def no_panel(results):
    return 3


def broken_panel(results):
    raise KeyError("x")


def test_a_metric_is_in_the_records_the_summary_and_the_table(results):
    found = with_metrics(results, [f"{HERE}:LATE", f"{HERE}:EVEN"])
    assert all(record.metrics["LATE"] == record.steps for record in found.records)
    assert "LATE" not in results.records[0].metrics
    summary = found.summary().query("metric == 'EVEN'")
    assert set(summary["episodes"]) == {3}
    (column,) = [column for column, _ in measures_table(Comparison(found, "four")) if column.key == "LATE"]
    assert (column.title, column.unit) == ("lateness", "steps")
    assert "steps flown; lower is better" in render(found, replays=0)
    assert with_metrics(results, []) is results


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("auc", "which is taken; rename it"),
        ("panel", "expected a Metric, got function"),
        ("FAILS", "metric 'FAILS' failed on straight, .* ZeroDivisionError"),
        ("ENDLESS", "expected a finite number or None, got inf"),
    ],
)
def test_a_metric_that_is_none_is_refused_in_one_line(name, message, results):
    with pytest.raises(InputError, match=message):
        with_metrics(results, [f"{HERE}:{name}"])
    with pytest.raises(InputError, match="which is taken"):
        with_metrics(results, [f"{HERE}:LATE"] * 2)


def test_a_panel_is_a_section_of_the_page(results):
    (found,) = custom_panels(results, [f"{HERE}:panel"])
    assert found.title == "How many there are"
    page = render(results, replays=0, panels=[f"{HERE}:panel"])
    assert f"<h2>How many there are</h2>\n  <p id='mine'>{len(results.on_common_tasks.records)} episodes</p>" in page


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("no_panel", "expected HTML as text, got int"),
        ("broken_panel", "panel '.*' failed: KeyError"),
        ("HERE", "expected a function of the results, got str"),
    ],
)
def test_a_panel_that_is_none_is_refused_in_one_line(name, message, results):
    with pytest.raises(InputError, match=message):
        custom_panels(results, [f"{HERE}:{name}"])

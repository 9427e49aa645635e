"""A policy that fails more often than another: intervals and the paired test wherever results are shown."""

import pytest
from rich.console import Console
from scipy import stats

from indoor_explorers.evaluation.exports.latex import latex_tables
from indoor_explorers.evaluation.exports.markdown import markdown_tables
from indoor_explorers.evaluation.report.analysis.comparison import Comparison
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.report.summary.headline import headline
from indoor_explorers.evaluation.report.tables.headline_table import headline_table
from tests.evaluation.report.records import flown

SAYS = "less often than sound, significantly: fails"


@pytest.fixture(scope="module")
def results():
    sound = [20 + seed % 7 for seed in range(30)]
    fails = [None if seed < 12 else 21 + seed % 5 for seed in range(30)]
    return flown({"sound": sound, "fails": fails, "like": sound})


def test_the_summary_has_the_interval_at_its_end(results):
    table = results.summary()
    row = table.query("policy == 'fails' and metric == 't99'").iloc[0]
    low, high = stats.binomtest(18, 30).proportion_ci(0.95, "exact")
    assert list(table.columns)[-3:] == ["success", "success_low", "success_high"]
    assert tuple(row[-3:]) == pytest.approx((0.6, low, high))


def test_page_terminal_and_tables_say_who_fails_more_often(results):
    comparison, console = Comparison(results, "room"), Console(width=160)
    with console.capture() as capture:
        console.print(headline_table(results, 160))
    assert comparison.success_p_values["fails"] == pytest.approx(3 * 2 / 2**12)
    for text in (headline(comparison), capture.get(), markdown_tables(results), latex_tables(results)):
        assert SAYS in text
    page = render(results)
    assert "18/30 [41, 77]\u202f%" in page
    assert "reached less often (p = 0.001)" in page


def test_nothing_is_said_where_few_episodes_differ():
    quick = [10 + seed for seed in range(30)]
    results = flown({"sound": quick, "fails": [None, None, *quick[2:]]})
    assert not Comparison(results, "room").success_differs("fails")
    assert "often than" not in markdown_tables(results)

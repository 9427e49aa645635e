"""What page, terminal and tables say about a scenario: who fails more often, who flew the same, what could be seen."""

from dataclasses import replace

import pytest
from rich.console import Console
from scipy import stats

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.headline import headline
from indoor_explorers.evaluation.analysis.notes import narrow_notes
from indoor_explorers.evaluation.analysis.ranks import ranks
from indoor_explorers.evaluation.analysis.shown_best import BOLD
from indoor_explorers.evaluation.analysis.tables.contrast_table import reading
from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
from indoor_explorers.evaluation.exports.markdown import markdown_tables
from indoor_explorers.evaluation.exports.scenario_tables import scenario_tables
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.statistics import Finding
from tests.evaluation.report.records import flown
from tests.evaluation.reports import texts_of

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
    comparison = Comparison(results, "room")
    assert comparison.success_p_values["fails"] == pytest.approx(2 / 2**12, abs=4e-4)
    for text in (headline(comparison), *texts_of(results)):
        assert SAYS in text
    page = render(results)
    assert "18/30 [41, 77]\u202f%" in page
    assert "reached less often (p &lt; 0.001)" in page


def test_nothing_is_said_where_few_episodes_differ():
    quick = [10 + seed for seed in range(30)]
    results = flown({"sound": quick, "fails": [None, None, *quick[2:]]})
    assert not Comparison(results, "room").success_differs("fails")
    assert "often than" not in markdown_tables(scenario_tables(results))


def test_what_is_as_good_and_what_is_open_is_said_with_the_number_that_would_resolve_it():
    quick = [40 + seed % 7 for seed in range(30)]
    like = [late + (seed * 11) % 3 - 1 for seed, late in enumerate(quick)]
    noisy = [late + (seed * 11) % 29 - 12 for seed, late in enumerate(quick)]
    results = flown({"quick": quick, "like": like, "noisy": noisy, "slow": [late + 9 for late in quick]})
    found = Comparison(results, "room").contrasts
    first = Comparison(results, "room").ranked_policies[0]
    by_finding = {each.finding: name for name, each in found.items()}
    assert by_finding[Finding.WORSE] == "slow"
    other = next(name for name in ("quick", "like") if name != first)
    text = markdown_tables(scenario_tables(results))
    assert f"As good as {first} within 5 %: {other}." in text
    assert f"Not resolved against {first}: noisy (about {found['noisy'].needed:.0f} tasks would)." in text
    assert "failures of" in text
    assert "cannot exclude (up to 10 %) would add up to" in text
    assert "within" not in markdown_tables(scenario_tables(replace(results, margin=0.0)))


def test_a_policy_that_is_quick_and_fails_is_not_called_better():
    sound = [40 + seed % 7 for seed in range(30)]
    results = flown({"sound": sound, "rare": [None if seed in (3, 4) else late - 8 for seed, late in enumerate(sound)]})
    comparison = Comparison(results, "room")
    said = "over the 28 of 30 tasks that both finished"
    assert reading(comparison.contrasts["sound"]) == f"slower {said}, but finished 2 more"
    assert f"<b>sound</b> took +8.0 [+8.0, +8.0] steps against rare {said}; the difference is" in headline(comparison)
    assert {rank.text for rank in ranks(comparison).values()} == {"1="}
    assert bold_rows(results) == set()


def test_policies_that_flew_the_same_episodes_are_named_and_count_as_one(results):
    alone = Comparison(replace(results, records=[r for r in results.records if r.policy != "like"]), "room")
    assert Comparison(results, "room").twins == [["sound", "like"]]
    assert Comparison(results, "room").contrasts["fails"].adjusted_p == alone.contrasts["fails"].adjusted_p
    for text in texts_of(results):
        assert "sound and like flew the same episodes." in text


def test_bold_is_one_thing_everywhere_and_what_could_have_been_seen_is_said():
    slow, slower = ([40 + late + seed % 5 for seed in range(12)] for late in (0, 9))
    results = flown({"quick": [20 + seed % 7 for seed in range(12)], "slow": slow, "slower": slower})
    page = render(results)
    for text in (*texts_of(results), page):
        assert BOLD in " ".join(text.replace("\\", "").split())
        assert "Only differences of T99 to quick above some" in text
    assert page.count('data-metric="t99" class="best"') == 1
    assert bold_rows(results) == {"quick"}
    level = flown({"quick": [20 + seed % 7 for seed in range(12)], "level": [20 + seed % 5 for seed in range(12)]})
    assert 'class="best"' not in render(level)
    assert bold_rows(level) == set()


def bold_rows(results):
    """The policies with a bold figure in the terminal."""
    lines = Console(width=160).render_lines(headline_table(results, 160))
    bold = [line for line in lines if any(each.style and each.style.bold and "[" in each.text for each in line)]
    return {"".join(each.text for each in line).split()[0] for line in bold}


def test_an_incomplete_store_is_compared_on_the_common_tasks_everywhere():
    first, second = [10 * (1 + seed) for seed in range(10)], [12 * (1 + seed) for seed in range(6)]
    results = flown({"whole": first, "easy": second})
    row = results.summary().query("policy == 'whole' and metric == 't99'").iloc[0]
    assert (row["episodes"], row["mean"]) == (6, pytest.approx(35.0))
    said = "easy lacks 4 of 10; only the 6 tasks that all of these policies flew are compared"
    for text in (*texts_of(results), render(results)):
        assert said in " ".join(text.split())
        assert "35.0" in text


def test_intervals_with_a_few_episodes_that_never_reached_it_are_called_too_narrow():
    quick = [20 + seed % 7 for seed in range(30)]
    results = flown({"quick": quick, "rare": [None, None, *quick[2:]], "often": [None] * 20 + quick[20:]})
    for text in (*texts_of(results)[1:], render(results)):
        assert "The interval of T99 is too narrow: rare, 2 of 30 never reached." in text
    assert narrow_notes(Comparison(flown({"quick": quick}), "room")) == []

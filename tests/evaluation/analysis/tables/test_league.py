"""The league table: ranks with ties, marks of significance, and who flew the same flights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.ranks import ranks
from indoor_explorers.evaluation.analysis.tables.league_table import LeagueCell, LeagueTable, league_table
from indoor_explorers.evaluation.drawing.formatting import percent
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.statistics import CONFIDENCE, all_pairs_test
from tests.evaluation.report.records import flown, made_up, results_of, room
from tests.evaluation.reports import Page

SEEDS = range(12)
TIMES = {
    "slow": [60.0 + seed % 5 for seed in SEEDS],
    "quick": [20.0 + seed % 7 for seed in SEEDS],
    "level": [20.0 + seed % 5 for seed in SEEDS],
    "knows": [9.0 + seed % 3 for seed in SEEDS],
}


def league_of(results: Results) -> LeagueTable:
    comparisons = {f"s{number}": Comparison(results, name) for number, name in enumerate(results.scenarios, 1)}
    return league_table(comparisons, policy_styles(results.policies))


def cell_of(results: Results, policy: str) -> LeagueCell:
    (cell,) = dict(league_of(results).rows)[policy]
    assert cell is not None
    return cell


def test_ranks_are_shared_where_no_difference_is_shown() -> None:
    results = flown(TIMES, privileged=["knows"])
    assert {name: rank.text for name, rank in ranks(Comparison(results, "room")).items()} == {
        "quick": "1=",
        "level": "1=",
        "slow": "3",
    }
    league = league_of(results)
    assert [name for name, _ in league.rows] == ["level", "quick", "slow", "knows"]
    assert cell_of(results, "knows").rank is None
    assert [cell_of(results, name).mark for name in ("level", "quick", "slow")] == ["", "", "*"]


def test_a_rank_counts_the_policies_that_are_shown_to_be_faster(results: Results) -> None:
    comparison = Comparison(results, "rooms")
    names = ["straight", "broken"]
    times = np.stack([results.values("rooms", name, "t99") for name in names], axis=1)
    shown = all_pairs_test(times, comparison.maps("straight")).adjusted_p[0, 1] <= 1 - CONFIDENCE
    behind = int(times[:, 0].mean() > times[:, 1].mean())
    assert ranks(comparison)[names[behind]].place == 1 + shown


def test_few_tasks_and_a_single_policy_have_no_rank() -> None:
    few = flown({name: times[:3] for name, times in TIMES.items()})
    assert ranks(Comparison(few, "room")) == {}
    assert not league_of(few).tested
    assert ranks(Comparison(flown({"quick": TIMES["quick"]}), "room")) == {}


def test_a_mean_with_episodes_that_never_reached_it_is_a_bound() -> None:
    results = flown({"quick": TIMES["quick"], "rare": [None, *TIMES["slow"][1:]]})
    assert cell_of(results, "rare").text.startswith("≥")
    assert not cell_of(results, "quick").text.startswith("≥")
    assert "never reached it and count as their budget" in Page(render(results)).text


def test_every_policy_has_the_share_of_tasks_that_reached_it_on_each_scenario() -> None:
    times: dict[str, list[float | None]] = {"quick": [20.0, 21.0], "rare": [None, 60.0]}
    rooms = [room("one"), room("other")]
    records = [
        made_up(name, Task(each.name, 0, seed), 20.0 if each.name == "other" else late)
        for name, lates in times.items()
        for each in rooms
        for seed, late in enumerate(lates)
    ]
    results = results_of(records, *rooms)
    league = league_of(results)
    assert {name: [cell.reached for cell in cells if cell] for name, cells in league.rows} == {
        "quick": [percent(1), percent(1)],
        "rare": [percent(0.5), percent(1)],
    }
    late = [(name, cell.late) for name, cells in league.rows for cell in cells if cell and cell.late]
    assert late == [("rare", f"{percent(0.5)} reached")]
    text = render(results)
    assert f"<small>{percent(0.5)} reached</small>" in text[: text.index('id="caveats"')]
    assert percent(0.5) in Page(render(flown({"rare": [None, 60.0]}))).text


def test_equal_flights_are_named_instead_of_shown_twice() -> None:
    results = flown({"quick": TIMES["quick"], "slow": TIMES["slow"], "again": TIMES["quick"]})
    assert Comparison(results, "room").same_as == {"again": "quick"}
    assert [cell_of(results, name).same_as for name in ("quick", "slow", "again")] == ["", "", "quick"]
    page = Page(render(results))
    assert page.text.count("same flights as quick") == 3  # in the league, in the results, and against the first
    other = [replace(r, actions=r.actions + 0) for r in results.records]
    other[-1].actions[0] = 1
    assert Comparison(replace(results, records=other), "room").same_as == {}


def test_the_first_table_of_the_page_is_the_league(results: Results) -> None:
    text = render(results)
    assert text.index('<table class="league') < text.index('id="caveats"') < text.index('id="replay-s1"')
    assert text.index('id="replay-s1"') < text.index('id="chart-s1"') < text.index('<table class="results')
    assert text.index('class="headline"') < text.index('<table class="league') < text.index('id="ratios"')

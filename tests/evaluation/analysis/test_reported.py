"""Reported policies beside flown ones: marked in every table, paired where the task is the same, in no test."""

from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.reported import MARK, ReportedFigures
from indoor_explorers.evaluation.analysis.tables.headline_table import headline_table
from indoor_explorers.evaluation.analysis.tables.league_table import league_table
from indoor_explorers.evaluation.analysis.tables.reported_table import reported_csv, reported_tables
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.drawing.print_style import save
from indoor_explorers.evaluation.exports import write_exports
from indoor_explorers.evaluation.exports.figures import write_figures, writing
from indoor_explorers.evaluation.harness.reported.rows import ReportedPolicy, ReportedRow, Source, write_reported
from indoor_explorers.evaluation.harness.results.combine import combined
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.page import render
from indoor_explorers.evaluation.statistics import bootstrap_mean
from indoor_explorers.evaluation.studies.leaderboard.board import boards
from indoor_explorers.evaluation.studies.leaderboard.drawing import markdown_page
from tests.evaluation.reports import HOSTILE, Wander, results_of, task_on, texts_of

SOURCE = Source(citation="Doe <b>2024</b>", url="https://example.org/a?b=1&c")
ABOUT = "reported by Doe <b>2024</b> (https://example.org/a?b=1&c), not flown here"
NAME = "theirs"


@pytest.fixture(scope="module")
def flown():
    return results_of({"straight": Wander(sweep=0.95), "wavy": Wander(sweep=0.6)}, [task_on()], 6)


def row(seed, metrics=None, **more):
    """A row of the map that all generated maps of the scenario have the name of."""
    usual = {
        "scenario": "rooms",
        "map": "thesis",
        "team": 1,
        "budget": 900,
        "metrics": metrics or {"t99": 300.0 + (seed or 0)},
    }
    return ReportedRow(seed=seed, **{**usual, **more})


def policy(*rows, name=NAME, **more):
    return ReportedPolicy(name=name, source=SOURCE, rows=rows, **more)


def beside(flown, *policies):
    return replace(flown, reported=policies)


def figures(flown, each, scenario="rooms"):
    return ReportedFigures(Comparison(beside(flown, each), scenario), each)


def test_a_shared_map_and_seed_is_a_task_of_both_and_another_is_not(flown):
    record = flown.records[0]
    others = (row(77), row(1, map="elsewhere"), row(2, team=4), row(3, scenario="halls"), row(None, map="thesis"))
    found = figures(flown, policy(row(0), *others))
    assert found.shared("straight") == {(record.floorplan.name, 0): [0]}
    assert (found.tasks, found.count) == (1, 4)
    assert "left out: 1 row of another number of UAVs" in found.note
    (table,) = reported_tables(beside(flown, policy(row(0, team=4))))
    assert "0 tasks shared with flown policies; left out: 1 row of another number of UAVs" in table.notes[1]


def test_rows_without_seeds_are_of_the_start_that_the_map_marks(flown):
    rows = policy(row(None, map="hall"), row(None, map="twice"))
    assert not figures(flown, rows).tasks
    names = {0: "hall", 1: "hall", 2: "twice", 3: "twice"}
    plans = {record.task.seed: record.floorplan for record in flown.records}
    records = [
        replace(
            each,
            floorplan=replace(
                plans[0 if names[each.task.seed] == "hall" else each.task.seed],
                name=names[each.task.seed],
                start=(1, 1),
            ),
        )
        for each in flown.records
        if each.task.seed in names
    ]
    found = figures(replace(flown, records=records), rows)
    assert found.shared("wavy") == {("hall", None): [0, 1]}  # two maps of one name are no task
    own = found.comparison.results.values("rooms", "wavy", "t99")[:2].mean()
    assert found.pairs("wavy", "t99").flown.tolist() == [own]


def test_ratios_are_over_the_tasks_of_both_with_the_intervals_of_flown_policies(flown):
    each = policy(*(row(seed, {"auc": 0.5 + seed / 1000}) for seed in (0, 1, 2, 3, 4, 90)))
    found, values = figures(flown, each), flown.values("rooms", "straight", "auc")[:5]
    theirs = np.array([0.5, 0.501, 0.502, 0.503, 0.504])
    ratio = found.pairs("straight", "auc").ratio.of_tasks
    assert ratio.mean == pytest.approx((values / theirs).mean())
    assert ratio.low < ratio.mean < ratio.high
    assert found.estimate("auc") == bootstrap_mean([*theirs, 0.59], maps=None)
    lines = reported_csv(beside(flown, each)).to_dict("records")
    assert [(line["flown"], line["tasks"], line["episodes"]) for line in lines] == [("straight", 5, 6), ("wavy", 5, 6)]
    assert lines[0]["mean_of_ratios"] == ratio.mean


def test_times_never_reached_and_paths_of_failures_make_bounds(flown):
    rows = [row(s, {"t99": None if s == 0 else 1.0, "path_length": 10.0}, success=s > 0) for s in range(6)]
    found = figures(flown, policy(*rows, level=0.995))
    assert found.values("t99").tolist() == [900, 1, 1, 1, 1, 1]
    for metric in ("t99", "path_length"):
        assert found.pairs("straight", metric).censoring.below + found.pairs("straight", metric).censoring.both == 1
    assert "times never reached, in 1 row, count as the budget" in found.note


def test_a_published_mean_has_no_interval_and_is_not_compared_by_task(flown):
    results = beside(flown, policy(row(None, {"t99": 210.0}, map=None, n=50, success=0.9), level=0.99))
    (table,) = reported_tables(results)
    assert [cell.text for cell in table.rows[-1].cells] == ["210.0", "90\u202f%", "50"]
    assert not table.rows[-1].cells[0].detail
    assert "No task of both" in table.notes[0]
    assert "published means over 50 episodes, without rows: no interval and no comparison by task" in table.notes[1]
    assert reported_csv(results)[["episodes", "mean"]].to_numpy().tolist() == [[50, 210.0]]


def test_tables_mark_reported_rows_and_say_where_they_come_from(flown):
    results = beside(flown, policy(*map(row, range(6)), name=HOSTILE[1]))
    for text, before in zip(texts_of(results), texts_of(flown), strict=True):
        assert MARK not in before
        assert r"\P{}" not in before
        assert text != before
    terminal, markdown, latex = texts_of(results)
    assert f"{HOSTILE[1]} {MARK}" in terminal
    assert ABOUT in terminal
    assert "6 tasks shared with flown policies" in markdown
    assert r"\P{}} & \textendash{} & 302.5" in latex
    (table,) = reported_tables(results)
    assert [each.name for each in table.rows[-2:]] == [
        f"{HOSTILE[1]} {MARK}, {which}" for which in ("shared tasks", "all")
    ]


def test_reported_policies_take_no_part_in_ranks_and_tests(flown):
    results = beside(flown, policy(*(row(seed, {"t99": 1.0}) for seed in range(6))))
    for one, other in ((flown, results), (results, flown)):
        ours, theirs = Comparison(one, "rooms"), Comparison(other, "rooms")
        assert ours.ranking == theirs.ranking
        assert ours.contrasts.keys() == theirs.contrasts.keys()
    league = league_table({"s1": Comparison(results, "rooms")}, policy_styles(results.policies))
    assert [name for name, _ in league.rows] == Comparison(flown, "rooms").ranking
    ((name, (cell,)),) = league.reported
    assert (name, cell.rank, cell.mark, cell.best) == (f"{NAME} {MARK}", None, "", False)


def test_the_page_hatches_reported_bars_and_is_as_ever_without_them(flown):
    before = render(flown)
    assert all(word not in before for word in ("reported-bars", 'class="hatched"', "reported, not flown"))
    page = render(beside(flown, policy(*map(row, range(6)), name="<b>x</b>")))
    assert '<rect class="hatched"' in page
    assert 'fill="url(#hatch-s1-0-2)"' in page
    assert page.count('<pattern id="hatch-s1-0-2"') == 1
    assert "<b>x</b>" not in page
    assert "reported, not flown</span>" in page
    assert "1 reported policy" in page


def test_exports_hold_reported_rows_and_are_as_ever_without_them(flown, tmp_path):
    write_exports(flown, tmp_path / "plain")
    write_exports(beside(flown, policy(*map(row, range(6)))), tmp_path / "both")
    plain, both = ({p.relative_to(f) for p in f.rglob("*.*")} for f in (tmp_path / "plain", tmp_path / "both"))
    assert {str(path) for path in both - plain} == {"tables/reported.csv"}
    same = [
        path for path in plain if (tmp_path / "plain" / path).read_bytes() == (tmp_path / "both" / path).read_bytes()
    ]
    assert {str(path) for path in plain} - set(map(str, same)) == {"tables/results.md", "tables/results.tex"}


def test_a_figure_hatches_reported_bars(flown, tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "save", lambda figure, *place: save(figure, *place) if "reported" in place[1] else [])
    few = replace(flown, records=[each for each in flown.records if each.task.seed < 2])
    paths = write_figures(beside(few, policy(*map(row, range(2)))), tmp_path)
    (path,) = (path for path in paths if path.name == "01-rooms-reported-1.svg")
    assert '<pattern id="' in path.read_text()


def test_folders_of_reported_rows_load_alone_and_combine(flown, tmp_path):
    write_reported([policy(*map(row, range(6)))], tmp_path)
    alone = Results.load(tmp_path)
    assert (alone.records, alone.scenarios, len(alone.reported)) == ([], {}, 1)
    for parts in ((flown, alone), (alone, flown)):
        whole = combined(parts)
        assert (len(whole.records), whole.reported, whole.margin) == (12, alone.reported, flown.margin)
    (table,) = reported_tables(alone)
    assert [each.name for each in table.rows] == [f"{NAME} {MARK}"]
    assert table.rows[0].cells[0].detail  # an interval over its rows
    assert table.notes[0] == "Nothing was flown on this scenario."
    with pytest.raises(InputError, match="both flown and reported"):
        combined([flown, beside(alone, policy(row(0), name="wavy"))])


def test_leaderboards_list_reported_policies_without_a_rank(flown):
    published = Results({}, {}, [], [], reported=(policy(*map(row, range(6))),))
    (board,) = boards([("a", published), ("b", flown)])
    page = markdown_page([board])
    assert f"| {MARK} | theirs {MARK} | " in page.replace("\N{NO-BREAK SPACE}", " ")
    assert "6 tasks shared with flown policies" in page
    with pytest.raises(InputError, match="expected flown results to rank, got reported rows alone"):
        boards([("a", published)])


def test_the_terminal_shows_reported_policies_below_flown_ones(flown):
    rows = headline_table(beside(flown, policy(*map(row, range(6)))), 200).columns[0]._cells
    assert [str(cell) for cell in rows][1:] == ["straight", "wavy", f"{NAME} {MARK}"]

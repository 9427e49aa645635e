"""The tables for other programs and for papers."""

import csv
import html
import re
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.analysis.shown_best import shown_best
from indoor_explorers.evaluation.exports import write_exports
from indoor_explorers.evaluation.exports.latex import escaped as tex
from indoor_explorers.evaluation.exports.latex import latex_tables
from indoor_explorers.evaluation.exports.markdown import escaped as md
from indoor_explorers.evaluation.exports.markdown import markdown_tables
from indoor_explorers.evaluation.exports.scenario_tables import caption, scenario_tables
from indoor_explorers.evaluation.harness.results.results import Results
from tests.evaluation.special_names import NAMES, SCENARIO, results


@pytest.fixture(scope="module")
def held():
    return results()


@pytest.fixture(scope="module")
def folder(held, tmp_path_factory):
    folder = tmp_path_factory.mktemp("exports")
    write_exports(held, folder)
    return folder


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_equal_results_give_equal_bytes(held, folder, tmp_path):
    write_exports(replace(held, records=list(held.records)), tmp_path)
    first, second = (sorted(p for p in root.rglob("*") if p.is_file()) for root in (folder, tmp_path))
    assert [p.relative_to(folder) for p in first] == [p.relative_to(tmp_path) for p in second]
    assert {p.name for p in first} >= {"summary.csv", "results.csv", "results.md", "results.tex", "curves.csv"}
    assert {p.name for p in first} >= {"planner-arena.db", "experiment.toml"}
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes(), one.name


def test_results_have_a_row_for_every_episode(held, folder):
    table = rows(folder / "tables" / "results.csv")
    assert [(row["policy"], row["scenario"], int(row["seed"])) for row in table] == [
        (record.policy, record.task.scenario, record.task.seed) for record in held.records
    ]
    for row, record in zip(table, held.records, strict=True):
        assert (int(row["steps"]), row["outcome"], row["reason"]) == (record.steps, record.outcome, record.reason)
        assert {name: float(row[name]) if row[name] else None for name in record.metrics} == record.metrics
    assert "failed" in {row["outcome"] for row in table}
    assert any(not row["t99"] for row in table)


def test_curves_are_those_of_the_results(held, folder):
    table = rows(folder / "tables" / "curves.csv")
    for policy in NAMES:
        mine = [row for row in table if (row["scenario"], row["policy"]) == (SCENARIO, policy)]
        assert [int(row["step"]) for row in mine] == list(range(61))
        mean = held.curves(SCENARIO, policy).mean(axis=0)
        np.testing.assert_allclose([float(row["mean"]) for row in mine], mean, atol=1e-6)
        assert all(float(row["low"]) <= float(row["mean"]) <= float(row["high"]) for row in mine)


def test_too_few_episodes_have_no_interval():
    few = results(3)
    assert "fewer than 5 episodes get no interval" in " ".join(caption(Comparison(few, SCENARIO)))
    assert all(not cell.detail for table in scenario_tables(few) for row in table.rows for cell in row.cells)
    assert "scriptsize" not in latex_tables(scenario_tables(few))


def test_a_caption_says_what_the_figures_are(held):
    text = " ".join(caption(Comparison(held, SCENARIO)))
    for words in (
        "6 episodes of each policy on 6 maps",
        "bootstrap intervals over maps like these",
        "reachable from the",
    ):
        assert words in text
    assert "counts as its budget of 60 steps" in text


def with_t99(held, **shifts):
    """Give each policy the T99 of 30 steps and a shift by seed."""
    names = dict(zip(("a", "b", "c"), NAMES, strict=True))
    shift = {names[key]: value for key, value in shifts.items()}
    records = [replace(r, metrics=r.metrics | {"t99": 30.0 + shift[r.policy][r.task.seed - 4]}) for r in held.records]
    scenarios = {SCENARIO: held.scenarios[SCENARIO] | {"goal": 1.0}}
    return Comparison(replace(held, records=records, scenarios=scenarios), SCENARIO)


def test_best_is_what_was_shown_to_be_better_than_every_other():
    held = results(8)
    slow, slower = [9, 8, 9, 10, 9, 8, 9, 10], [19, 18, 17, 19, 20, 19, 18, 19]
    assert shown_best(with_t99(held, a=slow, b=[0] * 8, c=slower), "t99") == [NAMES[1]]
    assert shown_best(with_t99(held, a=[0, 1, -1, 0, 1, -1, 1, 0], b=[0] * 8, c=slower), "t99") == []
    assert shown_best(with_t99(held, a=slow, b=[0] * 8, c=[9, -8, 9, -7, 9, -9, 9, -6]), "t99") == []
    bold = with_t99(held, a=slow, b=[0] * 8, c=slower).results
    assert rf"{{{tex(NAMES[1])}}}" in next(
        line for line in latex_tables(scenario_tables(bold)).splitlines() if r"\textbf{30.0}" in line
    )
    assert "**30.0**" in markdown_tables(scenario_tables(bold))


def test_tables_of_99_per_cent_have_ratios_to_the_lower_bound():
    held = with_t99(results(8), a=[0] * 8, b=[1] * 8, c=[2] * 8).results
    never = [replace(r, metrics=r.metrics | {"t99": None}) if r.policy == NAMES[2] else r for r in held.records]
    text = markdown_tables(scenario_tables(replace(held, records=never)))
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert lines[0].endswith("| T99 / bound |")
    shown = Comparison(held, SCENARIO).estimate(NAMES[0], "t99_to_bound")
    assert f"| {shown.mean:.2f} [{shown.low:.2f}, {shown.high:.2f}] |" in lines[2]
    assert re.search(r"\| \\> \d+\.\d\d \|$", lines[4])


def test_markdown_shows_names_as_they_are(held):
    text = markdown_tables(scenario_tables(held))
    table = [line for line in text.splitlines() if line.startswith("|")]
    for line in table:
        assert len(re.findall(r"(?<!\\)\|", line)) == 1 + len(scenario_tables(held)[0].columns)
    plain = [
        re.sub(r"\\([^A-Za-z0-9\s])", r"\1", re.split(r" (?<!\\)\| ", line)[0].removeprefix("| ")) for line in table
    ]
    assert tuple(map(html.unescape, plain[2:])) == NAMES
    assert "<" not in text
    assert not re.search(r"(?<!\\)[<>$`]", text)
    assert md("a\n*b*") == r"a \*b\*"


def test_latex_is_ascii_balanced_and_escaped(held):
    text = latex_tables(scenario_tables(held))
    assert text.isascii()
    assert re.findall(r"\\(begin|end)\{(\w+)\}", text) == [
        *(("begin", "table"), ("begin", "tabular"), ("end", "tabular"), ("end", "table"))
    ]
    body = text.split("\n", 1)[1]
    loose = re.sub(r"\\[&%$#_{}]", "", body)
    assert loose.count("{") == loose.count("}")
    assert not re.search(r"[%#^~]", loose)
    assert loose.count("$") % 2 == 0
    lines = [line for line in loose.splitlines() if line.endswith(r"\\")]
    assert {line.count("&") for line in lines} == {len(scenario_tables(held)[0].columns) - 1}
    assert r"\label{tab:01-" in text
    assert r"caf\'{e}" in text
    assert "[U+1F681]" in text
    assert r"\textbackslash{}input\{/etc/passwd\}" in text


def test_latex_text():
    assert tex("a--b---c") == "a-{}-b-{}-{}-c"
    assert tex("na\u00efve \u010dar\u00e5 \u00df \u0127\n?`") == r"na\"{i}ve \v{c}ar\r{a} \ss{} [U+0127] ?`{}"
    assert tex("1\u202f% \u22122 \u2013 \u00b5") == r"1\,\% $-$2 \textendash{} $\mu$"


def test_nothing_flown_is_no_error(held, tmp_path):
    write_exports(Results(held.policies, held.scenarios, [], []), tmp_path)
    assert markdown_tables(scenario_tables(Results({}, {}, [], []))) == ""
    assert rows(tmp_path / "tables" / "curves.csv") == []

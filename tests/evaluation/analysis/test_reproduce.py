"""The command beside a row makes the row again."""

import shlex
from dataclasses import replace

import pandas as pd
import pytest

from indoor_explorers.evaluation.analysis.reproduce import experiment_files, quoted, row_command
from indoor_explorers.evaluation.cli.parser import build_parser, main
from indoor_explorers.evaluation.harness.episodes.metrics import OF_THE_MACHINE
from indoor_explorers.evaluation.harness.results.results import Results
from tests.evaluation.special_names import NAMES, SCENARIO, USE, results

PLAN = f"""
policies = ["random", {{use = "{USE}", name = '''{NAMES[1]}''', parameters = {{speed = 3}}}},
            {{use = "{USE}", name = "random, twice"}}, {{use = "{USE}", name = "-w"}}]
scenarios = ["thesis-open", {{preset = "thesis-team-2", name = 'a "b", c', radio.range = 1.0, goal = 0.9}}]
episodes = 2
seed = 7
[set]
budget = 40
"""


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flown")
    (folder / "plan.toml").write_text(PLAN)
    words = ["compare", "--experiment", str(folder / "plan.toml"), "--out", str(folder / "out"), "--workers", "0"]
    assert main(words) == 0
    return folder / "out"


def rows(table, scenario, policy):
    mine = table[(table.scenario == scenario) & (table.policy == policy) & ~table.metric.isin(OF_THE_MACHINE)]
    return mine.reset_index(drop=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "policy"),
    [
        ("thesis-open", "random"),
        ("thesis-open", NAMES[1]),
        *(('a "b", c', name) for name in (NAMES[1], "random, twice", "-w")),
    ],
)
def test_the_command_gives_the_same_row(scenario, policy, flown, tmp_path, monkeypatch, capsys):
    held = Results.load(flown)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "experiment.toml").write_text((flown / "experiment.toml").read_text(encoding="utf-8"), encoding="utf-8")
    program, *words = shlex.split(row_command(held, scenario, policy))
    assert (program, main([*words, "--workers", "0"])) == ("indoor-explorers", 0), capsys.readouterr().err
    again = Results.load(tmp_path / "again")
    assert (list(again.policies), list(again.scenarios)) == ([policy], [scenario])
    pd.testing.assert_frame_equal(rows(again.summary(), scenario, policy), rows(held.summary(), scenario, policy))
    theirs = held.groups[scenario, policy]
    assert all(one.flew_like(other) for one, other in zip(again.records, theirs, strict=True))


def test_presets_and_defaults_need_no_file(tmp_path, capsys):
    words = ["compare", "--policies", "random", "--scenario", "thesis-open", "--episodes", "3", "--seed", "1000000"]
    assert main([*words, "--workers", "0", "--out", str(tmp_path / "out")]) == 0
    command = row_command(Results.load(tmp_path / "out"), "thesis-open", "random")
    assert command == (
        "indoor-explorers compare --policies random --scenario thesis-open --episodes 3 --seed 1000000 --out again"
    )


def test_a_row_with_fewer_episodes_than_the_store_says_so(flown):
    held = Results.load(flown)
    fewer = replace(held, records=[record for record in held.records if record.task.seed == 7])
    command = row_command(fewer, "thesis-open", "random, twice")
    assert command == (
        "indoor-explorers compare --policies '\"random, twice\"' --scenario thesis-open --experiment experiment.toml "
        "--episodes 1 --out again"
    )
    assert "--episodes" not in row_command(held, "thesis-open", "random, twice")


def test_what_is_not_recorded_has_no_command(flown):
    held = Results.load(flown)
    assert row_command(held, "thesis-open", "nobody") == ""
    assert row_command(replace(held, experiments=()), "thesis-open", "random") == ""


def test_each_store_has_an_experiment_of_its_own(flown):
    one, other = Results.load(flown), results(2)
    both = Results(
        one.policies | other.policies,
        one.scenarios | other.scenarios,
        [],
        one.records + [record for record in other.records if record.policy != NAMES[1]],
        one.experiments + other.experiments,
    )
    assert list(experiment_files(both)) == ["experiment-1.toml", "experiment-2.toml"]
    assert "--experiment experiment-2.toml" in row_command(both, SCENARIO, NAMES[0])
    assert "--experiment experiment-1.toml" in row_command(both, "thesis-open", "random, twice")


@pytest.mark.parametrize("name", [*NAMES, SCENARIO, "plain-name", "module.sub:Class", "two\nlines", '"', "'", ","])
def test_names_survive_the_command_line(name):
    words = shlex.split(shlex.join(["compare", "--policies", quoted(name), "--out", "again"]))
    assert build_parser().parse_args(words).policies == [name]
    both = f"{quoted('first')}, {quoted(name)}"
    assert build_parser().parse_args(["compare", "--policies", both, "--out", "x"]).policies == ["first", name]


def test_quotes_are_used_only_where_they_are_needed():
    assert quoted("frontier-nearest") == "frontier-nearest"
    assert quoted("dddqn, no guard") == '"dddqn, no guard"'

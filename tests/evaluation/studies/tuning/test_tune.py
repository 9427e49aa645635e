"""The tune command: resumed, refused, and read by compare."""

import csv
import json
import tomllib

import numpy as np
import optuna
import pytest

from indoor_explorers.env.files import alone_in
from indoor_explorers.env.scenarios.seed_sets import SeedUse, use_of
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.statistics import Estimate
from indoor_explorers.evaluation.studies.tuning import running
from indoor_explorers.evaluation.studies.tuning.flights import Flights
from indoor_explorers.evaluation.studies.tuning.gain import Gain
from indoor_explorers.evaluation.studies.tuning.plan import Search
from indoor_explorers.evaluation.studies.tuning.request import TuneRequest
from indoor_explorers.evaluation.studies.tuning.search import NAME, STUDY, finished
from tests.evaluation.studies.variants.requests import small_room
from tests.suites import tiny, tiny_clones

__all__ = ["tiny", "tiny_clones"]

POLICY = "frontier-advantage(taken=1.0)"
SHORT = ["--trials", "9", "--episodes", "10", "--fresh-episodes", "6", "--workers", "0"]
OURS = TuneRequest(policy=POLICY, scenario=("thesis-open",), out="x", metric="t90")


def tune(out, room, *more, policy=POLICY):
    return main(["tune", policy, "--scenario", str(room), "--out", str(out), *SHORT, *map(str, more)])


def flown_in(out):
    """The results of each trial by name, the default's first."""
    return {folder.name: Results.load(folder) for folder in sorted((out / "flights").iterdir())}


def trials_of(out):
    study = optuna.load_study(study_name=NAME, storage=f"sqlite:///{out / STUDY}")
    return [(each.params, each.state, each.user_attrs["values"]) for each in finished(study)]


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    return small_room(tmp_path_factory.mktemp("room"))


@pytest.fixture(scope="module")
def tuned(room, tmp_path_factory):
    """A finished search."""
    out = tmp_path_factory.mktemp("tuned") / "out"
    assert tune(out, room) == 0
    return out


def test_trials_are_paired_and_bad_ones_are_dropped(tuned):
    tasks = {name: [each.task for each in flown.records] for name, flown in flown_in(tuned).items()}
    assert len(tasks["default"]) == 10
    assert all(each == tasks["default"][: len(each)] for each in tasks.values())
    with (tuned / "trials.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["trial"]) for row in rows] == list(range(10))
    assert float(rows[0]["t99_to_default"]) == 1.0
    assert {int(row["episodes"]) for row in rows if row["dropped"] == "true"} <= {8}
    assert all("taken" not in json.loads(row["parameters"]) for row in rows)


def test_each_trial_has_a_store_of_its_own_so_that_a_look_reads_no_other(tuned):
    flown = flown_in(tuned)
    assert sorted(flown) == ["default", *(f"trial-{number}" for number in range(1, 10))]
    assert [len(each.policies) for each in flown.values()] == [1] * 10


@pytest.mark.slow
def test_a_killed_search_goes_on_as_if_it_had_not_been(room, tmp_path, monkeypatch, capsys):
    values, calls = Flights.values, []

    def dies(self, choice, count):
        calls.append(count)
        found = values(self, choice, count)
        if len(calls) in (4, 8):  # within a trial: its episodes are stored, and it is not told
            raise KeyboardInterrupt
        return found

    whole, out = tmp_path / "whole", tmp_path / "out"
    assert tune(whole, room, "--trials", 4) == 0
    monkeypatch.setattr(Flights, "values", dies)
    assert [tune(out, room, "--trials", 4) for _ in range(3)] == [130, 130, 0]
    assert trials_of(out) == trials_of(whole)
    for name in ("tuned.toml", "trials.csv"):
        assert (out / name).read_text().split("\n", 1)[1] == (whole / name).read_text().split("\n", 1)[1]
    flown, unbroken = ({name: len(each.records) for name, each in flown_in(x).items()} for x in (out, whole))
    assert flown == unbroken
    before = len(calls)
    capsys.readouterr()
    assert tune(out, room, "--trials", 4) == 0
    assert len(calls) == before  # a finished search flies nothing again
    assert "trial " not in capsys.readouterr().out.replace("no trial", "")


def test_another_search_in_the_folder_is_refused_in_a_line(tuned, room, capsys):
    for more, differing in ((("--seed", 2), "seed (1 and 2)"), (("--range", "weight=1:9"), "ranges.weight")):
        assert tune(tuned, room, *more) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "holds another search" in line
        assert differing in line
    assert tune(tuned, room, policy="frontier-advantage(taken=3.0)") == 2
    assert "policy.parameters.taken (1.0 and 3.0)" in capsys.readouterr().err


def test_a_folder_in_which_a_search_runs_is_refused_in_a_line(tuned, room, capsys):
    with alone_in(tuned, "--out"):
        assert tune(tuned, room) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "another process writes here" in line
    assert tune(tuned, room) == 0


def test_compare_reads_what_was_tuned_and_notes_the_seeds_it_was_tuned_on(tuned, tmp_path, capsys):
    words = ["compare", "--experiment", str(tuned / "tuned.toml"), "--episodes", "5", "--workers", "0"]
    assert main([*words, "--out", str(tmp_path / "new")]) == 0
    assert "seen before" not in capsys.readouterr().out
    flown = Results.load(tmp_path / "new")
    entries = tomllib.loads((tuned / "tuned.toml").read_text())["policies"]
    assert list(flown.policies) == [each["name"] for each in entries]
    assert flown.scenarios == flown_in(tuned)["default"].scenarios
    (first, _), (fresh, _) = (entries[1]["seen_seeds"][use][0] for use in ("tuning", "validation"))
    for seed, participle in ((first, "developed"), (fresh, "validated")):
        assert main([*words, "--seed", str(seed), "--out", str(tmp_path / participle)]) == 0
        assert (
            f"seeds seen before (frontier-advantage-tuned: {participle} on seeds {seed} to" in capsys.readouterr().out
        )


def test_the_page_and_the_last_line_tell_the_gain_on_fresh_seeds(tuned, room, capsys):
    assert tune(tuned, room) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith("tuned / default on 6 fresh episodes (seeds ")
    page = (tuned / "tuning.html").read_text()
    assert last in page
    assert page.count("data:image/png;base64,") == 2  # history and importance
    assert "http:" not in page
    assert "https:" not in page


def test_tuning_fresh_and_test_seeds_are_disjoint():
    search = Search.of(OURS)
    for experiment, use in ((search.tuning, SeedUse.TUNING), (search.fresh, SeedUse.VALIDATION)):
        assert use_of(range(experiment.seed, experiment.seed + experiment.episodes)) is use


def test_a_suite_is_tuned_on_its_validation_part(tiny, tmp_path):
    of_suite = {"policy": POLICY, "suite": "tiny", "data": (tiny,), "out": tmp_path}
    search = Search.of(TuneRequest(**of_suite))
    names = [
        [each.map.floorplan(0, 0).name for each in experiment.scenarios]
        for experiment in (search.tuning, search.fresh, Search.of(TuneRequest(**of_suite, part="train")).tuning)
    ]
    assert [set(each) for each in names] == [{"c"}, {"d"}, {"d"}]
    assert len(search.tasks) == 2 * len(search.tuning.scenarios)
    assert sorted(search.tasks) == sorted(search.tuning.tasks())
    seen = search.tuned({}).seen_maps
    assert [len(seen[use]) for use in ("tuning", "validation")] == [1, 1]


def test_generated_suites_are_checked_on_seeds_of_no_part(tmp_path):
    search = Search.of(TuneRequest(policy=POLICY, suite="rooms", episodes=3, out=tmp_path))
    assert use_of(range(search.tuning.seed, search.tuning.seed + 3)) is SeedUse.VALIDATION
    assert search.fresh.seed == Search.of(OURS).fresh.seed


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("frontier-utility",), "expected a scenario to tune for, got none"),
        (("frontier-nearest", "--scenario", "thesis-open"), "declares no parameters to tune"),
        (("no-such", "--scenario", "thesis-open"), "unknown policy 'no-such'"),
        (("pso", "--scenario", "thesis-opne"), "unknown scenario 'thesis-opne'"),
        (("pso", "--scenario", "thesis-open", "--set", "goal=0.9"), "ask for --metric t90"),
        (("pso", "--scenario", "thesis-open", "--trials", "3", "--hours", "1"), "expected --trials or --hours"),
        (("pso", "--scenario", "thesis-open", "--hours", "-1"), "expected a number of hours above 0, got '-1'"),
        (("pso", "--scenario", "thesis-open", "--range", "power"), "expected name=low:high"),
        (("pso", "--scenario", "thesis-open", "--metric", "t42"), "invalid choice: 't42'"),
        (("pso", "--suite", "rooms", "--part", "test"), "invalid choice: 'test'"),
        (("pso", "--suite", "buildings"), "has no validation part"),
        (("pso(length=", "--scenario", "thesis-open"), "pso(length="),
    ],
)
def test_bad_words_are_told_in_a_line(words, said, tmp_path, capsys):
    assert main(["tune", *words, "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not (tmp_path / "out").exists()


def test_without_optuna_a_line_says_what_to_install(tmp_path, capsys, monkeypatch, room):
    monkeypatch.setattr(running, "find_spec", lambda name: None)
    assert tune(tmp_path / "out", room) == 2
    assert "pip install 'indoor-explorers[tune]'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("ratio", "lower", "verdict"),
    [
        (Estimate(0.9, 0.8, 0.99), True, "a gain is shown"),
        (Estimate(0.9, 0.8, 1.01), True, "no gain shown"),
        (Estimate(1.1, 1.01, 1.2), True, "a loss is shown"),
        (Estimate(1.1, 1.01, 1.2), False, "a gain is shown"),
        (Estimate(0.9, None, None), True, "too few episodes for an interval, no gain shown"),
    ],
)
def test_the_verdict_is_what_the_interval_shows(ratio, lower, verdict):
    gain = Gain(ratio, 9, "seeds 1 to 9", lower, "T99", None)
    assert gain.verdict == verdict
    assert gain.line.endswith(f": {verdict}")


@pytest.mark.slow
def test_hours_limit_the_trials_instead(room, tmp_path, capsys):
    out = tmp_path / "out"
    words = ["tune", POLICY, "--scenario", str(room), "--out", str(out), "--hours", "1e-6", *SHORT[2:]]
    assert main(words) == 0
    assert len(trials_of(out)) == 2  # the default, and the one that took longer
    assert np.isfinite(trials_of(out)[1][2]).all()
    assert "trial 1:" in capsys.readouterr().out

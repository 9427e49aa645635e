"""A leaderboard takes complete results of a suite whose episodes are what the world and the policy give."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.studies.leaderboard.board import boards
from indoor_explorers.evaluation.studies.leaderboard.drawing import legend, markdown_page
from indoor_explorers.evaluation.studies.leaderboard.verifying import flown_differently, made_again, mismatches
from tests.documents import SITE
from tests.suites import tiny, tiny_clones

__all__ = ["tiny", "tiny_clones"]


TYPED = "indoor-explorers compare --suite tiny --data /mine --policies 'random,pso(length=1)' --out /mine/two"


def fly(out: Path, *policies, **options) -> Results:
    """Fly what the command would fly, and write no report."""
    request = ComparisonRequest.of(policies=list(policies), workers=0, **options)
    fly_missing(plan(request), out, request, command=TYPED)
    return Results.load(out)


@pytest.fixture
def flown(tiny, tmp_path):
    """Two submissions to the suite tiny."""
    one = fly(tmp_path / "one", "frontier-nearest", "reference", suite="tiny", data=tiny, team=1)
    two = fly(tmp_path / "two", "random", "pso(length=1)", suite="tiny", data=tiny, team=1)
    return {"one": one, "two": two}


def test_policies_of_several_folders_are_ranked_by_scenario(flown):
    (board,) = boards(list(flown.items()))
    assert board.title == "tiny 3, test part"
    (comparison,) = board.comparisons
    ranks = {row.policy: row.rank and row.rank.text for row in board.rows(comparison)}
    assert ranks == {"frontier-nearest": "1=", "pso(length=1)": "1=", "random": "3", "reference": None}
    assert list(ranks)[2:] == ["random", "reference"]
    assert "## tiny-1: 6 tasks on 3 maps of 2 buildings" in markdown_page([board])


def test_scenarios_of_a_part_are_on_one_board(tiny, flown, tmp_path):
    teams = fly(tmp_path / "teams", "frontier-nearest", suite="tiny", data=tiny, team=2, radio=["disc"])
    (board,) = boards([*flown.items(), ("teams", teams)])
    assert [each.scenario for each in board.comparisons] == ["tiny-1", "tiny-2-disc"]
    assert [row.policy for row in board.rows(board.comparisons[1])] == ["frontier-nearest"]


def test_incomplete_flights_are_named_and_left_out(tiny, flown, tmp_path):
    some = fly(tmp_path / "some", "rrt", suite="tiny", data=tiny, team=1, maps=["A"])
    (board,) = boards([*flown.items(), ("some", some)])
    assert board.left_out == ("some: rrt is not listed for tiny-1, as it flew 4 of 6 tasks",)
    assert "rrt" not in board.results.policies
    with pytest.raises(InputError, match="flew 4 of 6 tasks; fly the rest"):
        boards([("some", some)])


def test_tasks_of_no_suite_have_a_board_of_their_own(flown, tmp_path):
    options = {"scenario": "thesis-open", "seed": 7, "settings": {"budget": 5}}
    one = fly(tmp_path / "one-room", "frontier-nearest", "random", episodes=3, **options)
    other = fly(tmp_path / "other", "rrt", episodes=2, **options)
    assert list(mismatches(one)) == []
    suite, rooms = boards([*flown.items(), ("one-room", one), ("other", other)])
    assert suite.title == "tiny 3, test part"
    assert (rooms.title, rooms.about) == ("thesis-open budget=5: seeds 7 to 9", "")
    assert rooms.left_out == ("other: rrt is not listed for thesis-open, as it flew 2 of 3 tasks",)
    assert "## thesis-open budget=5: 3 tasks on 1 map" in markdown_page([rooms])


def test_what_was_flown_is_found_again(flown):
    for results in flown.values():
        assert list(mismatches(results)) == []


def changed(results: Results, **values) -> Results:
    """The results with the first record changed."""
    first, *rest = results.records
    return dataclasses.replace(results, records=[dataclasses.replace(first, **values), *rest])


def test_changed_figures_actions_and_paths_are_found(flown):
    results = flown["one"]
    record = results.records[0]
    better = changed(results, metrics=record.metrics | {"t99": 3})
    assert "t99 3, simulated" in next(mismatches(better))
    elsewhere = changed(results, actions=np.roll(record.actions, 1, axis=0))
    assert list(mismatches(elsewhere))
    covered = record.covered.copy()
    covered[1:-1] = record.covered[-1]
    assert "covered differ" in next(mismatches(changed(results, covered=covered)))


@pytest.mark.slow
def test_episodes_of_another_policy_are_found(flown):
    results = flown["two"]
    names = {"random": "pso(length=1)", "pso(length=1)": "random"}
    swapped = [dataclasses.replace(each, policy=names[each.policy]) for each in results.records]
    mixed = dataclasses.replace(results, records=swapped)
    assert list(mismatches(mixed)) == []
    assert any("took other actions" in line for line in flown_differently(mixed, 1, made_again(mixed)))


def test_a_generated_map_has_to_be_that_of_its_seed(tmp_path):
    results = fly(tmp_path, "random", suite="rooms", part="validation", team=1, episodes=2, settings={})
    one, other = results.records
    swapped = dataclasses.replace(results, records=[dataclasses.replace(one, floorplan=other.floorplan)])
    assert "not the map that the generator makes" in next(mismatches(swapped))


@pytest.mark.slow
def test_the_command_writes_a_page(flown, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["leaderboard", "one", "two", "--fly", "1", "--out", "board.md"]) == 0
    assert "tiny 3, test part" in capsys.readouterr().out
    page = (tmp_path / "board.md").read_text()
    assert page.startswith("# Leaderboard: tiny 3, test part\n")
    assert f"\n    {TYPED.replace('/mine/two', 'DIR').replace('/mine', 'DIR')}\n" in page


@pytest.mark.parametrize("name", ["leaderboard", "leaderboard-rooms"])
def test_the_pages_of_the_site_have_today_s_legend_in_short_sentences(name):
    assert "\n".join(("", *legend(0), "")) in (SITE / "pages" / f"{name}.md").read_text("utf-8")
    assert max(map(len, (*legend(0), *legend(3)))) <= 140


def test_the_command_names_the_episodes_that_are_not_as_stored(flown, tmp_path, capsys, monkeypatch):
    better = changed(flown["one"], metrics=flown["one"].records[0].metrics | {"auc": 1.0})
    monkeypatch.setattr(Results, "load", lambda *given: better)
    assert main(["leaderboard", "one", "--out", str(tmp_path / "board.md")]) == 1
    said = capsys.readouterr().err
    assert "one: 1 of 12 episodes are not as stored: frontier-nearest on tiny-1, map 0, seed 32000000: auc 1.0" in said
    assert not (tmp_path / "board.md").exists()

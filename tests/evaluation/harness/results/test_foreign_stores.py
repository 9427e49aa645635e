"""Reading results imports nothing that they name, and believes no fingerprint."""

import dataclasses
import shutil

import pytest

from indoor_explorers.env import PRESETS, InputError
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.episodes.stored_names import policy_refusal
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.combine import combined, scenario_difference
from indoor_explorers.evaluation.harness.results.results import Results
from tests.evaluation.forging import forge, stranger, with_setting

SETTINGS = {"lidar.range": 6, "budget": 20}


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A folder of results of a room with a lidar of range 6."""
    out = tmp_path_factory.mktemp("flown")
    request = ComparisonRequest.of(policies="random", scenario="thesis-open", episodes=1, settings=SETTINGS, workers=0)
    fly_missing(plan(request), out, request)
    return out


@pytest.fixture
def mine(flown, tmp_path):
    return shutil.copytree(flown, tmp_path / "mine")


@pytest.mark.parametrize("place", ["lidar.model", "radio.model", "map.source"])
def test_what_a_stored_scenario_names_is_not_imported(place, mine, tmp_path, monkeypatch, capsys):
    imported = stranger(tmp_path, monkeypatch)
    forge(mine, "scenario", "facts", with_setting(place, "stranger:exact"))
    page = tmp_path / "page.html"
    assert main(["report", str(mine), "--against", str(mine), "--out", str(page)]) == 0
    said = capsys.readouterr().out
    assert ("no replays of scenario 'thesis-open': " in said) == (place != "map.source")
    export = ["export", str(mine), "--policy", "random", "--format", "csv", "--out", str(tmp_path / "csv")]
    assert main(export) == (0 if place == "map.source" else 2)
    assert main(["leaderboard", str(mine)]) == 2
    why = f"{place} 'stranger:exact' from outside this package, imported only if you name it: --plugins stranger:exact"
    assert f"{mine}: thesis-open is not listed, as it cannot be verified: {why}" in capsys.readouterr().err
    assert why.replace("'", "&#39;") in page.read_text() or place == "map.source"
    assert not imported.exists()


def test_a_model_that_the_user_names_is_imported(mine, tmp_path, monkeypatch):
    imported = stranger(tmp_path, monkeypatch)
    forge(mine, "scenario", "facts", with_setting("lidar.model", "stranger:exact"))
    with pytest.raises(InputError, match="'stranger:exact' from outside"):
        Results.load(mine, ["stranger:other"]).scenario("thesis-open")
    assert not imported.exists()
    assert Results.load(mine, ["stranger:exact"]).scenario("thesis-open").lidar.model == "stranger:exact"
    assert main(["leaderboard", str(mine), "--plugins", "stranger:exact"]) == 0
    assert imported.exists()


def test_policies_of_others_are_told_by_name_and_by_the_texts_they_are_given():
    assert not policy_refusal({"use": "return-to-base", "parameters": {"explorer": "frontier", "share": 0.5}}, ())
    assert "policy 'os:system'" in policy_refusal({"use": "os:system"}, ())
    assert "--plugins sb3:x" in policy_refusal({"use": "sb3:x"}, ())
    given = {"use": "return-to-base", "parameters": {"explorer": ["a:B"]}}
    assert "parameter 'a:B'" in policy_refusal(given, ())
    assert not policy_refusal(given, ["a:B"])


def test_the_fingerprint_of_another_task_is_refused(mine):
    assert Results.load(mine).records
    true = PRESETS["thesis-open"].for_evaluation().with_settings(SETTINGS | {"lidar.range": 3})
    forge(mine, "scenario", "fingerprint", lambda _: true.fingerprint)
    with pytest.raises(InputError, match=f"thesis-open' has the fingerprint {true.fingerprint}, its settings and maps"):
        Results.load(mine)


def test_settings_that_earlier_versions_did_not_have_change_no_fingerprint(mine):
    before = Results.load(mine)
    later = {"failures", "base", "prior", "noise", "drift"}
    forge(mine, "scenario", "facts", lambda facts: {key: facts[key] for key in facts if key not in later})
    older = Results.load(mine)
    assert scenario_difference(before, older, "thesis-open") == ""
    assert combined([before, older]).scenarios.keys() == before.scenarios.keys()


def test_tasks_of_one_fingerprint_are_compared_all_the_same(flown):
    one = Results.load(flown)
    settings = one.scenarios["thesis-open"]
    other = dataclasses.replace(one, scenarios={"thesis-open": settings | {"goal": 0.5}})
    with pytest.raises(InputError, match=r"what differs: goal \(1.0 and 0.5\)"):
        combined([one, other])


@pytest.mark.parametrize("cells", [True, False])
def test_map_files_count_by_their_cells(cells, tmp_path):
    (tmp_path / "a.map").write_text("type octile\nheight 3\nwidth 4\nmap\n....\n.@..\n....\n")
    request = ComparisonRequest.of(
        policies="random", maps=tmp_path / "a.map", episodes=1, settings={"budget": 9}, workers=0
    )
    fly_missing(plan(request), tmp_path, request)
    (tmp_path / "a.map").unlink()
    if cells:
        assert Results.load(tmp_path).records
    else:
        forge(tmp_path, "scenario", "fingerprint", lambda found: found[::-1])
        with pytest.raises(InputError, match="scenario 'a' has the fingerprint"):
            Results.load(tmp_path)

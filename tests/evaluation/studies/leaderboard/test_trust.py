"""A leaderboard believes no folder: neither what it says of a policy nor how it is written."""

import shutil

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.cli.parser import main
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.studies.leaderboard import verifying
from indoor_explorers.evaluation.studies.leaderboard.board import boards
from indoor_explorers.evaluation.studies.leaderboard.drawing import markdown_page
from indoor_explorers.evaluation.studies.leaderboard.verifying import (
    flown_differently,
    made_again,
    other_policies,
)
from tests.evaluation.forging import forge, stranger, with_setting

WANDER = "tests.evaluation.plugins:Wander"
ODD = "[bold red]x[/bold red] [/]\x1b[31m<img>"


def fly(out, *policies, **options):
    """Fly in this process, and write no report."""
    options = {"scenario": "thesis-open", "settings": {"budget": 9}, "episodes": 2} | options
    request = ComparisonRequest.of(policies=list(policies), workers=0, **options)
    fly_missing(plan(request), out, request, command="indoor-explorers compare --out 'it is'")
    return out


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A folder with a policy that knows the map and one from outside this package."""
    return fly(tmp_path_factory.mktemp("flown"), "reference", {"use": WANDER, "name": ODD})


@pytest.fixture
def mine(flown, tmp_path):
    return shutil.copytree(flown, tmp_path / "mine")


@pytest.fixture
def jobs(monkeypatch):
    """What would be flown again, which is not."""
    given = []
    monkeypatch.setattr(verifying, "make_engine", lambda *_: lambda jobs: given.extend(jobs) or ())
    return given


def test_a_policy_that_hides_that_it_knows_the_map_is_refused(mine, capsys):
    forge(mine, "policy", "facts", with_setting("privileged", False), "name = 'reference'")
    assert main(["leaderboard", str(mine)]) == 0
    assert "Not flown again (--fly): what policies are and what they know" in capsys.readouterr().out
    assert main(["leaderboard", str(mine), "--fly", "1"]) == 1
    said = capsys.readouterr().err
    assert "reference: the policy made is not the one stored: privileged (False and True); fly them again" in said


@pytest.mark.parametrize(("fact", "value"), [("uses_generator", True), ("hash", "0" * 16), ("class", "a:B")])
def test_the_policy_made_has_to_be_the_one_stored(fact, value, mine):
    assert other_policies(Results.load(mine), made_again(Results.load(mine))) == []
    forge(mine, "policy", "facts", with_setting(fact, value), "name = 'reference'")
    results = Results.load(mine)
    (line,) = other_policies(results, made_again(results))
    assert fact in line


@pytest.mark.slow
def test_hand_ins_from_outside_are_named_by_the_user_and_fly_isolated(flown, jobs):
    unnamed, named = Results.load(flown), Results.load(flown, [WANDER])
    assert list(made_again(unnamed)) == ["reference"]
    made = made_again(named)
    assert other_policies(named, made) == []
    assert list(flown_differently(named, 10**9, made)) == []
    assert [(job.policy.name, job.isolated, job.privileged, len(job.tasks)) for job in jobs] == [
        ("reference", False, False, 2),
        (ODD, True, False, 2),
    ]


def test_policies_that_the_store_names_are_not_imported(mine, tmp_path, monkeypatch, capsys, jobs):
    imported = stranger(tmp_path, monkeypatch)
    forge(mine, "run", "experiment", lambda text: text.replace(WANDER, "stranger:Walk"))
    assert main(["leaderboard", str(mine), "--fly", "1"]) == 0
    assert "policy 'stranger:Walk' from outside" in capsys.readouterr().out
    assert [job.policy.use for job in jobs] == ["reference"]
    assert not imported.exists()


def test_names_and_commands_are_shown_as_they_are(mine, capsys, tmp_path, jobs):
    command = "compare it's\n\n<img src=x onerror=alert(1)>"
    forge(mine, "run", "facts", with_setting("command", command))
    page = tmp_path / "page.md"
    assert main(["leaderboard", str(mine), "--fly", "1", "--out", str(page)]) == 0
    said = capsys.readouterr().out
    assert "\x1b" not in said
    assert "[bold red]x[/bold red] [/]" in said
    assert "was not flown again, and is what its folder says: policy 'tests.evaluation.plugins:Wander' from" in said
    text = page.read_text()
    assert "\n    compare it's <img src=x" in text
    assert "<img>" not in text
    assert "flew 1 episode of each scenario again" in text


def test_a_policy_of_an_endless_name_is_refused_in_one_line(mine):
    results = Results.load(mine)
    text = results.experiments[0].replace('name = "reference"', f'name = "{"r" * 5000}"')
    renamed = Results(
        {"r" * 5000: results.policies["reference"]}, results.scenarios, results.runs, results.records, (text,)
    )
    with pytest.raises(InputError, match="policy: name: String should have at most 80 characters"):
        made_again(renamed)


def test_different_tasks_do_not_stand_under_one_title(tmp_path, monkeypatch):
    four = fly(tmp_path / "four", "random", scenario=["thesis-team-4", "thesis-open"], settings={"budget": 9})
    two = fly(tmp_path / "two", "random", scenario="thesis-team-4", settings={"budget": 9, "team": 2})
    page = markdown_page(boards([("four", Results.load(four)), ("two", Results.load(two))]))
    assert "### thesis-team-4 budget=9: 2 tasks on 2 maps" in page
    assert "### thesis-team-4 budget=9 team=2: 2 tasks on 2 maps" in page
    monkeypatch.setattr(Results, "title", lambda self, name: name)
    with pytest.raises(InputError, match=r"not the same task in four and two; what differs: team \(4 and 2\); rename"):
        boards([("four", Results.load(four)), ("two", Results.load(two))])

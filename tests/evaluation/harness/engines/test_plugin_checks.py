"""Plug-ins are checked for hidden knowledge before a comparison flies them, and in some of their flights."""

import pytest

from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.engines import plugin_checks
from indoor_explorers.evaluation.harness.engines.loading import PolicyLoader
from indoor_explorers.evaluation.harness.engines.plugin_checks import found_in_flights
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.store import Store
from indoor_explorers.evaluation.harness.results.written_rows import StoredFlight
from tests.evaluation.harness.engines.limits import LIMITS, SECONDS
from tests.evaluation.plugins import Raises
from tests.marks import slow

#: Rooms of another size than those of the conformance checks.
ROOMS = {"map.width": 24, "map.height": 24, "budget": 80}


@pytest.fixture(autouse=True)
def _time_by_load(monkeypatch):
    """Give policies more time on a busy machine, where the product would leave them unchecked."""
    for name in ("TIME_LIMIT", "SECONDS"):
        monkeypatch.setattr(plugin_checks, name, getattr(plugin_checks, name) * SECONDS)


def checked(*policies, stored=None):
    """The facts of policies, by the name of each."""
    entries = [{"use": use, "name": name} for name, use in policies]
    experiment = plan(ComparisonRequest(policies=entries, scenario="thesis-open", episodes=1))
    about = {choice.name: policy_facts(choice.make(), choice.use) for choice in experiment.policies}
    with PolicyLoader(LIMITS) as loader:
        return plugin_checks.with_failed_checks(experiment, about, stored or {}, loader)


def plugin(name):
    return name, f"tests.evaluation.plugins:{name}"


@pytest.mark.slow
def test_plug_ins_are_checked_and_the_projects_own_policies_are_not():
    facts = checked(plugin("KnowsMap"), plugin("Wander"), ("own", "frontier"), ("yardstick", "reference"))
    assert "map of the seed: explores better on the map of its generator's seed" in facts["KnowsMap"]["failed_check"]
    assert "; to fix it, draw numbers from briefing.rng" in facts["KnowsMap"]["failed_check"]
    assert facts["Wander"]["failed_check"] == ""
    assert not any("failed_check" in facts[name] for name in ("own", "yardstick"))


@pytest.mark.parametrize(
    "name",
    ["Exits", *slow("Raises", "HangsForGood", "WrongAction")],
)
def test_a_plug_in_that_cannot_be_checked_is_left_unjudged(name, monkeypatch):
    monkeypatch.setattr(plugin_checks, "TIME_LIMIT", 1.0)
    assert not checked(plugin(name))[name].get("failed_check")


def test_a_plug_in_is_checked_once(monkeypatch):
    calls = []
    monkeypatch.setattr(
        plugin_checks, "_failed_check", lambda loader, job, facts: calls.append(job.policy.name) or "it failed"
    )
    two = plugin("Wander"), ("the same", plugin("Wander")[1])
    facts = checked(*two)
    assert calls == ["Wander"]
    assert checked(*two, stored=facts) == facts
    assert {each["failed_check"] for each in facts.values()} == {"it failed"}
    changed = {name: each | {"sources": {"plugins.py": "another"}} for name, each in facts.items()}
    checked(*two, stored=changed)
    assert len(calls) == 2


@pytest.mark.slow
def test_a_comparison_marks_a_policy_that_knows_the_map_whatever_it_does_to_its_process(checks, tmp_path):
    policies = [plugin("ForgesItsCheck")[1], "random"]
    compare(tmp_path, policies=policies, scenario="thesis-open", episodes=2, workers=1)
    failed = Results.load(tmp_path).failed_checks
    assert list(failed) == policies[:1]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "failed a check</span>" in page
    assert "tests.evaluation.plugins:ForgesItsCheck failed the check map of the seed: " in page
    with Store(tmp_path / "results.db") as store:
        assert "failed_check" not in store.policies()["random"]
        assert [facts["isolated"] for facts in store.policies().values()] == [True, False]


def flown(out, *names, episodes=4, **settings):
    """Fly plug-ins; return the experiment."""
    entries = [{"use": f"tests.evaluation.plugins:{name}", "name": name} for name in names]
    request = ComparisonRequest.of(
        policies=entries, scenario="thesis-team-4", episodes=episodes, workers=0, settings={**ROOMS, **settings}
    )
    experiment = plan(request)
    fly_missing(experiment, out, request)
    return experiment


def test_telepathy_and_memory_are_found_where_they_count(tmp_path):
    experiment = flown(tmp_path, "Telepath", "Remembers", "Wander", **{"radio.model": "none"})
    with Store(tmp_path / "results.db") as store:
        found = found_in_flights(experiment, store, None)
        assert found["Telepath"]["failed_check"].startswith("teammates apart: UAV ")
        assert "and flew and sent the same, in thesis-team-4, map 0, seed " in found["Telepath"]["failed_check"]
        assert found["Remembers"]["failed_check"].startswith("episodes alone: flown again in a new process, it chose ")
        assert found["Wander"] == {"flown_again": {"thesis-team-4": 4}}
        store.add_facts(found)
        assert found_in_flights(experiment, store, None) == {}
    flown(tmp_path, "Telepath", "Remembers", "Wander", **{"radio.model": "none"})
    assert list(Results.load(tmp_path).failed_checks) == ["Telepath", "Remembers"]


def test_more_episodes_are_looked_at_again(tmp_path, monkeypatch):
    chosen = []
    monkeypatch.setattr(plugin_checks, "_sample", lambda flights: chosen.append(len(flights)) or [])
    with Store(tmp_path / "results.db") as store:
        for episodes in (1, 2, 2):
            found_in_flights(flown(tmp_path, "Wander", episodes=episodes), store, None)
            store.add_facts({"Wander": {"flown_again": {"thesis-team-4": episodes}}})
    assert chosen == [1, 2]


def test_a_policy_that_fails_when_flown_again_is_marked(tmp_path):
    class Local(Raises):
        ended, unjudged = None, False

    (scenario,) = flown(tmp_path, "Wander", episodes=1).scenarios
    (record,) = Results.load(tmp_path).records
    found = plugin_checks._judged(Local(), [(scenario, record)])
    assert "an episode that was flown before failed when flown again (act raised RuntimeError" in found["failed_check"]
    Local.unjudged = True
    assert plugin_checks._judged(Local(), [(scenario, record)]) == {}


@pytest.mark.parametrize(("count", "some"), [(1, 1), (2, 1), (6, 3), (60, 4)])
def test_a_few_episodes_are_chosen_the_latest_first_and_not_the_first_one(count, some):
    flights = [StoredFlight(rowid, 0, bytes([rowid])) for rowid in range(1, count + 1)]
    chosen = plugin_checks._sample(flights)
    assert len(chosen) == some
    assert chosen == sorted(chosen, reverse=True)
    assert count == 1 or 1 not in chosen

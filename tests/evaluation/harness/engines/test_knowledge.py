"""Plug-ins are checked for hidden knowledge before a comparison flies them."""

import pytest

from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.harness.engines import knowledge
from indoor_explorers.evaluation.harness.engines.loading import PolicyLoader
from indoor_explorers.evaluation.harness.experiment.limits import Limits
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.store import Store

LIMITS = Limits(decision_timeout=1.0, memory=2_000_000_000)


def checked(*policies, stored=None):
    """The facts of policies, by the name of each."""
    entries = [{"use": use, "name": name} for name, use in policies]
    experiment = plan(ComparisonRequest(policies=entries, scenario="thesis-open", episodes=1))
    about = {choice.name: policy_facts(choice.make(), choice.use) for choice in experiment.policies}
    with PolicyLoader(LIMITS) as loader:
        return knowledge.with_failed_checks(experiment, about, stored or {}, loader)


def plugin(name):
    return name, f"tests.evaluation.plugins:{name}"


def test_plug_ins_are_checked_and_the_projects_own_policies_are_not():
    facts = checked(plugin("KnowsMap"), plugin("Wander"), ("own", "frontier"), ("yardstick", "reference"))
    assert "map of the seed: explores better on the map of its generator's seed" in facts["KnowsMap"]["failed_check"]
    assert "; to fix it, draw numbers from briefing.rng" in facts["KnowsMap"]["failed_check"]
    assert facts["Wander"]["failed_check"] == ""
    assert not any("failed_check" in facts[name] for name in ("own", "yardstick"))


@pytest.mark.parametrize(
    "name",
    ["Exits", "Raises", *(pytest.param(name, marks=pytest.mark.slow) for name in ("HangsForGood", "WrongAction"))],
)
def test_a_plug_in_that_cannot_be_checked_is_left_unjudged(name, monkeypatch):
    monkeypatch.setattr(knowledge, "TIME_LIMIT", 1.0)
    assert not checked(plugin(name))[name].get("failed_check")


def test_a_plug_in_is_checked_once(monkeypatch):
    calls = []
    monkeypatch.setattr(
        knowledge, "_failed_check", lambda loader, job, facts: calls.append(job.policy.name) or "it failed"
    )
    two = plugin("Wander"), ("the same", plugin("Wander")[1])
    facts = checked(*two)
    assert calls == ["Wander"]
    assert checked(*two, stored=facts) == facts
    assert {each["failed_check"] for each in facts.values()} == {"it failed"}
    changed = {name: each | {"sources": {"plugins.py": "another"}} for name, each in facts.items()}
    checked(*two, stored=changed)
    assert len(calls) == 2


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

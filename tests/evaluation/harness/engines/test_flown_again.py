"""Plug-ins fly some of their episodes again, where hidden knowledge shows that the conformance checks do not meet."""

import pytest

from indoor_explorers.evaluation.driver import fly_missing
from indoor_explorers.evaluation.harness.engines import flown_again
from indoor_explorers.evaluation.harness.engines.flown_again import found_in_flights
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.harness.results.store import Store
from indoor_explorers.evaluation.harness.results.written_rows import Flight
from tests.evaluation.plugins import Raises

#: Rooms of another size than those of the conformance checks.
ROOMS = {"map.width": 24, "map.height": 24, "budget": 80}


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
    monkeypatch.setattr(flown_again, "_sample", lambda flights: chosen.append(len(flights)) or [])
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
    found = flown_again._judged(Local(), [(scenario, record)])
    assert "an episode that was flown before failed when flown again (act raised RuntimeError" in found["failed_check"]
    Local.unjudged = True
    assert flown_again._judged(Local(), [(scenario, record)]) == {}


@pytest.mark.parametrize(("count", "some"), [(1, 1), (2, 1), (6, 3), (60, 4)])
def test_a_few_episodes_are_chosen_the_latest_first_and_not_the_first_one(count, some):
    flights = [Flight(rowid, 0, bytes([rowid])) for rowid in range(1, count + 1)]
    chosen = flown_again._sample(flights)
    assert len(chosen) == some
    assert chosen == sorted(chosen, reverse=True)
    assert count == 1 or 1 not in chosen

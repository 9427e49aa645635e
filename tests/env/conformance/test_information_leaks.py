"""The conformance suite finds policies that know more than their views and briefings tell."""

from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, run_checks
from indoor_explorers.env.conformance.information_leaks import matching_chance
from indoor_explorers.env.conformance.suite import REPEATABLE
from indoor_explorers.env.simulation import world as simulation
from tests.env.conformance.policies import MOST_CHECKS, Honest, make
from tests.seeds import seed_of

#: The check that lets teammates stop, after the one without which it tells nothing.
STOPS = (REPEATABLE, "unlinked teammates")


def failures(kind, names=MOST_CHECKS):
    """What the failed checks say, or those of some names, by name."""
    return {finding.name: finding.text for finding in run_checks(make(kind), names) if not finding.passed}


def said_by(check, kind):
    """What one check says of a policy that fails it."""
    return failures(kind, [REPEATABLE, check])[check]


def reference(briefing, seed):
    """The pilot that knows the map that a seed draws."""
    world = World(briefing.scenario)
    world.reset([seed])
    return make_policy("reference").pilot(world.briefing(0, briefing.agent, privileged=True))


class Searches(Honest):
    """Finds its seed by trying small ones, and plans on the map that the seed draws."""

    def __init__(self, briefing, policy):
        super().__init__(briefing, policy)
        self.planner = reference(briefing, seed_of(briefing))

    def act(self, view):
        return self.planner.act(view)


class SearchesByDrawing(Searches):
    """Hides it by drawing numbers, as honest pilots do."""

    def act(self, view):
        self.rng.random()
        return super().act(view)


class Doubts(Searches):
    """Explores at random as soon as its belief contradicts the map of its seed."""

    def __init__(self, briefing, policy):
        super().__init__(briefing, policy)
        self.truth = World(briefing.scenario)
        self.truth.reset([seed_of(briefing)])

    def act(self, view):
        known = view.belief > 0
        fits = (self.truth.state.truth[0][known] == view.belief[known]).all()
        return super().act(view) if fits else Honest.act(self, view)


class Insists(Doubts):
    """Fails on another map than that of its seed."""

    def act(self, view):
        assert view.step > 0 or view.cell == self.truth.view(0, self.briefing.agent).cell
        return 4


class ReadsSeed(Searches):
    """Reads its seed where generators used to hold it."""

    def __init__(self, briefing, policy):
        Honest.__init__(self, briefing, policy)
        seed = briefing.rng.bit_generator.seed_seq.entropy
        self.planner = reference(briefing, seed) if isinstance(seed, int) else self.honest(briefing)

    def honest(self, briefing):
        return make_policy("frontier-nearest").pilot(briefing)


class ReadsBase(Honest):
    """Goes where the other UAVs of the batch have been least, by the base of its belief."""

    def act(self, view):
        batch = view.belief.base
        known = int((batch > 0).sum()) if isinstance(batch, np.ndarray) else 0
        moves = np.flatnonzero(view.legal)
        return int(moves[known % len(moves)])


class Foresees(Honest):
    """Keeps away from the others while one is still to stop, as the scenario lists it."""

    def act(self, view):
        stops = self.briefing.scenario.failures.stops
        coming = [agent for agent, step in stops if step > view.step]
        moves = np.flatnonzero(view.legal)
        return int(moves[len(coming) % len(moves)])


class Remembers(Honest):
    """Goes on otherwise once a teammate has been silent for some steps, or the base has been far away for long."""

    def act(self, view):
        silent = sum(mate.age > 5 for mate in view.mates) + (view.base_age or 0) // 10
        moves = np.flatnonzero(view.legal)
        return int(moves[silent % len(moves)])


@pytest.mark.parametrize("kind", [Searches, SearchesByDrawing, Doubts])
def test_a_policy_that_finds_its_seed_is_caught(kind):
    assert "better on the map of its generator's seed" in said_by("map of the seed", kind)


def test_a_policy_that_fails_on_another_map_than_its_seeds_is_caught():
    told = said_by("map of the seed", Insists)
    assert "fails on a map that is not the one of its generator's seed (act raised AssertionError" in told


def test_the_chance_of_the_best_pairing_is_one_in_all_pairings():
    assert matching_chance(np.eye(5, dtype=np.int64)) == 1 / 120
    assert matching_chance(np.arange(5) + np.zeros((5, 5), np.int64)) == 1.0
    chances = [matching_chance(np.random.default_rng(n).integers(0, 999, (5, 5))) for n in range(400)]
    assert abs(np.mean(chances) - 0.5) < 0.05


def old_generator(seed, stream, index=0):
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(stream), index)))


def test_a_seed_in_the_generator_is_caught_and_is_not_there(monkeypatch):
    assert not failures(ReadsSeed)
    monkeypatch.setattr(simulation, "generator", old_generator)
    assert said_by("map of the seed", ReadsSeed)


def test_a_policy_is_told_no_list_of_failures_to_come_and_one_that_had_it_is_caught(monkeypatch):
    assert not failures(Foresees, STOPS)
    told = World.briefing
    monkeypatch.setattr(
        World, "briefing", lambda world, *at, **options: replace(told(world, *at, **options), scenario=world.scenario)
    )
    found = failures(Foresees, STOPS)
    assert found.keys() == {"unlinked teammates"}
    assert "chose differently at step 0 when only teammates stopped" in found["unlinked teammates"]


def test_silence_of_teammates_and_of_the_base_may_change_what_is_done(monkeypatch):
    """In scenarios with a base and with failures, which are flown."""
    flown = []
    monkeypatch.setattr(World, "__init__", recorded(World.__init__, flown))
    assert not failures(Remembers, STOPS)
    assert any(task.base.exists for task in flown)
    assert any(task.failures.stops for task in flown)
    assert not any(task.base.exists or task.failures.any for task in flown[:2])


def recorded(begin, flown):
    """A constructor of worlds that notes their scenarios."""

    def init(world, scenario, *others, **options):
        flown.append(scenario)
        begin(world, scenario, *others, **options)

    return init


def test_a_base_of_all_beliefs_is_caught_and_is_not_there(monkeypatch):
    assert not failures(ReadsBase)
    monkeypatch.setattr(simulation, "read_only", lambda array: array)
    assert said_by("unlinked teammates", ReadsBase)

"""Prior maps: what they may differ in, what they depend on, and who is given them."""

import pickle
import subprocess
import sys
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env import World, run_checks, scenario
from indoor_explorers.env.conformance.information_leaks import INFORMED
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.walls import doorways, standing_obstacles, straight_walls
from indoor_explorers.env.scenarios.parts import Prior
from indoor_explorers.env.simulation.prior_map import prior_map
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.harness.engines.policy_process import _sealed
from tests.env.conformance.policies import MOST_CHECKS, Honest, make, passed_checks
from tests.env.maps.test_walls import MAPS

SEEDS = st.integers(0, 2**63 - 1)
SHARES = st.floats(0.0, 1.0)
NOTHING = {"kind": "outdated", "doors": 0.0, "openings": 0.0, "shift": 0.0, "furniture": 0.0}
OUTDATED = {"prior.kind": "outdated"}


@cache
def floor(name="small-floors", seed=9_000_000):
    return draw_floorplan(scenario(name), seed, 0).truth


def only(**share):
    return Prior(**(NOTHING | share))


def changed(truth, prior, now):
    """The cells that are ``now`` in the prior and not in truth."""
    return (prior != truth) & (prior == now)


def mask_of(truth, blocks):
    mask = np.zeros(truth.shape, np.bool_)
    for block in blocks:
        mask[block.cells] = True
    return mask


@given(MAPS, SEEDS)
@settings(max_examples=100, deadline=None)
def test_a_right_prior_is_the_truth_and_so_is_an_outdated_one_without_changes(truth, seed):
    for settings_ in (Prior(kind="right"), only()):
        prior = prior_map(truth, settings_, seed)
        assert np.array_equal(prior, truth)
        assert not np.shares_memory(prior, truth)


@given(MAPS, SEEDS, SHARES)
@settings(max_examples=100, deadline=None)
def test_doors_alone_shut_whole_doorways(truth, seed, share):
    prior, doors = prior_map(truth, only(doors=share), seed), doorways(truth)
    assert not changed(truth, prior, FREE).any()
    assert not changed(truth, prior, OCCUPIED)[~mask_of(truth, doors)].any()
    assert share < 1.0 or all((prior[door.cells] == OCCUPIED).all() for door in doors)


@given(MAPS, SEEDS, SHARES)
@settings(max_examples=100, deadline=None)
def test_openings_alone_are_in_straight_walls(truth, seed, share):
    prior, walls = prior_map(truth, only(openings=share), seed), straight_walls(truth)
    assert not changed(truth, prior, OCCUPIED).any()
    assert not changed(truth, prior, FREE)[~mask_of(truth, walls)].any()
    for wall in walls:
        opened = (prior[wall.cells] == FREE).any()
        assert share < 1.0 or opened
        assert not (prior[wall.cells] == FREE).all()


@given(MAPS, SEEDS, SHARES)
@settings(max_examples=100, deadline=None)
def test_furniture_alone_loses_whole_obstacles(truth, seed, share):
    prior = prior_map(truth, only(furniture=share), seed)
    assert not changed(truth, prior, OCCUPIED).any()
    left = changed(truth, prior, FREE)
    for mask, box in standing_obstacles(truth):
        gone = prior[box][mask] == FREE
        assert gone.all() or not gone.any()
        assert share < 1.0 or gone.all()
        left[box] &= ~mask
    assert not left.any()


@given(MAPS, SEEDS)
@settings(max_examples=100, deadline=None)
def test_shifted_walls_are_one_cell_away(truth, seed):
    from scipy import ndimage

    prior, walls = prior_map(truth, only(shift=1.0), seed), mask_of(truth, straight_walls(truth))
    assert not changed(truth, prior, FREE)[~walls].any()
    assert not changed(truth, prior, OCCUPIED)[~ndimage.binary_dilation(walls)].any()


def test_each_place_changes_with_its_probability():
    truth = floor()
    doors = doorways(truth)
    priors = [prior_map(truth, only(doors=0.3), seed) for seed in range(40)]
    shut = [np.mean([prior[door.cells][0, 0] == OCCUPIED for door in doors]) for prior in priors]
    assert abs(np.mean(shut) - 0.3) < 0.05


def test_one_setting_leaves_the_changes_of_the_others_alone():
    truth = floor()
    few, more = (prior_map(truth, only(doors=share, furniture=0.5), 3) for share in (0.1, 0.4))
    assert np.array_equal(changed(truth, few, FREE), changed(truth, more, FREE))
    assert (changed(truth, few, OCCUPIED) <= changed(truth, more, OCCUPIED)).all()


@pytest.mark.parametrize("name", ["small-floors", "small-offices", "small-maze", "thesis-obstacles"])
@pytest.mark.parametrize("seed", range(9_000_000, 9_000_004))
def test_by_default_an_outdated_prior_differs_and_looks_like_the_map(name, seed):
    truth = floor(name, seed)
    prior = prior_map(truth, Prior(kind="outdated"), seed)
    assert set(np.unique(prior)) <= {FREE, OCCUPIED}
    assert abs((prior == FREE).mean() - (truth == FREE).mean()) < 0.06
    assert (prior != truth).mean() < 0.1
    assert name == "thesis-obstacles" or (prior != truth).any()


def test_a_seed_has_one_prior_in_any_batch_and_process():
    task = scenario("small-floors").with_settings(OUTDATED)
    batch = World(task, 3)
    batch.reset([5, 9, 7])
    alone = World(task)
    alone.reset([9])
    assert np.array_equal(batch.prior(1), alone.prior(0))
    assert not np.array_equal(batch.prior(1), batch.prior(0))
    code = (
        "import hashlib\nfrom indoor_explorers.env import World, scenario\n"
        "world = World(scenario('small-floors').with_settings({'prior.kind': 'outdated'}))\n"
        "world.reset([9])\nprint(hashlib.sha256(world.prior(0).tobytes()).hexdigest())"
    )
    import hashlib

    told = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == hashlib.sha256(alone.prior(0).tobytes()).hexdigest()


def test_a_new_episode_has_a_new_prior():
    world = World(scenario("small-floors").with_settings(OUTDATED))
    world.reset([5])
    before = world.prior(0)
    assert world.prior(0) is before
    world.reset([6])
    assert not np.array_equal(before, world.prior(0))


@pytest.mark.parametrize("kind", ["none", "right", "outdated"])
def test_all_uavs_are_briefed_with_the_same_prior_and_can_neither_change_it_nor_find_the_truth(kind):
    world = World(scenario("small-floors").with_settings({"prior.kind": kind}))
    world.reset([5])
    priors = [world.briefing(0, n).prior for n in range(2)]
    if kind == "none":
        assert priors == [None, None]
        return
    for prior in priors:
        assert np.array_equal(prior, world.prior(0))
        assert not np.shares_memory(prior, world.state.truth)
        assert not isinstance(prior.base, np.ndarray)
        with pytest.raises(ValueError, match="WRITEABLE"):
            prior.setflags(write=True)


def test_an_isolated_policy_is_given_the_prior_and_no_truth():
    world = World(scenario("small-floors").with_settings(OUTDATED))
    world.reset([5])
    there = _sealed(pickle.loads(pickle.dumps(world.briefing(0, 1))))
    assert there.truth is None
    assert np.array_equal(there.prior, world.prior(0))
    with pytest.raises(ValueError, match="WRITEABLE"):
        there.prior.setflags(write=True)


def test_episodes_are_the_same_with_a_prior():
    found = []
    for kind in ("none", "outdated"):
        world = World(scenario("small-floors").with_settings({"prior.kind": kind}))
        world.reset([5])
        actions = np.random.default_rng(0).integers(0, 5, (30, 1, 2))
        for step in actions:
            world.step(step)
        world.briefing(0, 0)
        found.append((world.state.cell.copy(), world.state.belief.copy()))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])


class UsesPrior(Honest):
    """Prefers moves to cells of which the prior says that many around are free."""

    def __init__(self, briefing, policy):
        super().__init__(briefing, policy)
        self.prior = briefing.prior

    def act(self, view):
        if self.prior is None:
            return super().act(view)
        row, col = view.cell
        free = int((self.prior[max(0, row - 6) : row + 7, max(0, col - 6) : col + 7] == FREE).sum())
        moves = np.flatnonzero(view.legal)
        return int(moves[(free + int(self.rng.integers(9))) % len(moves)])


class FindsTruth(UsesPrior):
    """Corrects its prior by the true map."""

    def __init__(self, briefing, policy):
        super().__init__(briefing, policy)
        if self.prior is not None:
            self.prior = TRUTH[0]


#: Where a broken world leaves its true map.
TRUTH = [np.ones((16, 16), np.uint8)]


def test_a_policy_that_uses_its_prior_alone_passes_all_checks_which_then_change_more():
    found = [passed_checks(make(UsesPrior)), passed_checks(make(Honest), ["no hidden knowledge"])]
    with_prior, without = (int(each["no hidden knowledge"].split()[0]) for each in found)
    assert with_prior > without


def test_a_policy_that_gets_the_truth_by_its_prior_is_caught(monkeypatch):
    begin = World.begin

    def leaking(self, *arguments, **named):
        begin(self, *arguments, **named)
        if self.scenario.prior == INFORMED.prior:
            TRUTH[0] = self.state.truth[0]

    monkeypatch.setattr(World, "begin", leaking)
    failed = {finding.name for finding in run_checks(make(FindsTruth), MOST_CHECKS) if not finding.passed}
    assert "no hidden knowledge" in failed

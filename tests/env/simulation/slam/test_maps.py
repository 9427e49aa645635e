"""Maps of log-odds: what they show, what of it counts, and that sums are exact."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.sensing.inverse_model import HIT, PASS
from tests.env.simulation.slam.flights import EVERYTHING, begun, disc, random_actions, task

seeds = st.integers(0, 2**32)
examples = settings(max_examples=12, deadline=None)
LOSSES = st.sampled_from([{}, {"failures.hazard": 0.05}, {"failures.hazard": 0.05, "failures.last_word": True}])


def flight(seed, team, *changes, steps=20):
    """Yield the world of a random flight after each step."""
    world, rng = begun(task(team, disc(4.0), EVERYTHING, *changes), seed), np.random.default_rng(seed)
    yield world
    for _ in range(steps):
        world.step(random_actions(rng, world)[None])
        yield world


def shown(log_odds):
    return np.where(log_odds == 0, UNKNOWN, np.where(log_odds > 0, OCCUPIED, FREE))


@examples
@given(seeds, st.integers(1, 3), LOSSES)
def test_a_map_shows_what_is_more_probable_and_the_own_cell_free(seed, team, losses):
    for world in flight(seed, team, losses):
        state = world.state
        np.testing.assert_array_equal(state.union[0], shown(world.slam.log_odds[0, team]))
        for n in range(team):
            view = world.view(0, n)
            assert view.belief[view.cell] == FREE
            others = np.ones(view.belief.shape, bool)
            others[view.cell] = False
            np.testing.assert_array_equal(view.belief[others], shown(view.log_odds)[others])


@examples
@given(seeds, st.integers(1, 3), LOSSES, st.sampled_from(["reachable", "map"]))
def test_coverage_counts_the_cells_that_are_right(seed, team, losses, denominator):
    changes = {"base.at": "start", "denominator": denominator}
    for world in flight(seed, team, losses, changes):
        state = world.state
        counted, truth = state.counts[0], state.truth[0]
        right = [int((belief == truth)[counted].sum()) for belief in state.belief[0]]
        assert state.covered[0].tolist() == right
        assert state.team_covered[0] == (state.union[0] == truth)[counted].sum() <= state.total[0]
        assert state.base_covered[0] == (state.base_belief[0] == truth)[counted].sum() <= state.total[0]
        assert state.sensed_count[0].tolist() == [int(sensed[counted].sum()) for sensed in state.sensed[0]]


@examples
@given(seeds)
def test_sums_are_exact(seed):
    """Readings are multiples of 1/32: single precision holds sums of some ten thousand without rounding."""
    assert HIT * 32 == 28
    assert PASS * 32 == -13
    for world in flight(seed, 2, steps=10):
        sums = world.slam.log_odds.astype(np.float64) * 32
        np.testing.assert_array_equal(sums, np.round(sums))


@examples
@given(seeds, st.integers(1, 3))
def test_legal_moves_are_those_that_the_map_calls_free_or_unknown(seed, team):
    for world in flight(seed, team):
        for n in range(team):
            view = world.view(0, n)
            assert view.legal[4]
            for action, (down, right) in enumerate(((1, 0), (0, -1), (-1, 0), (0, 1))):
                row, col = view.cell[0] + down, view.cell[1] + right
                inside = 0 <= row < view.belief.shape[0] and 0 <= col < view.belief.shape[1]
                assert view.legal[action] == (inside and view.belief[row, col] != OCCUPIED)


@examples
@given(seeds, st.integers(1, 3))
def test_a_cell_is_discovered_or_received_once(seed, team):
    """However often a map forgets a cell and knows it again, rewards count it once."""
    counts = np.zeros(team, np.int64)
    for world in flight(seed, team, {"drift.closure_gap": 2, "drift.rate": 0.5}, steps=30):
        counts += world.state.discovered[0] + world.state.received[0]
        assert (counts <= world.state.known[0]).all()
        for n in range(team):
            log = world.state.discovery_log[0, n, : world.state.known[0, n]]
            assert len(np.unique(log)) == len(log) <= world.state.truth[0].size
            assert set(np.flatnonzero(world.state.belief[0, n] != UNKNOWN)) <= set(log.tolist())

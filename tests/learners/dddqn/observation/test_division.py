"""The division of the unseen cells among teammates: alike for all linked ones, kept without contact, and balanced."""

from itertools import count

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import PRESETS
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.observation.config import ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import observation_layout, search_costs
from indoor_explorers.learners.dddqn.observation.map_prior import no_prior

TOURS = ObservationConfig(crop=3, layers=("unknown",), coarse=0, sides=False, gains=False, visits=False)
DIVIDED = TOURS.model_copy(update={"division": True})


class Team:
    """Teams that fly tours in a few rooms."""

    def __init__(self, scenario: str, config: ObservationConfig, rooms: int) -> None:
        seeds = count(31_500_000)
        self.flight = VectorFlight(PRESETS[scenario].for_evaluation(), config, no_prior(), rooms, lambda: next(seeds))
        costs = search_costs(observation_layout(config))
        assert costs is not None
        self._costs, self.team = costs, PRESETS[scenario].team

    def observe(self) -> NDArray[np.float32]:
        self.flight.observe(np.arange(self.flight.columns))
        return self.flight.moves.copy()

    def move(self) -> None:
        """Make the best legal move of each UAV by the latest observation."""
        moves = self.flight.moves
        worth = np.where(moves[:, :, 0] == 0.0, (moves * self._costs).sum(axis=2), -np.inf)
        can = np.isfinite(worth).any(axis=1) & (self.flight.memory.nearest >= 0) & ~self.flight.over
        self.flight.step(np.where(can, worth.argmax(axis=1), 4))

    def ages(self) -> NDArray[np.int64]:
        """Steps since UAV a heard UAV m, (C, M), -1 for never."""
        state = self.flight.world.state
        heard = state.last_received_step.reshape(self.flight.columns, self.team)
        return np.where(heard >= 0, self.flight.age[:, None] - heard, -1)

    def steps_to(self, coverage: float, most: int = 60) -> NDArray[np.int64]:
        """Steps after which each team knows so much."""
        steps = np.full(self.flight.world.batch, most)
        for step in range(1, most):
            self.observe()
            self.move()
            steps = np.where(self.flight.world.team_coverage >= coverage, np.minimum(steps, step), steps)
        return steps


def parts(team: Team) -> NDArray[np.uint64]:
    """What each UAV has left to each teammate, (E, M, M, 4)."""
    return team.flight.memory.theirs.reshape(-1, team.team, team.team, 4)


def test_linked_teammates_find_the_same_division_without_overlap():
    team = Team("thesis-team-4-radio-unlimited", DIVIDED, 6)
    for _ in range(8):
        team.observe()
        left = parts(team)
        assert left.any()
        for mate in range(4):
            others = [agent for agent in range(4) if agent != mate]
            for agent in others[1:]:
                np.testing.assert_array_equal(left[:, agent, mate], left[:, others[0], mate])
        for agent in range(4):
            given = [left[:, agent, mate] for mate in range(4) if mate != agent]
            assert not (given[0] & given[1] | given[1] & given[2] | given[0] & given[2]).any()
        team.move()


def test_what_a_teammate_got_is_left_to_it_without_contact():
    team = Team("thesis-team-4", DIVIDED, 20)
    kept = changed = 0
    team.observe()
    for _ in range(12):
        before = team.flight.memory.theirs.copy()
        team.move()
        team.observe()
        ages, same = team.ages(), (team.flight.memory.theirs == before).all(axis=2)
        assert same[ages > 0].all()
        assert not team.flight.memory.theirs[ages < 0].any()
        kept, changed = kept + int((ages > 0).sum()), changed + int((~same[ages == 0]).sum())
    assert kept > 100
    assert changed > 100


@pytest.mark.parametrize("scenario", ["thesis-obstacles", "thesis-team-2-radio-0"])
def test_nothing_changes_where_nobody_is_heard(scenario):
    plain, divided = Team(scenario, TOURS, 4), Team(scenario, DIVIDED, 4)
    for _ in range(10):
        np.testing.assert_array_equal(plain.observe(), divided.observe())
        plain.move()
        divided.move()
    assert plain.flight.memory.theirs.size == 0


@pytest.mark.slow
def test_balanced_parts_save_steps():
    plain, divided = (Team("thesis-team-4-radio-unlimited", config, 60).steps_to(0.99) for config in (TOURS, DIVIDED))
    assert divided.mean() < plain.mean() - 0.5

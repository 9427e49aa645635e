"""The learned map prior: its inputs, its probabilities and its fitting."""

import numpy as np

from indoor_explorers.env import FREE, OCCUPIED, PRESETS, UNKNOWN
from indoor_explorers.learners.dddqn.learning.prior_fitting import PriorExamples, collect, fit_prior
from indoor_explorers.learners.dddqn.observation.map_prior import (
    no_prior,
    prior_arrays,
    prior_from,
    write_chances,
    write_patch,
)
from tests.learners.dddqn.rooms import random_belief, some_prior


def test_a_patch_holds_the_cells_around_one() -> None:
    belief, _ = random_belief(np.random.default_rng(1))
    padded, patch = np.pad(belief, 3, constant_values=3), np.zeros(49, np.uint8)
    for row, col in ((0, 0), (5, 9), (12, 17)):
        obstacles = write_patch(belief, row, col, patch)
        expected = padded[row : row + 7, col : col + 7]
        assert np.array_equal(patch.reshape(7, 7), expected)
        assert obstacles == (expected == OCCUPIED).sum()


def test_chances_are_those_of_the_net() -> None:
    belief, _ = random_belief(np.random.default_rng(2))
    prior, chance, patch = some_prior(), np.zeros(belief.shape, np.uint8), np.zeros(49, np.uint8)
    write_chances(belief, prior, patch, np.array([0, 0, *belief.shape]), chance)
    assert not chance[belief != UNKNOWN].any()
    for row, col in np.argwhere(belief == UNKNOWN).tolist():
        if write_patch(belief, row, col, patch) == 0:
            assert chance[row, col] == 255
            continue
        inputs = np.concatenate([patch == kind for kind in (FREE, OCCUPIED, 3)])
        hidden = np.maximum(inputs @ prior.hidden + prior.hidden_bias, 0)
        odds = hidden @ prior.out + prior.out_bias[0]
        assert abs(chance[row, col] - 255 / (1 + np.exp(-odds))) < 0.51


def test_without_a_prior_every_unknown_cell_counts() -> None:
    belief, _ = random_belief(np.random.default_rng(3))
    chance = np.zeros(belief.shape, np.uint8)
    write_chances(belief, no_prior(), np.zeros(49, np.uint8), np.array([0, 0, *belief.shape]), chance)
    assert np.array_equal(chance, np.where(belief == UNKNOWN, 255, 0))
    assert prior_arrays(no_prior()) == {}
    assert len(prior_from({}).hidden) == 0


def test_it_goes_through_a_file_s_arrays() -> None:
    prior = some_prior(4)
    for mine, other in zip(prior, prior_from(prior_arrays(prior)), strict=True):
        assert np.array_equal(mine, other)


def test_it_learns_where_obstacles_are() -> None:
    examples = collect(PRESETS["thesis-obstacles"].for_evaluation(), 5, most=12_000)
    assert len(examples.counts) == 12_000
    other = collect(PRESETS["thesis-obstacles"].for_evaluation(), 10**6, most=3_000)
    prior = fit_prior(examples, 1)
    again = fit_prior(examples, 1)
    assert all(np.array_equal(a, b) for a, b in zip(prior, again, strict=True))
    inputs = np.concatenate([other.patch == kind for kind in (1, 2, 3)], axis=1)
    odds = np.maximum(inputs @ prior.hidden + prior.hidden_bias, 0) @ prior.out + prior.out_bias
    right = ((odds > 0) == other.counts).mean()
    base = max(other.counts.mean(), 1 - other.counts.mean())
    assert right > 0.8 > base


def test_rooms_without_obstacles_have_no_prior() -> None:
    examples = collect(PRESETS["thesis-open"].for_evaluation(), 5, most=2_000)
    assert len(examples.counts) == 0
    assert len(fit_prior(examples, 1).hidden) == 0
    assert len(fit_prior(PriorExamples(np.zeros((5, 49), np.uint8), np.ones(5, np.bool_)), 1).hidden) == 0


def test_examples_of_few_maps_are_the_same_few() -> None:
    scenario = PRESETS["thesis-obstacles"].for_evaluation()
    kinds = [len(np.unique(collect(scenario, 5, 3_000, maps).patch, axis=0)) for maps in (0, 2)]
    assert kinds[1] < 0.5 * kinds[0]

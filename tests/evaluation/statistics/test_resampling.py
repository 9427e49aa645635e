"""What is drawn anew, by the sums and moments of its weights."""

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.statistics import FEWEST, maps_are_sampled, resampled_weights

UNEVEN = np.repeat([4, 1, 9, 2, 7], [1, 2, 6, 3, 4])


def drawn(count, resamples, maps=None):
    return np.concatenate(list(resampled_weights(count, resamples, maps)))


@pytest.mark.parametrize("maps", [None, UNEVEN, UNEVEN % 3, np.zeros(16), np.arange(16)])
def test_each_resample_is_an_average_of_episodes(maps):
    weights = drawn(16, 3000, maps)
    assert weights.shape == (3000, 16)
    assert (weights >= 0).all()
    assert weights.sum(axis=1) == pytest.approx(np.ones(3000))


def test_every_episode_on_its_own_map_is_the_plain_bootstrap():
    assert (drawn(30, 500, np.arange(30)) == drawn(30, 500)).all()
    assert (drawn(30, 500, np.arange(30)[::-1]) == drawn(30, 500)).all()


def test_labels_carry_no_meaning():
    names = np.array(["attic", "barn", "cave", "dome", "east"])
    assert (drawn(16, 200, UNEVEN) == drawn(16, 200, names[np.searchsorted([1, 2, 4, 7, 9], UNEVEN)])).all()


def test_maps_are_drawn_whole_before_episodes():
    maps = np.arange(60) // 10
    by_map = drawn(60, 4000, maps).reshape(4000, 6, 10).sum(axis=2)
    assert set(np.round(by_map * 6, 9).ravel()) <= {0, 1, 2, 3, 4, 5, 6}
    assert by_map.var(axis=0) == pytest.approx(np.full(6, 5 / 6**3), rel=0.1)


def test_both_levels_add_to_the_variance():
    rng = np.random.default_rng(1)
    maps = np.repeat(np.arange(8), 5)
    values = rng.normal(0, 2, 8)[maps] + rng.normal(0, 1, 40)
    means = values.reshape(8, 5).mean(axis=1)
    expected = means.var() / 8 + values.reshape(8, 5).var(axis=1).mean() / 40
    assert (drawn(40, 20_000, maps) @ values).var() == pytest.approx(expected, rel=0.05)


def test_fixed_maps_keep_their_share():
    maps = np.repeat([0, 1, 2], [2, 5, 9])
    weights = drawn(16, 1000, maps)
    for label, share in ((0, 2 / 16), (1, 5 / 16), (2, 9 / 16)):
        assert weights[:, maps == label].sum(axis=1) == pytest.approx(np.full(1000, share))


def test_too_few_maps_are_fixed():
    assert not maps_are_sampled(np.arange(100) % (FEWEST - 1))
    assert maps_are_sampled(np.arange(100) % FEWEST)
    assert maps_are_sampled(None)


def test_chunks_are_small_and_make_no_difference(monkeypatch):
    whole = drawn(16, 300, UNEVEN)
    monkeypatch.setattr("indoor_explorers.evaluation.statistics.resampling.CHUNK", 16 * 7)
    monkeypatch.setattr("indoor_explorers.evaluation.statistics.resampling.FEWEST_ROWS", 1)
    chunks = list(resampled_weights(16, 300, UNEVEN))
    assert max(len(chunk) for chunk in chunks) == 7
    assert (np.concatenate(chunks) == whole).all()


def test_maps_of_other_episodes_are_refused():
    with pytest.raises(InputError, match=r"maps of 4 episodes.*\(3,\)"):
        next(resampled_weights(4, 10, [0, 1, 2]))

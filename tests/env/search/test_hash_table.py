"""Hash tables of searches: nothing new is taken for known, and what there is room for is known again."""

import numpy as np

from indoor_explorers.env.grid.compiled import kernel
from indoor_explorers.env.search.bitsets import PROBES, is_new


@kernel()
def told_new(table: np.ndarray, keys: np.ndarray, out: np.ndarray) -> None:
    for n in range(len(keys)):
        out[n] = is_new(table, keys[n])


def answers(size, keys):
    out = np.zeros(len(keys), np.bool_)
    told_new(np.zeros(size, np.uint64), keys, out)
    return out


def test_with_room_for_all_it_tells_as_a_set_does():
    rng = np.random.default_rng(1)
    keys = rng.integers(0, 2**63, 200, dtype=np.uint64)
    keys = keys[rng.integers(0, len(keys), 1000)]
    met, expected = set(), []
    for key in keys.tolist():
        expected.append(key | 1 not in met)
        met.add(key | 1)
    assert np.array_equal(answers(4096, keys), expected)
    assert 0 < sum(expected) < 200 + 1


def test_without_room_it_takes_the_known_for_new_and_never_the_other_way_round():
    keys = np.arange(1, 2 * PROBES, 2, dtype=np.uint64)  # all in the first slot
    keys = np.concatenate([keys, [np.uint64(99)], keys, [np.uint64(99)]])
    assert np.array_equal(answers(64, keys), [True] * (PROBES + 1) + [False] * PROBES + [True])

"""The random streams of an episode."""

import pickle

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, World
from indoor_explorers.env.grid.randomness import Stream, generator

#: Seeds that no accident gives.
SEEDS = (3_141_592_653, 2**62 + 12345)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_stream_draws_what_its_seed_sequence_says(seed):
    for stream in Stream:
        expected = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(stream), 2)))
        np.testing.assert_array_equal(generator(seed, stream, 2).random(50), expected.random(50))
        assert generator(seed, stream, 2).integers(9) == generator(seed, stream, 2).integers(9)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_pilots_generator_does_not_tell_the_seed(seed):
    world = World(PRESETS["thesis-open"])
    world.reset([seed])
    rng = world.briefing(0, 0).rng
    for each in (rng, pickle.loads(pickle.dumps(rng)), *rng.spawn(2)):
        bits = each.bit_generator
        told = repr((each.__reduce__(), bits.state, bits.__reduce__(), bits.__getstate__(), bits.seed_seq.state))
        assert "entropy" in told
        assert str(seed) not in told
        assert str(np.random.SeedSequence(seed).pool[0]) not in repr(bits.seed_seq.pool)


def test_spawned_generators_of_pilots_are_apart_and_the_same_every_time():
    def drawn(seed, agent):
        return generator(seed, Stream.PILOT, agent).spawn(2)[1].random()

    draws = [drawn(seed, agent) for seed in range(5) for agent in range(4)]
    assert len(set(draws)) == len(draws)
    assert drawn(3, 1) == draws[13]

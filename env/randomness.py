"""Separate random streams, all from one episode seed.

A policy that draws more numbers can never change the map, the spawns or the order of moves: every
purpose has a stream of its own. Streams used in Python are :class:`numpy.random.Generator`; the order of
moves is drawn inside compiled code by a counter-based generator, so that it depends on (seed, step)
alone and not on what came before.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numba import njit

GOLDEN = np.uint64(0x9E3779B97F4A7C15)


class Stream(IntEnum):
    """What a random stream is for; the value is part of its seed and never changes."""

    MAP = 0
    SPAWN = 1
    ORDER = 2
    RADIO = 3
    PILOT = 4


def generator(seed: int, stream: Stream, index: int = 0) -> np.random.Generator:
    """Return the generator of one stream of an episode; ``index`` tells pilots (agents) apart."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(stream), index)))


def counter_key(seed: int, stream: Stream) -> np.uint64:
    """Return the 64-bit key of a counter-based stream for use in compiled code."""
    return np.uint64(np.random.SeedSequence(seed, spawn_key=(int(stream), 0)).generate_state(1, np.uint64)[0])


@njit(cache=True, nogil=True, inline="always")
def draw(key: np.uint64, counter: np.uint64) -> np.uint64:
    """Return 64 random bits for (key, counter): the finaliser of SplitMix64 (Steele et al. 2014)."""
    z = key + (counter + np.uint64(1)) * GOLDEN
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(cache=True, nogil=True)
def shuffled(key: np.uint64, step: int, out: np.ndarray) -> None:
    """Fill ``out`` (n,) with a random permutation of 0..n-1 that depends on (key, step) only."""
    n = out.shape[0]
    base = draw(key, np.uint64(step))
    for i in range(n):
        out[i] = i
    for i in range(n - 1, 0, -1):
        j = np.int64(draw(base, np.uint64(i)) % np.uint64(i + 1))
        out[i], out[j] = out[j], out[i]

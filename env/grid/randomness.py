"""Separate random streams for each purpose, all from one episode seed.

A policy that draws more numbers can never change the map, the spawns or the order of moves. Streams used in Python are
:class:`numpy.random.Generator`; compiled code draws from a counter-based generator, so that its numbers depend on
(seed, step) alone and not on earlier draws.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.compiled import inner, leaf

#: The first episode seed that is too large.
SEED_LIMIT = 2**63

GOLDEN = np.uint64(0x9E3779B97F4A7C15)


class Stream(IntEnum):
    """The purpose of a random stream; the value is part of its seed and never changes."""

    MAP = 0
    SPAWN = 1
    ORDER = 2
    RADIO = 3
    PILOT = 4
    FAILURE = 5
    PRIOR = 6
    NOISE = 7
    DRIFT = 8


def generator(seed: int, stream: Stream, index: int = 0) -> np.random.Generator:
    """Return the generator of one stream of an episode; ``index`` distinguishes pilots (agents).

    Its ``seed_seq``, which ``spawn`` and ``pickle`` read, is made from random words of the stream and does not contain
    the seed, with which a pilot could draw the true map.
    """
    sequence = np.random.SeedSequence(seed, spawn_key=(int(stream), index))
    bits = np.random.PCG64(np.random.SeedSequence(sequence.generate_state(4).tolist()))
    bits.state = np.random.PCG64(sequence).state
    return np.random.Generator(bits)


def checked_seed(seed: int) -> int:
    """Return an episode seed, refusing one that is out of range."""
    if not 0 <= int(seed) < SEED_LIMIT:
        raise InputError(f"expected a seed from 0 to {SEED_LIMIT - 1}, got {seed}")
    return int(seed)


@leaf()
def draw(key: np.uint64, counter: np.uint64) -> np.uint64:
    """Return 64 random bits for (key, counter): the finaliser of SplitMix64 (Steele et al. 2014)."""
    z = key + (counter + np.uint64(1)) * GOLDEN
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@inner()
def uniform(key: np.uint64, counter: int) -> float:
    """Draw a number in [0, 1) for (key, counter)."""
    return float((draw(key, np.uint64(counter)) >> np.uint64(11)) * 2.0**-53)


@leaf()
def stream_key(seed: int, stream: int, index: int = 0) -> np.uint64:
    """Return the 64-bit key of a counter-based stream of an episode, for use with :func:`draw`."""
    return draw(draw(draw(np.uint64(0), np.uint64(seed)), np.uint64(stream)), np.uint64(index))


@leaf(entry=False)
def below(key: np.uint64, counter: int, bound: int) -> int:
    """Draw an integer from 0 to ``bound`` - 1; its bias is under ``bound`` / 2^64."""
    return int(draw(key, np.uint64(counter)) % np.uint64(bound))


@leaf()
def shuffled(key: np.uint64, step: int, out: np.ndarray) -> None:
    """Fill ``out`` (n,) with a random permutation of 0..n-1 that depends on (key, step) only."""
    n = out.shape[0]
    base = draw(key, np.uint64(step))
    for i in range(n):
        out[i] = i
    for i in range(n - 1, 0, -1):
        j = np.int64(draw(base, np.uint64(i)) % np.uint64(i + 1))
        out[i], out[j] = out[j], out[i]

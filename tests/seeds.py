"""Find an episode's seed as a cheating plug-in would: by trying small seeds."""

from indoor_explorers.env.grid.randomness import Stream, generator


def seed_of(briefing, seeds=range(200)):
    """The seed whose generator a new pilot was given."""
    state = briefing.rng.bit_generator.state
    return next(seed for seed in seeds if generator(seed, Stream.PILOT, briefing.agent).bit_generator.state == state)

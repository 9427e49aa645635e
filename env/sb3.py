"""The former name of :mod:`indoor_explorers.env.interfaces.stable_baselines`, kept for scripts that import it."""

from indoor_explorers.env.interfaces.stable_baselines import StableBaselinesVecEnv

__all__ = ["StableBaselinesVecEnv"]

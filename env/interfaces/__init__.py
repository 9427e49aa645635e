"""The world as a Gymnasium, PettingZoo or Stable-Baselines3 environment, and views and goals for robots that run ROS.

Each interface, with the library that it needs, is imported on first use.
"""

from typing import TYPE_CHECKING

from indoor_explorers.env.lazy_names import lazy_names

if TYPE_CHECKING:
    from indoor_explorers.env.interfaces.gymnasium_env import IndoorExplorersEnv
    from indoor_explorers.env.interfaces.pettingzoo import env, parallel_env
    from indoor_explorers.env.interfaces.ros import Goal, GridFrame, Robot
    from indoor_explorers.env.interfaces.stable_baselines import StableBaselinesVecEnv
    from indoor_explorers.env.interfaces.vector import IndoorExplorersVectorEnv

__all__ = [
    "Goal",
    "GridFrame",
    "IndoorExplorersEnv",
    "IndoorExplorersVectorEnv",
    "Robot",
    "StableBaselinesVecEnv",
    "env",
    "parallel_env",
]

_MODULES = {
    "gymnasium_env": ("IndoorExplorersEnv",),
    "pettingzoo": ("env", "parallel_env"),
    "ros": ("Goal", "GridFrame", "Robot"),
    "stable_baselines": ("StableBaselinesVecEnv",),
    "vector": ("IndoorExplorersVectorEnv",),
}

__getattr__ = lazy_names(__name__, _MODULES)

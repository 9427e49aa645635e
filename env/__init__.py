"""The shared world: scenarios, the simulator, views and briefings of a UAV, and the policy interface.

A name is imported on first use, so that a program loads only what it needs.
"""

from typing import TYPE_CHECKING

import gymnasium

from indoor_explorers.env.lazy_names import lazy_names

if TYPE_CHECKING:
    from indoor_explorers.env.conformance import Finding, check_policy, run_checks
    from indoor_explorers.env.errors import InputError, PolicyError
    from indoor_explorers.env.grid.cells import FREE, OCCUPIED, TURN, UNKNOWN, Action
    from indoor_explorers.env.grid.levels import ASCEND, DESCEND, Levels
    from indoor_explorers.env.interfaces.pettingzoo import env, parallel_env
    from indoor_explorers.env.maps.base import GeneratedMaps, MapReader
    from indoor_explorers.env.observations.incremental import LivePlanes
    from indoor_explorers.env.policies.explanation import Candidate, Explanation
    from indoor_explorers.env.policies.policy import Pilot, Policy
    from indoor_explorers.env.policies.registry import make_policy, policy_names
    from indoor_explorers.env.policies.view import Briefing, Mate, Message, View
    from indoor_explorers.env.scenarios.loading import load_scenario
    from indoor_explorers.env.scenarios.presets import PRESETS, scenario
    from indoor_explorers.env.scenarios.scenario import Scenario
    from indoor_explorers.env.simulation.state import End
    from indoor_explorers.env.simulation.world import World

__all__ = [
    "ASCEND",
    "DESCEND",
    "FREE",
    "OCCUPIED",
    "PRESETS",
    "TURN",
    "UNKNOWN",
    "Action",
    "Briefing",
    "Candidate",
    "End",
    "Explanation",
    "Finding",
    "GeneratedMaps",
    "InputError",
    "Levels",
    "LivePlanes",
    "MapReader",
    "Mate",
    "Message",
    "Pilot",
    "Policy",
    "PolicyError",
    "Scenario",
    "View",
    "World",
    "check_policy",
    "env",
    "load_scenario",
    "make_policy",
    "parallel_env",
    "policy_names",
    "run_checks",
    "scenario",
]

#: The public names of each module.
_MODULES = {
    "conformance": ("Finding", "check_policy", "run_checks"),
    "errors": ("InputError", "PolicyError"),
    "grid.cells": ("FREE", "OCCUPIED", "TURN", "UNKNOWN", "Action"),
    "grid.levels": ("ASCEND", "DESCEND", "Levels"),
    "interfaces.pettingzoo": ("env", "parallel_env"),
    "maps.base": ("GeneratedMaps", "MapReader"),
    "observations.incremental": ("LivePlanes",),
    "policies.explanation": ("Candidate", "Explanation"),
    "policies.policy": ("Pilot", "Policy"),
    "policies.registry": ("make_policy", "policy_names"),
    "policies.view": ("Briefing", "Mate", "Message", "View"),
    "scenarios.loading": ("load_scenario",),
    "scenarios.presets": ("PRESETS", "scenario"),
    "scenarios.scenario": ("Scenario",),
    "simulation.state": ("End",),
    "simulation.world": ("World",),
}
__getattr__ = lazy_names(__name__, _MODULES)

gymnasium.register(
    id="IndoorExplorers-v0",
    entry_point="indoor_explorers.env.interfaces.gymnasium_env:IndoorExplorersEnv",
    vector_entry_point="indoor_explorers.env.interfaces.vector:IndoorExplorersVectorEnv",
)


def __dir__() -> list[str]:
    return [*globals(), *__all__]

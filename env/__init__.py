"""The shared world: scenarios, the simulator, what a UAV may know, and the policy interface."""

import gymnasium

from indoor_explorers.env.conformance import Finding, check_policy, run_checks
from indoor_explorers.env.errors import InputError, PolicyError
from indoor_explorers.env.grid import FREE, OCCUPIED, UNKNOWN, Action
from indoor_explorers.env.live import LivePlanes
from indoor_explorers.env.marl import env, parallel_env
from indoor_explorers.env.policy import Pilot, Policy
from indoor_explorers.env.presets import PRESETS, scenario
from indoor_explorers.env.registry import make_policy, policy_names
from indoor_explorers.env.scenario import Scenario
from indoor_explorers.env.view import Briefing, Mate, Message, View
from indoor_explorers.env.world import World

__all__ = [
    "FREE",
    "OCCUPIED",
    "PRESETS",
    "UNKNOWN",
    "Action",
    "Briefing",
    "Finding",
    "InputError",
    "LivePlanes",
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
    "make_policy",
    "parallel_env",
    "policy_names",
    "run_checks",
    "scenario",
]

gymnasium.register(
    id="IndoorExplorers-v0",
    entry_point="indoor_explorers.env.gym:IndoorExplorersEnv",
    vector_entry_point="indoor_explorers.env.vector:IndoorExplorersVectorEnv",
)

"""The shared world: scenarios, the simulator, what a UAV may know, and the policy interface."""

from indoor_explorers.env.conformance import check_policy
from indoor_explorers.env.errors import InputError, PolicyError
from indoor_explorers.env.grid import FREE, OCCUPIED, UNKNOWN, Action
from indoor_explorers.env.policy import Pilot, Policy
from indoor_explorers.env.registry import make_policy, policy_names
from indoor_explorers.env.scenario import PRESETS, Scenario, scenario
from indoor_explorers.env.view import Briefing, Mate, Message, View
from indoor_explorers.env.world import World

__all__ = [
    "FREE",
    "OCCUPIED",
    "PRESETS",
    "UNKNOWN",
    "Action",
    "Briefing",
    "InputError",
    "Mate",
    "Message",
    "Pilot",
    "Policy",
    "PolicyError",
    "Scenario",
    "View",
    "World",
    "check_policy",
    "make_policy",
    "policy_names",
    "scenario",
]

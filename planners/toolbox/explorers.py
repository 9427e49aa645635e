"""Policies that let another policy explore, and the numbers that their UAVs add to its messages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from indoor_explorers.env.errors import InputError, shown
from indoor_explorers.env.policies.policy import Policy
from indoor_explorers.env.policies.registry import make_policy, with_parameters
from indoor_explorers.env.policies.view import MESSAGE_LIMIT, Mate, Message
from indoor_explorers.planners.toolbox.parameters import Parameters


@dataclass(frozen=True, kw_only=True)
class ExploringWith(Parameters, Policy):
    """The parameter of a policy that lets another one explore.

    Raises:
        InputError: there is no such policy, or it is given the true map.

    """

    explorer: str = "frontier"
    """Registry name of the policy that explores, with its parameters in parentheses if there are any."""

    def __post_init__(self) -> None:
        """Check the parameters and the explorer, and take over whether the explorer reads the generator."""
        super().__post_init__()
        explorer = self.make_explorer()
        if explorer.privileged:
            name = type(self).__name__
            raise InputError(f"{name}: expected an explorer that is not given the map, got {self.explorer!r}")
        object.__setattr__(self, "uses_generator", explorer.uses_generator)

    def make_explorer(self) -> Policy:
        """Make the policy that explores."""
        if not isinstance(self.explorer, str):
            given = shown(self.explorer)
            raise InputError(f"{type(self).__name__}: expected the name of a policy as explorer, got {given}")
        name, parameters = with_parameters(self.explorer)
        return make_policy(name, **parameters)

    def provenance(self) -> dict[str, str]:
        """Return what the explorer declares, such as a hash of its weights."""
        return self.make_explorer().provenance()

    def seen_seeds(self) -> Mapping[str, Sequence[range]]:
        """Return the seeds that the explorer was trained, validated or tuned on."""
        return self.make_explorer().seen_seeds()

    def seen_maps(self) -> Mapping[str, Sequence[str]]:
        """Return the maps that the explorer was trained, validated or tuned on."""
        return self.make_explorer().seen_maps()


def with_added(message: Message, *numbers: float) -> Message:
    """Return an explorer's message with numbers at its end; the numbers alone where it would be too long."""
    kept = message if message and len(message) + len(numbers) <= MESSAGE_LIMIT else ()
    return (*kept, *map(float, numbers))


def added(mate: Mate, count: int) -> tuple[float, ...]:
    """Return the numbers that a teammate's message has at its end; empty if it has fewer."""
    return mate.message[-count:] if mate.message and len(mate.message) >= count else ()


def without_added(mates: tuple[Mate, ...], count: int) -> tuple[Mate, ...]:
    """Return the teammates with the messages that their explorers sent."""
    return tuple(mate._replace(message=(mate.message or ())[:-count] or None) for mate in mates)

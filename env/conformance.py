"""The conformance suite every policy must pass."""

from __future__ import annotations

from indoor_explorers.env.policy import Policy


def check_policy(policy: Policy) -> None:
    """Placeholder until the suite stands."""

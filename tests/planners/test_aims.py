"""Every policy that ships says what coverage it plans for."""

import pytest

from indoor_explorers.env import make_policy
from indoor_explorers.env.policies.registry import policy_entry_points


@pytest.mark.parametrize("name", [name for name, entry in policy_entry_points().items() if "indoor_exp" in entry.value])
def test_a_policy_states_its_aim(name: str) -> None:
    assert make_policy(name).plans_for

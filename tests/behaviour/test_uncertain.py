"""Every policy flies where sensors and poses err: maps that are wrong and poses that drift are nothing to fail on."""

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.env.simulation.state import End
from tests.behaviour.policies import ALIKE, POLICIES, UNRELIABLE, parametrized

ERRORS = {
    **{"noise.misses": 0.05, "noise.false_returns": 0.01, "noise.range_std": 0.3},
    **{"drift.rate": 0.05, "lidar.field_of_view": 120.0},
}
TASK = {"team": 2, "radio.model": "disc", "radio.range": 6.0, "on_collision": "block", "budget": 40}
#: They plan on the true map, from where they believe to be.
PRIVILEGED = ("optimum", "reference")


@parametrized([name for name in POLICIES if name not in PRIVILEGED], slow=ALIKE)
def test_a_policy_flies_with_errors(name):
    task = scenario("thesis-obstacles").for_evaluation().with_settings(TASK | ERRORS)
    policy, world = make_policy(name), World(task, 2)
    assert not policy.privileged
    world.reset([3, 4])
    for _ in rollout(world, ask_pilots(policy, make_pilots(policy, world), world)):
        pass
    assert (world.state.end == End.BUDGET).all()
    assert world.state.path_length.min() >= 1
    assert world.team_coverage.min() > 0.5 or name in UNRELIABLE

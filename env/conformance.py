"""The conformance suite every policy must pass, the project's own and everybody's plug-in."""

from __future__ import annotations

import pickle
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from indoor_explorers.env.arrays import Cell
from indoor_explorers.env.errors import PolicyError
from indoor_explorers.env.grid import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policy import Pilot, Policy, is_action
from indoor_explorers.env.presets import PRESETS
from indoor_explorers.env.scenario import Scenario
from indoor_explorers.env.view import MESSAGE_LIMIT, View
from indoor_explorers.env.world import World

#: Steps flown in each check.
STEPS = 60


class Setup(NamedTuple):
    """Start of an episode: a seed, and a map and spawns that replace what it would draw."""

    seed: int
    floorplan: Floorplan | None = None
    spawns: tuple[Cell, ...] | None = None


@dataclass
class Trace:
    """What one checked episode was: the choices, and the knowledge they were made from."""

    setup: Setup
    actions: list[tuple[int, ...]] = field(default_factory=list)
    knowledge: list[bytes] = field(default_factory=list)
    unseen: list[bytes] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    into_walls: int = 0


def check_policy(policy: Policy) -> dict[str, str]:
    """Fly a policy through the conformance suite; return what each check found.

    Raises:
        PolicyError: the policy breaks its contract; the message names the likely cause.

    """
    solo = PRESETS["thesis-obstacles"].for_evaluation()
    team = PRESETS["thesis-team-4"].for_evaluation()
    first, other = Setup(11), Setup(12)
    alone = [trace for scenario in (solo, team) for trace in fly_checked(policy, scenario, [first])]
    report = {"actions": _actions_found(alone), "messages": f"None or at most {MESSAGE_LIMIT} numbers, as agreed"}
    report["same seed, same episode"] = _check_repeatable(policy, solo, team, alone)
    report["pickling"] = _check_pickling(policy, team, alone[1])
    report["pilots share nothing"] = _check_independent(policy, team, [first, other], alone[1])
    report["no hidden knowledge"] = _check_hidden(policy, [(solo, alone[0]), (team, alone[1])])
    report["latency"] = _latency(alone)
    return report


def fly_checked(policy: Policy, scenario: Scenario, setups: Sequence[Setup], steps: int = STEPS) -> list[Trace]:
    """Fly episodes side by side, checking each decision; return their traces."""
    world = World(scenario, len(setups))
    for b, setup in enumerate(setups):
        world.begin(b, setup.seed, floorplan=setup.floorplan, spawns=setup.spawns)
    pilots = [[_pilot(policy, world, b, n) for n in range(scenario.team)] for b in range(len(setups))]
    traces = [Trace(setup) for setup in setups]
    for _ in range(steps):
        asked = [(b, n) for b, n in np.argwhere(world.flying).tolist()]
        if not asked:
            break
        actions = np.full((len(setups), scenario.team), 4)
        for (b, n), action in zip(asked, _decide(policy, world, pilots, asked, traces), strict=True):
            actions[b, n] = action
        for b in sorted({b for b, _ in asked}):
            traces[b].actions.append(tuple(actions[b].tolist()))
        world.step(actions)
    return traces


def _pilot(policy: Policy, world: World, b: int, n: int) -> Pilot:
    pilot = policy.pilot(world.briefing(b, n, privileged=policy.privileged))
    if not isinstance(pilot, Pilot):
        raise PolicyError(f"expected policy.pilot to return a Pilot, got {type(pilot).__name__}; subclass Pilot")
    return pilot


def _decide(
    policy: Policy, world: World, pilots: list[list[Pilot]], asked: list[tuple[int, int]], traces: list[Trace]
) -> list[int]:
    views = [world.view(b, n) for b, n in asked]
    for b in sorted({b for b, _ in asked}):
        traces[b].knowledge.append(_knowledge(world, b))
        traces[b].unseen.append((world.state.union[b] == UNKNOWN).tobytes())
    before = [_frozen(view) for view in views]
    start = time.perf_counter()
    try:
        chosen = list(policy.act([pilots[b][n] for b, n in asked], views))
    except Exception as error:
        cause = "; views are read-only, copy what you change" if "read-only" in str(error) else ""
        raise PolicyError(f"act raised {type(error).__name__}: {error}{cause}") from error
    share = (time.perf_counter() - start) / len(asked)
    if [_frozen(view) for view in views] != before:
        raise PolicyError("act changed the view it was given; copy the belief before you write to it")
    if len(chosen) != len(asked):
        raise PolicyError(f"expected {len(asked)} actions from act, one for each pilot, got {len(chosen)}")
    for (b, n), view, action in zip(asked, views, chosen, strict=True):
        traces[b].seconds.append(share)
        traces[b].into_walls += not view.legal[_checked_action(action)]
        world.post(b, n, _checked_message(pilots[b][n].message))
    return [int(action) for action in chosen]


def _knowledge(world: World, b: int) -> bytes:
    """Return all that the team's views show of the map, and who still flies."""
    state = world.state
    return b"".join((state.belief[b].tobytes(), state.cell[b].tobytes(), state.end[b].tobytes()))


def _frozen(view: View) -> tuple[Any, ...]:
    arrays = (view.belief.tobytes(), view.legal.tobytes(), view.visited.tobytes())
    return (*arrays, view.cell, view.step, view.budget, view.mates)


def _checked_action(action: Any) -> int:
    if not is_action(action):
        raise PolicyError(
            f"expected an action from 0 to 4 (down, left, up, right, stay), got {action!r}; "
            "return an int, such as int(np.argmax(values))"
        )
    return int(action)


def _checked_message(message: Any) -> Any:
    if message is None:
        return None
    numbers = isinstance(message, tuple) and all(isinstance(x, (int, float, np.number)) for x in message)
    if not numbers or len(message) > MESSAGE_LIMIT or not np.isfinite(message).all():
        raise PolicyError(
            f"expected pilot.message to be None or a tuple of at most {MESSAGE_LIMIT} finite numbers, got {message!r}"
        )
    return message


def _actions_found(traces: Sequence[Trace]) -> str:
    moves = sum(len(trace.seconds) for trace in traces)
    return f"{moves} decisions, {sum(trace.into_walls for trace in traces)} of them into a wall or off the map"


def _check_repeatable(policy: Policy, solo: Scenario, team: Scenario, alone: Sequence[Trace]) -> str:
    for scenario, trace in zip((solo, team), alone, strict=True):
        (again,) = fly_checked(policy, scenario, [trace.setup])
        _must_equal(
            again.actions,
            trace.actions,
            "the same seed gave another episode; draw from briefing.rng only, keep nothing in the policy or in globals",
        )
    return "yes, one UAV and four"


def _check_pickling(policy: Policy, scenario: Scenario, trace: Trace) -> str:
    try:
        copy = pickle.loads(pickle.dumps(policy))
    except Exception as error:
        raise PolicyError(
            f"the policy cannot be pickled ({type(error).__name__}: {error}), which worker processes need; "
            "keep lambdas, open files and locks out of it, or load them when a pilot is made"
        ) from error
    (again,) = fly_checked(copy, scenario, [trace.setup])
    _must_equal(
        again.actions, trace.actions, "a pickled copy flew another episode; everything it needs must be pickled with it"
    )
    return "a copy flies the same episode"


def _check_independent(policy: Policy, scenario: Scenario, setups: Sequence[Setup], trace: Trace) -> str:
    beside, _ = fly_checked(policy, scenario, setups)
    _must_equal(
        beside.actions,
        trace.actions,
        "an episode flown beside another one came out differently; pilots share state, keep it in the pilot and not in "
        "the policy, its class or a default argument (and in a batched act, let no episode look at another)",
    )
    return "yes, an episode is the same beside another one"


def _check_hidden(policy: Policy, flown: Sequence[tuple[Scenario, Trace]]) -> str:
    """Change cells nobody has seen, and replay: up to then every choice must be the same."""
    if policy.privileged:
        return "not checked: the policy is privileged and knows the true map"
    changed = 0
    for scenario, trace in flown:
        for step in (1, 5, 15, 30):
            hidden = changed_where_unseen(scenario, trace, step) if step < len(trace.actions) else None
            if hidden is None:
                continue
            changed += 1
            (again,) = fly_checked(policy, scenario, [hidden], step + 1)
            _must_equal(
                again.actions,
                trace.actions[: step + 1],
                f"changing cells that no UAV had seen by step {step} changed what was done by then; use the view and "
                "the briefing only, never the world or the scenario's map source",
            )
    return f"{changed} changes of unseen cells changed nothing"


def changed_where_unseen(scenario: Scenario, trace: Trace, step: int) -> Setup | None:
    """Return the trace's start with unseen cells changed such that all is seen alike up to ``step``.

    A sight line may run through a cell whose centre was not seen; such changes are found by flying the
    recorded actions again and comparing the knowledge, and are not used. None when no change remains.
    """
    world = World(scenario)
    world.begin(0, trace.setup.seed, floorplan=trace.setup.floorplan, spawns=trace.setup.spawns)
    plan = world.floorplan(0)
    spawns = tuple((int(row), int(col)) for row, col in world.state.cell[0])
    unseen = np.frombuffer(trace.unseen[step], np.bool_).reshape(plan.shape)
    rng = np.random.default_rng(step)
    for share in (0.5, 0.1, 0.02):
        flip = unseen & (rng.random(plan.shape) < share)
        truth = np.where(flip, np.where(plan.truth == FREE, OCCUPIED, FREE), plan.truth).astype(np.uint8)
        setup = Setup(trace.setup.seed, Floorplan(truth, "changed where unseen"), spawns)
        if flip.any() and _looks_alike(scenario, setup, trace, step):
            return setup
    return None


def _looks_alike(scenario: Scenario, setup: Setup, trace: Trace, step: int) -> bool:
    world = World(scenario)
    world.begin(0, setup.seed, floorplan=setup.floorplan, spawns=setup.spawns)
    for t in range(step + 1):
        if _knowledge(world, 0) != trace.knowledge[t]:
            return False
        world.step(np.array([trace.actions[t]]))
    return True


def _must_equal(found: list[tuple[int, ...]], expected: list[tuple[int, ...]], cause: str) -> None:
    if found != expected:
        step = next((t for t, (a, b) in enumerate(zip(found, expected, strict=False)) if a != b), len(found))
        raise PolicyError(f"{cause} (first difference at step {step})")


def _latency(traces: Sequence[Trace]) -> str:
    seconds = np.concatenate([trace.seconds for trace in traces]) * 1e6
    return f"median {np.median(seconds):.0f} us a decision, 99th percentile {np.percentile(seconds, 99):.0f} us"

"""Bat algorithm: joint plans of the linked group by echolocation (Yang 2010), with the scouts of bee colonies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.policies.policy import Pilot
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.planners.swarm.assignment import Assignment, AssignmentProblem, Plan, value
from indoor_explorers.planners.swarm.particles import Code, code_of, decode, initial_keys
from indoor_explorers.planners.swarm.pso import Pso, PsoPilot
from indoor_explorers.planners.toolbox.parameters import bounded

#: Random numbers of a bat in a round besides two for each key: for its frequency, its pulse and its loudness.
DRAWS = 3


class BatRules(NamedTuple):
    """The parameters of the bats for compiled code; see :class:`Bat`."""

    frequency: float
    loudness: float
    quieter: float
    pulse: float
    quickening: float
    stride: float
    limit: float


@renamed()
@dataclass(frozen=True, kw_only=True)
class Bat(Pso):
    """Assign several goals to each UAV of the linked group as ``pso`` does, by bats in place of particles.

    A bat is a joint plan, encoded by a key in [0, 1] for each goal of each UAV; the fitness and the four initial plans
    are those of ``pso``. In each round a bat draws a frequency f, changes its velocity by (x* - x) f, x* the best
    position of all, and flies on (equations 2 to 4 of the paper). With probability 1 - r, r its pulse rate, it looks
    around x* instead, at most ``stride`` times the mean loudness away (equation 5). It stays at a position that is no
    worse than its last one with probability A, its loudness; then A falls by a factor and r rises to its limit
    (equation 6): a bat that has found its prey gets quieter and calls more often. The improved algorithm takes scouts
    from bee colonies: a bat without an improvement in ``limit`` rounds starts again at a random position, as loud as at
    first. The best position is never lost, so the plan is no worse than the initial ones.

    Differences: the paper writes the velocity with x - x*, which leads away from the best position. As with ``pso``,
    the search finds fitter plans than the initial ones, and hardly changes the steps of an exploration: ``rounds`` 0
    needs about as many.

    X.-S. Yang, "A new metaheuristic bat-inspired algorithm", NICSO 2010, doi:10.1007/978-3-642-12538-6_6. Scouts:
    D. Karaboga, B. Basturk, "A powerful and efficient algorithm for numerical function optimization: artificial bee
    colony (ABC) algorithm", Journal of Global Optimization 39, 2007, doi:10.1007/s10898-007-9149-x. The fitness is this
    project's.
    """

    particles: int = 20
    """Bats of the swarm, including the four that start from the initial plans."""
    rounds: int = 30
    """Most iterations of the swarm; with 0 the best initial plan is flown."""
    frequency: float = bounded(0.5, least=0, tunable=(0.1, 2.0, "log"))
    """Highest frequency, the lowest is 0: share of the way to the best position by which a velocity changes."""
    loudness: float = bounded(1.0, least=1e-6, most=1, tunable=(0.1, 1.0))
    """Probability at first that a bat accepts a position that is no worse, above 0 and at most 1 (paper: A_0)."""
    quieter: float = bounded(0.9, least=0, most=1, tunable=(0.5, 1.0))
    """Factor on the loudness of a bat that has accepted a position (paper: alpha)."""
    pulse: float = bounded(0.5, least=0, most=1, tunable=(0.0, 1.0))
    """Pulse rate that a bat approaches: share of rounds in which it does not look around the best (paper: r_0)."""
    quickening: float = bounded(0.9, least=0, tunable=(0.1, 3.0, "log"))
    """Rate at which the pulse rate rises with the rounds (paper: gamma)."""
    stride: float = bounded(0.3, least=0, tunable=(0.05, 1.0, "log"))
    """Largest change of a key in a look around the best position, at a mean loudness of 1."""
    limit: int = bounded(8, least=1, tunable=(2, 30))
    """Rounds without an improvement after which a bat becomes a scout; more than ``rounds`` for Yang's algorithm."""

    @property
    def rules(self) -> BatRules:
        """The parameters for compiled code."""
        return BatRules._make(float(getattr(self, name)) for name in BatRules._fields)

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return BatPilot(briefing, self)


class BatPilot(PsoPilot):
    """Take part in joint plans that bats find."""

    def __init__(self, briefing: Briefing, policy: Bat) -> None:
        super().__init__(briefing, policy)
        self._bats = policy

    def search(self, problem: AssignmentProblem, seeds: list[Assignment], rng: np.random.Generator) -> Plan:
        """Return the best joint plan that the bats find, (N, L)."""
        bats = self._bats
        return echolocated(problem, bats.length, seeds, bats.particles, bats.rounds, bats.rules, rng)


@leaf()
def fly_bat(keys: np.ndarray, speed: np.ndarray, best: np.ndarray, frequency: float, out: np.ndarray) -> None:
    """Change a bat's velocity (D,) towards the ``best`` position by a frequency; write where it flies to ``out``."""
    for i in range(keys.shape[0]):
        speed[i] += (best[i] - keys[i]) * frequency
        out[i] = min(max(keys[i] + speed[i], 0.0), 1.0)


@leaf()
def look_around(best: np.ndarray, chance: np.ndarray, reach: float, out: np.ndarray) -> None:
    """Write to ``out`` (D,) a position at most ``reach`` from the ``best`` in each key; ``chance`` is in [0, 1)."""
    for i in range(best.shape[0]):
        out[i] = min(max(best[i] + reach * (2.0 * chance[i] - 1.0), 0.0), 1.0)


@kernel()
def _echolocate(
    problem: AssignmentProblem, code: Code, keys: np.ndarray, length: int, chances: np.ndarray, rules: BatRules
) -> np.ndarray:
    """Run the bats from (S, D) ``keys`` and return the best plan (N, L); ``chances`` is (T, S, DRAWS + 2 D)."""
    bats, size = keys.shape
    plan, order, times = np.empty((size // length, length), np.int64), np.empty(size, np.int64), np.empty(size)
    speeds, best, found = np.zeros((bats, size)), np.empty(size), np.empty(size)
    values, loud, pulse, idle = np.empty(bats), np.full(bats, rules.loudness), np.zeros(bats), np.zeros(bats, np.int64)
    highest, leader = -np.inf, 0
    for s in range(bats):
        decode(keys[s].reshape(plan.shape), code, plan)
        values[s] = value(problem, plan, order, times)
        if values[s] > highest:
            highest, leader = values[s], s
    best[:] = keys[leader]
    for t in range(chances.shape[0]):
        for s in range(bats):
            chance = chances[t, s]
            is_scout = idle[s] >= rules.limit
            if is_scout:
                found[:] = chance[DRAWS + size :]
                speeds[s], idle[s], loud[s], pulse[s] = 0.0, 0, rules.loudness, 0.0
            else:
                fly_bat(keys[s], speeds[s], best, rules.frequency * chance[0], found)
                if chance[1] > pulse[s]:
                    look_around(best, chance[DRAWS : DRAWS + size], rules.stride * loud.mean(), found)
            decode(found.reshape(plan.shape), code, plan)
            fitness = value(problem, plan, order, times)
            accepts = is_scout or (fitness >= values[s] and chance[2] < loud[s])
            if accepts and fitness > values[s] and not is_scout:
                loud[s] *= rules.quieter
                pulse[s] = rules.pulse * (1.0 - np.exp(-rules.quickening * (t + 1)))
                idle[s] = 0
            else:
                idle[s] += not is_scout
            if accepts:
                values[s] = fitness
                for i in range(size):
                    keys[s, i] = found[i]
            if fitness > highest:
                highest = fitness
                best[:] = found
    decode(best.reshape(plan.shape), code, plan)
    return plan


def echolocated(
    problem: AssignmentProblem,
    length: int,
    seeds: Sequence[Assignment],
    bats: int,
    rounds: int,
    rules: BatRules,
    rng: np.random.Generator,
) -> Plan:
    """Return the best plan of ``length`` goals per UAV that the bats find, (N, L), one from each of the ``seeds``."""
    code = code_of(problem, length)
    keys = initial_keys(code, length, seeds, bats, rng)
    chances = rng.random((rounds, len(keys), DRAWS + 2 * keys.shape[1]))
    return np.asarray(_echolocate(problem, code, keys, length, chances, rules))

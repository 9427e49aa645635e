"""Evaluation during training: greedy episodes with the averaged weights, without the guard."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env.grid.cells import Action
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.learners.dddqn.learning.learner import Learner
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.observation.map_prior import MapPrior
from indoor_explorers.learners.sessions.evaluation import Evaluation, evaluate_world


def evaluate(
    learner: Learner, task: Scenario, prior: MapPrior, episodes: int, first_seed: int, steps: int
) -> Evaluation:
    """Fly ``episodes`` episodes of a task and return their mean results.

    Their seeds begin at ``first_seed``; ``steps`` is the number of training moves so far.
    """
    seeds = iter(range(first_seed, first_seed + episodes))
    flight = VectorFlight(task, learner.config.observation, prior, episodes, lambda: next(seeds))

    def act() -> None:
        flying = np.flatnonzero(~flight.over)
        flight.observe(flying)
        action = np.full(flight.columns, int(Action.STAY))
        action[flying] = learner.greedy(learner.average, flight.scenes[flying], flight.moves[flying], mask=True)
        flight.step(action)

    return evaluate_world(flight.world, act, steps)

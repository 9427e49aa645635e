"""Works out again, where no plug-in was loaded, what counts in the episodes of one."""

from __future__ import annotations

import numpy as np

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import RunError, one_line
from indoor_explorers.env.simulation.spawns import draw_floorplan
from indoor_explorers.evaluation.episodes.metrics import OF_THE_MACHINE
from indoor_explorers.evaluation.episodes.record import FlownEpisode, Outcome, Record
from indoor_explorers.evaluation.episodes.running import RunningEpisode, simulated_record
from indoor_explorers.evaluation.episodes.steps import Steps, step_type
from indoor_explorers.evaluation.episodes.tallies import PREFIX, mean_tallies
from indoor_explorers.evaluation.experiment.experiment import Job

#: Why an episode fails that is another one when it is simulated again.
CHANGED = "coverage does not follow from its actions: the process that flew it was changed"


def verified(record: FlownEpisode, job: Job) -> FlownEpisode:
    """Return an episode of a job with everything that follows from its actions worked out in this process.

    Times of decisions and bytes of messages are those of the flight. Where what the flight recorded does not follow
    from its actions, the episode failed and has no steps.

    Raises:
        RunError: the episode is none of the job.

    """
    if record.task not in job.tasks:
        raise RunError(f"the process of {job.policy.name} sent an episode that it was not asked for")
    flight = RunningEpisode(
        0,
        record.task,
        draw_floorplan(job.scenario, record.task.seed, record.task.map_index),
        job.bounds.get(record.task),
        failure=one_line(record.reason, 1000) if record.outcome is Outcome.FAILED else "",
    )
    again = _simulated(record, flight, job)
    if again is None:
        flight.failure = CHANGED
        nothing = Steps.of(np.zeros(1, step_type(job.scenario.team)))
        again = simulated_record(flight, job.policy.name, job.scenario, nothing)
    return again if isinstance(record, Record) else again.without_map()


def _simulated(record: FlownEpisode, flight: RunningEpisode, job: Job) -> Record | None:
    """Return the episode as its actions make it; None where this is not what was recorded."""
    if not _is_whole(record, job.scenario.team):
        return None
    try:
        told = {name.removeprefix(PREFIX): value for name, value in record.metrics.items() if name.startswith(PREFIX)}
        flight.tallies = mean_tallies([told])
    except InputError as error:
        flight.failure = flight.failure or str(error)
    again = simulated_record(flight, job.policy.name, job.scenario, record)
    again.metrics.update({name: record.metrics.get(name) for name in OF_THE_MACHINE if again.metrics[name] is None})
    same = all(np.array_equal(getattr(again, name), getattr(record, name)) for name in ("actions", "cells", "covered"))
    return again if same and (flight.failure or again.outcome is record.outcome) else None


def _is_whole(record: FlownEpisode, team: int) -> bool:
    """Tell whether the arrays of an episode fit each other and can be simulated."""
    steps, actions = record.steps, record.actions
    spent = all(np.isfinite(each).all() and (np.diff(each) >= 0).all() for each in (record.seconds, record.sent))
    shapes = (actions.shape, record.seconds.shape, record.sent.shape)
    fits = actions.dtype == np.uint8 and bool((actions <= 4).all())
    return fits and spent and shapes == ((steps, team), (steps + 1,), (steps + 1,))

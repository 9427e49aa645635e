"""Episodes are handed out longest first, and the time left is told from what they have cost."""

import heapq
from itertools import cycle
from types import SimpleNamespace

import numpy as np
import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.engines.workload import EPISODE, JOB_EPISODES, Workload
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment

SCENARIOS = tuple(PRESETS[name].for_evaluation() for name in ("thesis-obstacles", "thesis-team-4", "small-offices"))
#: Seconds of an episode; they differ by a factor of 50.
POLICIES = {"random": 0.1, "frontier": 0.3, "dddqn": 0.7, "rrt": 2.0, "reference": 5.0}
SLOWER = {"thesis-obstacles": 1.0, "thesis-team-4": 2.0, "small-offices": 6.0}


def experiment(episodes):
    return Experiment(policies=tuple(POLICIES), scenarios=SCENARIOS, episodes=episodes)


def record(job, task, seconds):
    flown = {"policy": job.policy.name, "task": task, "steps": 0, "team": 1, "bound": 10 + task.seed}
    return SimpleNamespace(**flown, seconds=np.array([0.0, seconds - EPISODE]))


def simulate(episodes, workers, rng, started=0.0):
    """Return the jobs, (K, 2) when each of K jobs ended and how long the rest was said to take, and when all was done.

    Every process that flies a policy first compiles for ``started`` seconds.
    """
    now = [0.0]
    work = Workload(experiment(episodes), set(), workers, clock=lambda: now[0])
    jobs, ends, said, queue, compiled = [], [], [], iter(work), set()

    def begin(worker):
        if (job := next(queue, None)) is None:
            return
        spread = np.exp(rng.normal(0.0, 0.4, len(job.tasks)))
        seconds = POLICIES[job.policy.name] * SLOWER[job.scenario.name] * spread
        late = started * ((worker, job.policy.name) not in compiled)
        compiled.add((worker, job.policy.name))
        jobs.append(job)
        records = [record(job, *pair) for pair in zip(job.tasks, seconds, strict=True)]
        heapq.heappush(ends, (now[0] + late + seconds.sum(), len(jobs), worker, records))

    for worker in range(workers):
        begin(worker)
    while ends:
        now[0], _, worker, records = heapq.heappop(ends)
        work.add(records)
        said.append((now[0], work.seconds_left()))
        begin(worker)
    return jobs, np.array(said), now[0]


@pytest.mark.parametrize(("workers", "episodes"), [(1, 10), (2, 10), (2, 30), (8, 60)])
@pytest.mark.parametrize("started", [0.0, 3.0])
def test_the_time_left_is_never_more_than_twice_off_after_the_first_fifth(workers, episodes, started):
    """As long as the first fifth is longer than the longest episode."""
    for seed in range(5):
        _, said, total = simulate(episodes, workers, np.random.default_rng(seed), started)
        told = said[(said[:, 0] > 0.2 * total) & (said[:, 0] < 0.95 * total)]
        ratios = told[:, 1] / (total - told[:, 0])
        assert len(told) > 10
        assert 0.5 <= ratios.min() <= ratios.max() <= 2.0


def test_every_missing_episode_is_handed_out_once():
    for episodes in (1, 10, 60):
        jobs, _, _ = simulate(episodes, 2, np.random.default_rng(0))
        flown = [(job.policy.name, task) for job in jobs for task in job.tasks]
        assert sorted(flown) == sorted((name, task) for name in POLICIES for task in experiment(episodes).tasks())
        assert max(len(job.tasks) for job in jobs) <= JOB_EPISODES
    finished = set(flown[3:])
    work = Workload(experiment(60), finished, 2)
    assert len(work) == 3
    assert {(job.policy.name, task) for job in work for task in job.tasks} == set(flown[:3])


def test_the_first_job_of_each_pair_is_one_episode_and_then_the_longest_come_first():
    jobs, _, total = simulate(10, 2, np.random.default_rng(1))
    pairs = len(POLICIES) * len(SCENARIOS)
    assert {len(job.tasks) for job in jobs[:pairs]} == {1}
    assert len({(job.policy.name, job.scenario.name) for job in jobs[:pairs]}) == pairs
    costs = [POLICIES[job.policy.name] * SLOWER[job.scenario.name] for job in jobs[pairs:]]
    assert costs[0] == max(costs)
    assert costs[-1] == min(costs)
    work = 10 * sum(POLICIES.values()) * sum(SLOWER.values())
    assert total < 1.25 * work / 2


def test_a_worker_stays_with_the_policy_that_it_has_loaded():
    work, loaded = Workload(experiment(60), set(), 2), {}
    changes, flown = [], set()
    for worker in cycle((0, 1)):
        if (job := work.take([loaded[worker]] if worker in loaded else [])) is None:
            break
        if len(flown) == len(POLICIES) * len(SCENARIOS) and loaded[worker] != job.policy:
            changes.append((worker, job.policy.name))
        flown.add((job.policy.name, job.scenario.name))
        loaded[worker] = job.policy
        work.add([record(job, task, POLICIES[job.policy.name]) for task in job.tasks])
    assert len(work) == 0
    assert len(changes) == len(set(changes))


def test_jobs_tell_what_is_known_of_their_tasks():
    known = {}
    for job in iter(work := Workload(experiment(10), set(), 2)):
        assert job.bounds == {task: known[task] for task in job.tasks if task in known}
        work.add([record(job, task, 1.0) for task in job.tasks])
        known |= {task: 10 + task.seed for task in job.tasks}
    assert len(known) == 10 * len(SCENARIOS)


def test_nothing_is_said_before_anything_is_flown():
    work = Workload(experiment(3), set(), 2)
    assert work.seconds_left() is None


def test_nothing_is_said_of_the_time_left_before_all_pairs_or_a_fifth_of_all_episodes_were_flown():
    work = Workload(experiment(episodes=10), set(), workers=1)
    told = []
    for job in iter(work):
        work.add([record(job, task, 1.0) for task in job.tasks])
        told.append(work.seconds_left() is not None)
    pairs = len(POLICIES) * len(SCENARIOS)
    assert told.index(True) == pairs - 1
    assert all(told[pairs:])

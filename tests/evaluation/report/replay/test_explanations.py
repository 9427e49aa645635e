"""Why UAVs fly, for the page: packed numbers are what pilots explained, and a reason stands for what is missing."""

import base64
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, Candidate, Explanation, make_policy
from indoor_explorers.env.errors import RunError
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.policies.explanation import SILENT
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.episodes.flight import explained_again
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.replay.explanations import (
    LEFT_OUT,
    MOST,
    Explaining,
    number,
    packed_explanations,
)
from indoor_explorers.evaluation.report.replay.selection import replay_data
from tests.evaluation.plugins import Wander
from tests.evaluation.report.replay.test_replay import unfolded, unpacked

SCENARIO = PRESETS["thesis-team-2"].for_evaluation()
POLICIES = ("frontier", "pso", "random", "frontier-nearest")
OUTSIDE = "tests.evaluation.plugins:Wander"


@pytest.fixture(scope="module")
def results():
    """Two episodes of policies that explain, of one that does not, and of one from outside."""
    tasks, uses = [Task(SCENARIO.name, 0, seed) for seed in (3, 4)], (*POLICIES, OUTSIDE)
    made = {use: Wander() if use == OUTSIDE else make_policy(use) for use in uses}
    records = [record for use, policy in made.items() for record in fly(policy, use, SCENARIO, tasks)]
    settings = {SCENARIO.name: {"fingerprint": SCENARIO.fingerprint, **SCENARIO.model_dump(mode="json")}}
    choices = tuple(PolicyChoice(use=use, name=use) for use in uses)
    experiment = Experiment(policies=choices, scenarios=(SCENARIO,), episodes=2, seed=3)
    facts = {use: policy_facts(policy, use) for use, policy in made.items()}
    return Results(facts, settings, [], records, (experiment.to_toml(),))


def record_of(results, policy, seed=3):
    return next(each for each in results.records if (each.policy, each.task.seed) == (policy, seed))


class Reader:
    """Reads the stream of one UAV as the page does; ``entries`` are (step, told), the latter None for nothing."""

    def __init__(self, stream, texts, width):
        self.numbers, self.texts, self.width = unpacked(base64.b64decode(stream)), texts, width
        self.entries, step, now = [], 0, None
        for gap in self.numbers:
            step, changed = step + gap, next(self.numbers)
            if changed == 8:
                now = None
            else:
                now = dict(now or {"among": [], "score": "", "way": []})
                if changed & 1:
                    now |= {"step": step - next(self.numbers), "goal": self.cell(), "note": texts[next(self.numbers)]}
                if changed & 2:
                    now |= self.candidates()
                if changed & 4:
                    now["way"] = self.way()
            self.entries.append((step, now))

    def at(self, step):
        return next((told for when, told in reversed(self.entries) if when <= step), None)

    def cell(self):
        place = next(self.numbers) - 1
        return None if place < 0 else divmod(place, self.width)

    def value(self):
        exponent, mantissa = unfolded(next(self.numbers)), unfolded(next(self.numbers))
        return np.nan if exponent == 127 else float(f"{mantissa}e{exponent}")

    def candidates(self):
        score, names = (self.texts[next(self.numbers)] for _ in range(2))
        count = next(self.numbers)
        among = [(self.cell(), self.value(), {name: self.value() for name in names}) for _ in range(count)]
        return {"score": score, "among": among}

    def way(self):
        runs, first = next(self.numbers), self.cell()
        found = [] if first is None else [first]
        for _ in range(runs):
            length, code = divmod(next(self.numbers), 5)
            for _ in range(length):
                found.append(tuple(np.add(found[-1], MOVES[code]).tolist()))
            if code == 4:
                found.append(self.cell())
        return found


def readers(record, told):
    return [Reader(stream, told["texts"], record.floorplan.shape[1]) for stream in told["uavs"]]


@pytest.mark.parametrize("policy", ["frontier", "pso", "frontier-nearest"])
def test_what_is_unpacked_is_what_the_pilots_explained(results, policy):
    record = record_of(results, policy)
    told = list(explained_again(record, SCENARIO, make_policy(policy)))
    assert len(told) == record.steps
    read = readers(record, packed_explanations(record, iter(told)))
    compared = 0
    for step, each in enumerate(told, 1):
        for uav, true in enumerate(each):
            found = read[uav].at(step)
            assert (found["step"], found["goal"], found["note"]) == (true.step, true.goal, true.note)
            assert found["score"] == true.score
            assert len(found["among"]) == min(len(true.candidates), MOST)
            for (cell, score, parts), other in zip(found["among"], true.candidates, strict=False):
                assert cell == other.cell
                assert score == pytest.approx(other.score, rel=0.005)
                assert parts == pytest.approx(dict(other.parts), rel=0.005)
                compared += 1
            here = tuple(record.cells[step - 1, uav].tolist())
            rest = found["way"][found["way"].index(here) :] if here in found["way"] else found["way"]
            assert tuple(rest) == true.path
    assert compared > 100


def test_changes_alone_are_packed_and_what_is_told_may_cease(results):
    record = record_of(results, "frontier")
    among = tuple(Candidate(cell=(1, k), score=0.5 - k, parts={"gain": np.inf, "odd": 12345.0}) for k in range(9))
    first = Explanation(step=0, goal=(1, 3), candidates=among, score="gain", path=((1, 1), (1, 2), (1, 3)))
    jump = replace(first, path=((1, 1), (2, 2)), note="jumps")
    steps = [[first, None], [replace(first, path=first.path[1:]), None], [jump, first], [None, first], [None, first]]
    one, other = readers(record, packed_explanations(record, iter(steps)))
    assert [step for step, _ in one.entries] == [1, 3, 4]
    assert [step for step, _ in other.entries] == [3]
    assert one.at(2)["way"] == [(1, 1), (1, 2), (1, 3)]
    assert (one.at(3)["way"], one.at(3)["note"]) == ([(1, 1), (2, 2)], "jumps")
    assert one.at(5) is None
    cell, score, parts = one.at(1)["among"][1]
    assert (cell, score, parts["odd"]) == ((1, 1), -0.5, 12300.0)
    assert np.isnan(parts["gain"])
    assert len(one.at(1)["among"]) == MOST


@pytest.mark.parametrize("value", [0.0, 7.0, -999.0, 1000.0, 0.0123456, -3.14159e-9, 6.02e23, 9.999])
def test_numbers_keep_three_digits(value):
    exponent, mantissa = map(unfolded, number(value))
    assert float(f"{mantissa}e{exponent}") == pytest.approx(value, rel=0.005)
    assert abs(mantissa) <= 1000


def test_a_reason_stands_for_an_explanation_that_cannot_be_given(results):
    asked = Explaining(results, 60.0)
    assert "uavs" in asked.told(record_of(results, "frontier"))
    assert asked.told(record_of(results, "random")) == {"none": SILENT}
    assert "imported only if you name it" in asked.told(record_of(results, OUTSIDE))["none"]
    assert asked.told(replace(record_of(results, "pso"), policy="gone"))["none"] == "no run tells how it was made"
    failed = replace(record_of(results, "pso"), outcome=Outcome.FAILED)
    assert "failed in this episode" in asked.told(failed)["none"]


def test_a_named_policy_from_outside_is_flown_again(results):
    named = replace(results, plugins=frozenset([OUTSIDE]))
    assert Explaining(named, 60.0).told(record_of(results, OUTSIDE)) == {"none": SILENT}


def test_another_policy_or_another_flight_is_not_taken_for_the_one_recorded(results):
    facts = results.policies | {"frontier": results.policies["frontier"] | {"parameters": {"length": "7"}}}
    other = Explaining(replace(results, policies=facts), 60.0).told(record_of(results, "frontier"))
    assert "not the one stored" in other["none"]
    record = record_of(results, "frontier")
    actions = record.actions.copy()
    actions[5, 0] = 4
    for changed, why in (
        ({"actions": actions}, "took another action at step 6"),
        ({"actions": actions[:4]}, "took another action at step 5"),
        ({"actions": np.concatenate((record.actions, record.actions[-1:]))}, f"ended at step {record.steps}"),
    ):
        assert why in Explaining(results, 60.0).told(replace(record, **changed))["none"]


def test_a_policy_that_raises_leaves_a_reason(results, monkeypatch):
    monkeypatch.setattr(type(make_policy("frontier")), "pilot", lambda *_: 1 / 0)
    assert (
        "policy failed at step 0: ZeroDivisionError"
        in Explaining(results, 60.0).told(record_of(results, "frontier"))["none"]
    )
    with pytest.raises(RunError, match="ZeroDivisionError"):
        next(explained_again(record_of(results, "frontier"), SCENARIO, make_policy("frontier")))


def test_time_is_kept_to_and_by_default_the_first_task_alone_is_explained(results):
    first, second = (record_of(results, "frontier", seed) for seed in (3, 4))
    asked = Explaining(results)
    assert "uavs" in asked.told(first)
    assert asked.told(second) == {"none": LEFT_OUT}
    slow = replace(second, seconds=second.seconds + 61.0)
    asked = Explaining(results, 60.0)
    assert asked.told(slow) == {"none": LEFT_OUT}
    assert "uavs" in asked.told(first)
    assert "uavs" in asked.told(second)
    assert Explaining(results, 0.0).told(first) == {"none": LEFT_OUT}


def test_the_replay_has_the_explanations_of_each_flight(results):
    comparison = Comparison(results, SCENARIO.name)
    data = replay_data(comparison, policy_styles(results.policies), 1_000_000, None, Explaining(results, 60.0))
    told = {
        data["policies"][flight["policy"]]["name"]: "uavs" in flight["why"]
        for episode in data["episodes"]
        for flight in episode["flights"]
    }
    assert told == dict.fromkeys(POLICIES, True) | {"random": False, OUTSIDE: False}

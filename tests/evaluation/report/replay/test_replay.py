"""What the page's replays are made from: the page's own merging, repeated here, gives the recorded flight."""

import base64
from dataclasses import replace

import numpy as np
import pytest

from indoor_explorers.env import PRESETS
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.evaluation.analysis.comparison import Comparison
from indoor_explorers.evaluation.drawing.palette import policy_styles
from indoor_explorers.evaluation.harness.episodes.record import Outcome
from indoor_explorers.evaluation.harness.episodes.resimulate import resimulate
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report.packing import bits, folded, packed, runs, text
from indoor_explorers.evaluation.report.replay.packed_episode import (
    first_of_group,
    frame_steps,
    pack_episode,
    resimulated,
)
from indoor_explorers.evaluation.report.replay.selection import chosen, notable_tasks, replay_data
from tests.evaluation.plugins import Raises, Wander

TEAM = PRESETS["thesis-team-4"].for_evaluation()
LOSSY = TEAM.with_settings({"radio.model": "disc", "radio.range": 5.0, "radio.loss": 0.4, "budget": 60})
SHORT = {"radio.model": "disc", "radio.range": 3.0, "budget": 60}
BASE = SHORT | {"name": "base", "base.at": "start"}
FAILURES = SHORT | {"name": "failures", "failures.hazard": 0.02, "failures.radio_hazard": 0.05}
ERRORS = {"noise.misses": 0.1, "noise.false_returns": 0.02, "drift.rate": 0.05, "on_collision": "block"}
UNCERTAIN = TEAM.with_settings(BASE | FAILURES | ERRORS | {"name": "errors"})
HARDER = (
    TEAM.with_settings(FAILURES),
    TEAM.with_settings(FAILURES | {"name": "last word", "failures.last_word": True, "failures.hazard": 0.05}),
    TEAM.with_settings(BASE),
    TEAM.with_settings(BASE | FAILURES | {"name": "failures and base", "base.must_return": True}),
    TEAM.with_settings(SHORT | {"name": "prior", "prior.kind": "outdated"}),
)


def results_of(scenario, maps=1, seeds=4):
    tasks = [Task(scenario.name, index, seed) for index in range(maps) for seed in range(seeds)]
    policies = {"wander": Wander(), "raises": Raises()}
    records = [record for name, policy in policies.items() for record in fly(policy, name, scenario, tasks)]
    settings = {scenario.name: {"fingerprint": scenario.fingerprint, **scenario.model_dump(mode="json")}}
    return Results({name: {} for name in policies}, settings, [], records)


@pytest.fixture(scope="module")
def results():
    return results_of(LOSSY)


@pytest.fixture(scope="module")
def comparison(results):
    return Comparison(results, LOSSY.name)


def unpacked(data):
    """Yield the numbers that the page reads from packed bytes."""
    number = shift = 0
    for byte in data:
        number |= (byte & 0x7F) << shift
        shift += 7
        if not byte & 0x80:
            yield number
            number = shift = 0


def unfolded(number):
    return -(number + 1) // 2 if number % 2 else number // 2


class Reader:
    """Unpacks a replay's flight as the page does; after each frame, ``maps`` holds what is known by name."""

    def __init__(self, episode, flight):
        self.episode, self.flight = episode, flight
        self.numbers = unpacked(base64.b64decode(flight["stream"]))
        self.team, self.own, size = flight["team"], episode["own"], episode["height"] * episode["width"]
        count = self.team + (episode["base"] is not None)
        self.steps = frame_steps(flight["steps"], episode["stride"])
        self.stops = {uav: next(k for k, now in enumerate(self.steps) if now >= step) for uav, step in flight["stops"]}
        self.cells, self.spent = np.zeros(2 * self.team, int), np.zeros(2, int)
        self.pairs = list(zip(*np.triu_indices(count, 1), strict=True))
        self.linked = np.eye(count, dtype=bool)
        self.known = np.zeros((count if self.own else 1 + count - self.team, size), bool)
        self.wrong = np.zeros(size, bool)

    def places(self):
        place, found = 0, []
        for _ in range(next(self.numbers)):
            place += next(self.numbers)
            length = next(self.numbers) + 1
            found += range(place, place + length)
            place += length
        return found

    def frames(self):
        """Yield each shown step, with the state after it."""
        for frame, step in enumerate(self.steps):
            self.read(frame)
            yield step
        assert next(self.numbers, None) is None

    def read(self, frame):
        self.cells += [unfolded(next(self.numbers)) for _ in self.cells]
        self.spent += [next(self.numbers) for _ in self.spent]
        for pair in self.places():
            row, column = self.pairs[pair]
            self.linked[row, column] = self.linked[column, row] = not self.linked[row, column]
        if self.episode["revised"]:
            for mask in (self.known[0], self.wrong, self.known[-1])[: 1 + len(self.known)]:
                mask[self.places()] ^= True
            self.maps = {"team": self.known[0], "base": self.known[-1]}
            return
        if not self.own and frame in self.stops.values():
            self.known[0, self.places()] = False
        groups = first_of_group(self.linked[None])[0] if self.own else np.arange(len(self.known))
        for first in np.unique(groups):
            members = groups == first
            self.known[members] = self.known[members].any(axis=0)
            for place in self.places():
                self.known[members, place] = True
        going = [place for place in range(len(self.known)) if self.stops.get(place, frame + 1) > frame or not self.own]
        self.maps = {"team": self.known[going].any(axis=0), "base": self.known[-1]}

    def covered(self, name):
        counted = np.unpackbits(np.frombuffer(base64.b64decode(self.episode["counted"]), np.uint8)).astype(bool)
        return int((self.maps[name] & counted[: self.known.shape[1]]).sum())


def replayed(results):
    """Replay every episode of a scenario; yield the record, the scenario's data and a reader of the flight."""
    (name,) = results.scenarios
    data = replay_data(Comparison(results, name), policy_styles(results.policies), 0, 99)
    for episode in data["episodes"]:
        for flight in episode["flights"]:
            policy, task = data["policies"][flight["policy"]]["name"], Task(name, *episode["task"])
            record = next(r for r in results.groups[name, policy] if r.task == task)
            yield record, data, Reader(episode, flight)


def reader_of(flight, stride=1, own=True):
    """Return a reader of one packed flight."""
    record, (height, width) = flight.record, flight.record.floorplan.shape
    stops = [(uav, step) for uav, step in enumerate(flight.stopped.tolist()) if step <= record.steps]
    counted = bits(flight.counted)
    episode = {"own": own, "base": flight.base, "stride": stride, "counted": counted, "height": height, "width": width}
    episode["revised"] = flight.revisions is not None
    stream = text(pack_episode(flight, stride, own=own))
    return Reader(episode, {"stream": stream, "team": record.team, "steps": record.steps, "stops": stops})


@pytest.mark.parametrize("stride", [1, 7])
def test_a_replay_is_the_recorded_flight_with_what_each_uav_knew(results, stride):
    for record in results.records:
        reader = reader_of(resimulated(record, LOSSY), stride)
        worlds = enumerate(resimulate(record, LOSSY))
        for step in reader.frames():
            world = next(world for now, world in worlds if now == step)
            assert (reader.cells.reshape(-1, 2) == record.cells[step]).all()
            assert reader.spent.tolist() == [record.distance[step], record.sent[step]]
            assert (reader.linked == world.state.linked[0] | np.eye(4, dtype=bool)).all()
            assert (reader.known == (world.state.belief[0] > 0).reshape(4, -1)).all()


def test_without_own_maps_the_team_knows_what_it_knew(results):
    record = results.records[0]
    reader = reader_of(resimulated(record, LOSSY), 3, own=False)
    for step in reader.frames():
        assert reader.covered("team") == record.covered[step, 0]


@pytest.mark.parametrize("scenario", HARDER, ids=lambda scenario: scenario.name)
def test_coverage_is_that_of_the_record_at_every_step(scenario):
    results = results_of(scenario, seeds=3)
    stops = []
    for record, data, reader in replayed(results):
        stops += reader.stops
        for step, world in zip(reader.frames(), resimulate(record, scenario), strict=True):
            assert reader.covered(data["counts"]) == record.covered[step, 0]
            assert reader.covered("team") == record.seen[step]
            assert (reader.known[:4] == (world.state.belief[0] > 0).reshape(4, -1)).all()
            if scenario.base.exists:
                assert reader.covered("base") == record.covered[step, 5]
                leads, contact = reader.linked[4, :4], world.state.base_contact[0]
                assert not (leads & ~contact).any()
                assert leads.any() == contact.any()
    assert bool(stops) == scenario.failures.any
    assert any((np.diff(record.seen) < 0).any() for record in results.records) == scenario.failures.any


@pytest.mark.parametrize("scenario", HARDER, ids=lambda scenario: scenario.name)
def test_so_it_is_where_steps_and_own_maps_are_left_out(scenario):
    for record in results_of(scenario, seeds=2).records:
        for own in (True, False):
            reader = reader_of(resimulated(record, scenario), 5, own=own)
            for step in reader.frames():
                assert reader.covered("base" if scenario.base.must_return else "team") == record.covered[step, 0]
                assert reader.covered("team") == record.seen[step]


@pytest.mark.parametrize("stride", [1, 5])
def test_maps_that_can_be_wrong_are_shown_as_they_were(stride):
    results, wrong = results_of(UNCERTAIN, seeds=2), 0
    for record in results.records:
        reader = reader_of(resimulated(record, UNCERTAIN), stride, own=False)
        worlds = enumerate(resimulate(record, UNCERTAIN))
        for step in reader.frames():
            state = next(world for now, world in worlds if now == step).state
            assert reader.covered("team") == record.seen[step]
            assert reader.covered("base") == record.covered[step, 5]
            shown, truth = state.union[0].ravel(), state.truth[0].ravel()
            assert (reader.maps["team"] == (shown == truth)).all()
            assert (reader.wrong == ((shown != truth) & (shown > 0))).all()
            wrong += reader.wrong.sum()
    assert wrong
    data = replay_data(Comparison(results, UNCERTAIN.name), policy_styles(results.policies), 1_000_000)
    assert all(episode["revised"] and not episode["own"] for episode in data["episodes"])


def test_each_task_has_its_prior_map(results):
    scenario = HARDER[-1]
    for record, _, reader in replayed(results_of(scenario)):
        walls = np.unpackbits(np.frombuffer(base64.b64decode(reader.episode["prior"]), np.uint8))[:256]
        world = next(resimulate(record, scenario))
        assert (walls == (world.prior(0) == OCCUPIED).ravel()).all()
        assert (walls != (record.floorplan.truth == OCCUPIED).ravel()).any()
    assert all(reader.episode["prior"] is None for *_, reader in replayed(results))


def test_data_name_the_episodes_and_their_maps(results, comparison):
    data = replay_data(comparison, policy_styles(results.policies), 1_000_000)
    assert data["range"] == 3.0
    assert data["tasks"] == 4
    for episode in data["episodes"]:
        index, seed = episode["task"]
        record = next(r for r in results.records if r.task == Task(LOSSY.name, index, seed))
        for name, cells in (
            ("walls", record.floorplan.truth == OCCUPIED),
            ("counted", resimulated(record, LOSSY).counted),
        ):
            found = np.unpackbits(np.frombuffer(base64.b64decode(episode[name]), np.uint8))[:256]
            assert (found == cells.ravel()).all()
        assert episode["own"]
        assert episode["total"] == record.reachable
        assert {flight["policy"] for flight in episode["flights"]} == {0, 1}
    assert [policy["name"] for policy in data["policies"]] == ["wander", "raises"]
    assert data["episodes"][0]["label"] == "median"
    assert any("policy failed" in flight["end"] for episode in data["episodes"] for flight in episode["flights"])


def test_the_most_telling_episodes_come_first(results):
    records = [
        replace(
            record,
            task=Task("s", record.task.seed // 2, record.task.seed),
            metrics={"t99": [9.0, 40.0, 5.0, 50.0, 30.0, 31.0, 8.0, 20.0][record.task.seed], "auc": 0.5},
            outcome=Outcome.BUDGET,
        )
        for record in results_of(LOSSY, seeds=8).records
    ]
    found = Results(results.policies, {"s": {}}, [], records)
    comparison = Comparison(found, "s")
    assert [(pick.label, pick.task.seed) for pick in notable_tasks(comparison)] == [
        ("median", 7), ("fastest", 2), ("slowest", 3),
    ]  # fmt: skip
    assert [(pick.label, pick.task.seed) for pick in chosen(comparison)][3:] == [
        ("median of its map", 0), ("median of its map", 4),
    ]  # fmt: skip
    assert len(chosen(comparison, everything=True)) == 8


def test_fewer_bytes_give_less_detail_then_fewer_policies_then_nothing(results, comparison):
    styles = policy_styles(results.policies)
    found = [replay_data(comparison, styles, limit) for limit in range(0, 15_000, 250)]
    for limit, data in zip(range(0, 15_000, 250), found, strict=True):
        flights = [flight for episode in data["episodes"] for flight in episode["flights"]] if data else []
        assert sum(len(flight["stream"]) for flight in flights) <= limit
    first = [
        (len(data["episodes"][0]["flights"]), data["episodes"][0]["own"]) if data else (0, False) for data in found
    ]
    assert first == sorted(first)
    assert set(first) == {(0, False), (1, False), (2, False), (2, True)}


def test_as_many_as_asked_for_are_replayed_whatever_their_size(results, comparison):
    assert replay_data(comparison, policy_styles(results.policies), 10, count=0) is None
    every = replay_data(comparison, policy_styles(results.policies), 10, count=4)
    assert sorted(tuple(episode["task"]) for episode in every["episodes"]) == [(0, seed) for seed in range(4)]


def test_a_flight_of_another_world_is_not_shown(results, comparison):
    record = results.records[0]
    moved = replace(record, cells=record.cells + np.int16(1))
    assert resimulated(record, LOSSY).faithful
    assert not resimulated(moved, LOSSY).faithful
    others = [r if r is not record else moved for r in results.records]
    data = replay_data(
        Comparison(Results(results.policies, results.scenarios, [], others), LOSSY.name),
        policy_styles(results.policies),
        0,
        4,
    )
    shown = {tuple(e["task"]): [flight["policy"] for flight in e["flights"]] for e in data["episodes"]}
    assert shown.pop((0, record.task.seed)) == [1]
    assert all(sorted(policies) == [0, 1] for policies in shown.values())


def test_groups_are_chains_of_contacts():
    linked = np.zeros((2, 4, 4), bool)
    linked[1, [0, 2, 2, 3], [2, 0, 3, 2]] = True
    assert first_of_group(linked).tolist() == [[0, 1, 2, 3], [0, 1, 0, 0]]


def test_packing():
    numbers = [0, 1, 127, 128, 300, 2**31, 2**60]
    assert list(unpacked(packed(numbers))) == numbers
    assert packed([]) == b""
    signed = np.array([0, -1, 1, -2, 2, -300])
    assert [unfolded(number) for number in folded(signed).tolist()] == signed.tolist()


def test_runs_are_listed_by_key():
    keys, places = np.array([2, 0, 0, 0, 0, 0, 0]), np.array([4, 7, 20, 0, 1, 5, 6])
    found = runs(keys, places, np.arange(3))
    assert found.keys.tolist() == [0] * 7 + [1] + [2] * 3
    assert found.numbers.tolist() == [3, 0, 1, 3, 2, 12, 0, 0, 1, 4, 0]
    nothing = np.array([], np.int64)
    assert runs(nothing, nothing, np.arange(2)).numbers.tolist() == [0, 0]

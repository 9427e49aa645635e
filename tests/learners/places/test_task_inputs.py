"""What a network of places sees of harder tasks, against cells and views counted one by one."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.grid.cells import FREE, MOVES, UNKNOWN
from indoor_explorers.env.policies.registry import with_parameters
from indoor_explorers.env.sensing.lidar import lidar_model, new_scan, visible_cells
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.learners.places.flights import fly
from indoor_explorers.learners.places.model import AdvantageNet, weights_of
from indoor_explorers.learners.places.network import Loaded, load_weights, values, without_network, write_weights
from indoor_explorers.learners.places.policy import SHIPPED, DddqnPlaces
from indoor_explorers.learners.places.scene import COMMON, PLACE, Observer, Scene
from indoor_explorers.learners.places.task_inputs import TASK_COMMON, TASK_PLACE, _ends_of_paths
from indoor_explorers.learners.places.train import PlacesTraining, TrainingConfig
from indoor_explorers.learners.pockets.maps import TrainingMaps
from indoor_explorers.learners.pockets.tasks import HARDER, HARDER_ALONE, LARGEST, harder_settings
from indoor_explorers.planners.toolbox.navigation.paths import Paths
from indoor_explorers.planners.toolbox.networks.tensors import read_tensors
from tests.learners.places.small import world_on_a_floor
from tests.learners.places.test_scene import pilot_of


def observed(world: World, agent: int = 0) -> Scene:
    scene = Observer(pilot_of(world, agent), task=True).observe(world.view(0, agent))
    assert scene is not None
    return scene


def columns(scene: Scene) -> np.ndarray:
    assert scene.places.shape[1] == PLACE + TASK_PLACE
    return scene.places[:, PLACE:].astype(np.float64)


def common(scene: Scene) -> np.ndarray:
    assert len(scene.common) == COMMON + TASK_COMMON
    return scene.common[COMMON:].astype(np.float64)


def test_what_was_seen_before_stays_the_same() -> None:
    world = world_on_a_floor()
    plain, scene = Observer(pilot_of(world)).observe(world.view(0, 0)), observed(world)
    assert plain is not None
    np.testing.assert_array_equal(scene.places[:, :PLACE], plain.places)
    np.testing.assert_array_equal(scene.common[:COMMON], plain.common)
    np.testing.assert_array_equal(columns(scene), [[2.0, v, 0.0, 0.0, 1.0] for v in columns(scene)[:, 1]])
    np.testing.assert_array_equal(common(scene), [1.0, *np.zeros(TASK_COMMON - 1)])


def test_goals_of_teammates_are_seen() -> None:
    world = world_on_a_floor(settings={"team": 3, "radio.model": "unlimited"}, flown_by="frontier")
    view, scene = world.view(0, 0), observed(world)
    goals = [(int(mate.message[0]), int(mate.message[1])) for mate in view.mates if mate.message]
    assert len(goals) == 2
    fields = [Paths(view.belief.shape).field(view.belief, goal).ravel()[scene.cells] for goal in goals]
    theirs = np.minimum(np.array(fields) / world.scenario.lidar.range, 10.0) / 5.0
    own = np.minimum(scene.steps, 10.0) / 5.0
    np.testing.assert_allclose(columns(scene)[:, 0], theirs.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(columns(scene)[:, 1], theirs.min(axis=0) - own, atol=1e-6)
    np.testing.assert_allclose(columns(scene)[:, 2], (theirs < own).sum(axis=0) / 4.0)
    assert len(set(columns(scene)[:, 2])) > 1


@pytest.mark.parametrize("degrees", [90.0, 180.0])
def test_the_heading_and_the_view_on_arrival_are_seen(degrees: float) -> None:
    """A place is ahead, aside or behind; on arrival a sensor sees the unknown cells within half its angle."""
    world = world_on_a_floor(settings={"lidar.field_of_view": degrees}, flown_by="frontier")
    view, scene = world.view(0, 0), observed(world)
    ahead, shares = columns(scene)[:, 3:].T
    assert ahead.min() < 0.0 < ahead.max()
    field = Paths(view.belief.shape).field(view.belief, view.cell)
    reach = world.scenario.lidar.range
    ends = _ends_of_paths(field, scene.cells, int(reach / 2))
    assert view.heading is not None
    for k, (leaving, arriving) in enumerate(ends.tolist()):
        assert ahead[k] == pytest.approx(MOVES[view.heading] @ leaving / np.hypot(*leaving), abs=1e-6)
        facing = max(range(4), key=lambda move: int(MOVES[move] @ arriving))
        assert shares[k] == pytest.approx(
            share_in_view(view.belief, int(scene.cells[k]), facing, degrees, reach), abs=1e-6
        )
    assert shares.min() < 1.0


def share_in_view(belief: np.ndarray, cell: int, facing: int, degrees: float, reach: float) -> float:
    """The share of unknown cells in view, by angles."""
    lidar, (row, col), width = lidar_model(reach), divmod(cell, belief.shape[1]), belief.shape[1]
    scan = new_scan(lidar)
    count = visible_cells(belief, row, col, lidar, scan)
    seen = [divmod(int(each), width) for each in scan.cells[:count] if belief.ravel()[each] == UNKNOWN]
    away = [(row - cell // width, col - cell % width) for row, col in seen]
    angles = [
        abs((np.degrees(np.arctan2(col, row) - np.arctan2(*MOVES[facing][::-1])) + 180.0) % 360.0 - 180.0)
        for row, col in away
    ]
    near = [max(abs(row), abs(col)) <= 1 for row, col in away]
    inside = [angle <= degrees / 2 + 1e-6 or close for angle, close in zip(angles, near, strict=True)]
    return sum(inside) / len(inside) if inside else 1.0


def test_ends_of_paths_lie_on_shortest_paths() -> None:
    rng = np.random.default_rng(5)
    for _ in range(10):
        belief = np.where(rng.random((20, 24)) < 0.75, FREE, UNKNOWN).astype(np.uint8)
        belief[7, 9] = FREE
        field = Paths(belief.shape).field(belief, (7, 9))
        cells = np.flatnonzero((field.ravel() > 0) & (field.ravel() < 1000)).astype(np.int32)
        for cell, (leaving, arriving) in zip(cells, _ends_of_paths(field, cells, 4), strict=True):
            row, col = divmod(int(cell), 24)
            length = int(field[row, col])
            assert field[7 + leaving[0], 9 + leaving[1]] == min(4, length)
            assert field[row - arriving[0], col - arriving[1]] == length - min(4, length)


def test_the_task_is_seen() -> None:
    settings = {"drift.rate": 0.001, "noise.misses": 0.1, "noise.range_std": 0.2, "lidar.field_of_view": 120.0}
    world = world_on_a_floor(settings=settings)
    expected = [1 / 3, world.view(0, 0).pose_std, 0.5, 0.5, 0.2, 0.0, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(common(observed(world)), expected, rtol=1e-6)
    failing = {"team": 3, "radio.model": "none", "failures.hazard": 0.001, "failures.radio_hazard": 0.01}
    np.testing.assert_allclose(
        common(observed(world_on_a_floor(settings=failing))), [1, 0, 0, 0, 0, 0.5, 0.5, 1, 0], rtol=1e-6
    )


def test_teammates_that_seem_to_have_stopped_are_counted() -> None:
    """A teammate that is silent though the radio reaches everywhere has stopped."""
    world = world_on_a_floor(settings={"team": 3, "radio.model": "unlimited", "failures.stops": ((2, 30),)})
    np.testing.assert_allclose(common(observed(world))[-2:], [0.5, 0.25])


def test_harder_tasks_are_of_every_kind() -> None:
    rng = np.random.default_rng(0)
    for team, (kinds, _) in ((1, HARDER_ALONE), (4, HARDER)):
        drawn = [harder_settings(team, rng) for _ in range(100)]
        assert len({tuple(each) for each in drawn}) == len(kinds)
        for each in drawn:
            scenario("small-floors").with_settings({"team": team, **each})
            for limits in LARGEST.values():
                assert all(0.0 <= each.get(name, 0.0) <= most for name, most in limits.items())


def test_flights_in_harder_tasks_are_recorded(tmp_path: Path) -> None:
    """Networks with and without the task's inputs fly the same first choices, as they begin as the planner."""
    both = []
    for task in (False, True):
        loaded = Loaded(weights_of(AdvantageNet(task=task)), 0.45, guess=True, others=True, task=task)
        loaded = loaded._replace(weights=without_network(loaded).weights)
        write_weights(tmp_path / f"{task}.safetensors", loaded)
        assert load_weights(tmp_path / f"{task}.safetensors")[1:] == loaded[1:]
        both.append(fly(TrainingMaps(), 9, loaded, harder=1.0))
    plain, seen = both
    assert seen.choices[0]["places"].shape[2] == PLACE + TASK_PLACE
    assert (seen.choices[0]["common"][:, COMMON] < 1.0).all(), "expected a narrow view in the flight of this seed"
    for without, among in zip(plain.choices, seen.choices, strict=True):
        np.testing.assert_array_equal(without["places"], among["places"][..., :PLACE])
        np.testing.assert_array_equal(without["rewards"], among["rewards"])
    about = [read_tensors(tmp_path / f"{task}.safetensors")[1]["about"] for task in (False, True)]
    assert ["task" in json.loads(each) for each in about] == [False, True]


def test_what_is_missing_when_all_have_stopped_costs_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A flight whose only UAV stops early must not look short."""
    stops = {"failures.stops": ((0, 60),)}
    monkeypatch.setattr("indoor_explorers.learners.places.flights.harder_settings", lambda *_: stops)
    loaded = Loaded(weights_of(AdvantageNet()), 0.45, guess=True, others=True)
    arrays = fly(TrainingMaps(), 9, loaded, harder=1.0).choices[0]
    assert -10.0 * float(arrays["rewards"].sum()) > 2 * 60 * 1.5


def test_a_network_that_sees_the_task_flies(tmp_path: Path) -> None:
    loaded = Loaded(weights_of(AdvantageNet(task=True)), 0.45, guess=True, others=True, task=True)
    write_weights(tmp_path / "places.safetensors", loaded)
    policy = DddqnPlaces(weights=str(tmp_path))
    world = World(scenario("small-floors").with_settings({"team": 2, "lidar.field_of_view": 90.0}))
    world.reset([1])
    pilots = make_pilots(policy, world)
    for _ in rollout(world, ask_pilots(policy, pilots, world)):
        pass
    assert world.team_coverage[0] >= 0.99


def test_a_training_begins_with_the_weights_of_another(tmp_path: Path) -> None:
    """With inputs that they did not have it begins with the same values."""
    config = TrainingConfig(initial_weights="shipped", task_inputs=True)
    shipped, begun = load_weights(SHIPPED), PlacesTraining(config, 1, tmp_path).mean()
    scene = observed(world_on_a_floor(settings={"lidar.field_of_view": 90.0}))
    plain = scene._replace(places=scene.places[:, :PLACE].copy(), common=scene.common[:COMMON].copy())
    assert begun.task > shipped.task
    assert config.seen_maps() == ("floors/train", "dungeons/train")
    assert TrainingConfig(task_inputs=True).seen_maps() == ()
    np.testing.assert_allclose(values(scene, begun), values(plain, shipped), rtol=1e-5, atol=1e-6)
    same = TrainingConfig(initial_weights="shipped").initial
    assert same is not None
    assert all(np.array_equal(a, b) for a, b in zip(same.weights, shipped.weights, strict=True))
    write_weights(tmp_path / "places.safetensors", begun)
    assert TrainingConfig(initial_weights=str(tmp_path), task_inputs=True).initial is not None
    for other in ({}, {"task_inputs": True, "width": 32}, {"task_inputs": True, "prior": 0.0}):
        with pytest.raises(ValueError, match="expected weights of a network with"):
            TrainingConfig(initial_weights=str(tmp_path), **other)
    with pytest.raises(ValueError, match="expected a safetensors file, found none"):
        TrainingConfig(initial_weights=str(tmp_path / "none"))


def test_a_flight_with_errors_ends_when_all_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a UAV sees again because its map is wrong is no choice to learn from."""
    monkeypatch.setattr("indoor_explorers.learners.places.flights.harder_settings", lambda *_: {"drift.rate": 0.002})
    flight = fly(TrainingMaps(), 9, Loaded(weights_of(AdvantageNet()), 0.45, guess=True, others=True), harder=1.0)
    known = flight.choices[0]["common"][:, 0].astype(np.float64)
    assert flight.times[1] < 6.0, "expected it to end long before the budget"
    assert known[-1] > known[0]


@pytest.mark.parametrize("settings", [{"lidar.field_of_view": 90.0}, {"team": 3, "failures.hazard": 0.005}])
def test_policies_that_are_not_needed_leave_the_flight_as_it_is(settings: dict[str, Any]) -> None:
    """Where no pose drifts and no base waits, the learner for all harder tasks flies as the network of places alone."""
    paths = []
    for name in ("dddqn-places", "loop-closing(explorer='dddqn-reports(explorer=\"dddqn-places\")')"):
        world = World(scenario("small-floors").with_settings({"team": 2, "budget": 80, **settings}))
        world.reset([5])
        called, parameters = with_parameters(name)
        policy = make_policy(called, **parameters)
        flown = rollout(world, ask_pilots(policy, make_pilots(policy, world), world))
        paths.append([world.state.cell[0].tolist() for _ in flown])
    assert len(paths[0]) > 40
    assert paths[0] == paths[1]

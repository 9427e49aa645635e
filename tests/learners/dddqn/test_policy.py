"""The policy: deterministic, picklable, and with clear errors."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from indoor_explorers.env import PRESETS, Briefing, InputError, Policy, World, check_policy, make_policy
from indoor_explorers.env.scenarios.seed_sets import use_of
from indoor_explorers.learners.dddqn.learning.vector_flight import VectorFlight
from indoor_explorers.learners.dddqn.observation.config import LAYERS, ObservationConfig
from indoor_explorers.learners.dddqn.observation.layout import BLOCKED_AT, PROSPECT, TOURS
from indoor_explorers.learners.dddqn.pilot import DddqnPilot
from indoor_explorers.learners.dddqn.policy import Dddqn
from indoor_explorers.learners.dddqn.weights import load_weights, shipped
from indoor_explorers.learners.places.policy import DddqnPlaces
from tests.learners.dddqn.rooms import cells_flown, fly, small_room, some_prior, write_network


def flown(policy: Policy, preset: str = "thesis-team-2") -> NDArray[np.int64]:
    world = World(PRESETS[preset].for_evaluation().with_settings({"budget": 60}))
    world.reset([1])
    return cells_flown(policy, world)


def briefed(name: str, **settings: object) -> Briefing:
    world = World(PRESETS[name].with_settings(settings))
    world.reset([1])
    return world.briefing(0, 0)


@pytest.mark.slow  # with shipped weights it is checked among all policies
def test_the_policy_passes_the_conformance_suite(untrained: str) -> None:
    check_policy(Dddqn(weights=untrained))


def test_the_guarded_share_is_tallied(untrained: str) -> None:
    world = World(small_room())
    world.reset([1])
    for guard in (True, False):
        pilot = Dddqn(weights=untrained, guard=guard).pilot(world.briefing(0, 0))
        pilot.act(world.view(0, 0))
        assert pilot.tally() == ({"guarded_share": 0.0} if guard else {})


def test_it_never_flies_into_a_wall(untrained: str) -> None:
    scenario = PRESETS["thesis-obstacles"].for_evaluation().with_settings({"budget": 20_000})
    world = fly(Dddqn(weights=untrained), scenario, 3)
    assert world.state.collisions.sum() == 0
    assert world.team_coverage[0] == 1.0


def test_weights_that_cannot_be_read_are_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "bad.safetensors").write_bytes(b"\x80\x04pickled")
    for weights, match in (
        (str(tmp_path / "none.safetensors"), r"none\.safetensors: expected a safetensors file, found none"),
        (str(tmp_path / "bad.safetensors"), "expected a safetensors file, got something else"),
        ("thesis-opne", r"unknown weights 'thesis-opne' \(expected a name or a path\); did you mean 'thesis-open'"),
    ):
        with pytest.raises(InputError, match=match) as error:
            Dddqn(weights=weights)
        assert "\n" not in str(error.value)


def test_weights_written_anew_are_read_anew(tmp_path: Path) -> None:
    path = tmp_path / "weights.safetensors"
    policy = Dddqn(weights=write_network(path, 1))
    first = flown(policy)
    write_network(path, 2)
    assert not np.array_equal(first, flown(policy))


def test_the_shipped_weights_explore_unseen_rooms_well() -> None:
    scenario = PRESETS["thesis-obstacles"].for_evaluation().with_settings({"goal": 0.99})
    worlds = [fly(Dddqn(), scenario, seed) for seed in range(12)]
    assert all(world.team_coverage[0] >= 0.99 for world in worlds)
    assert np.mean([world.state.step[0] for world in worlds]) < 85


def test_results_can_tell_which_weights_were_flown(untrained: str) -> None:
    own, all_of_them = Dddqn(weights=untrained).provenance(), Dddqn().provenance()
    assert len(own["weights_sha256"]) == 64
    names = ("thesis-open", "thesis-obstacles", "places")
    assert all_of_them.keys() == {*(f"weights_{name}_sha256" for name in names), "pocket_weights", "weights_for"}
    for name in names[:2]:
        assert Dddqn(weights=name).provenance()["weights_sha256"] == all_of_them[f"weights_{name}_sha256"]
    assert DddqnPlaces().provenance()["weights_sha256"] == all_of_them["weights_places_sha256"]
    assert Dddqn().seen_maps() == DddqnPlaces().seen_maps()
    assert Dddqn(map_alone=True).seen_maps() == {}


def test_without_a_network_the_shortest_tour_is_followed() -> None:
    world = World(PRESETS["thesis-obstacles"].for_evaluation())
    world.reset([1])
    policy = Dddqn(network=False, guard=False)
    pilot = policy.pilot(world.briefing(0, 0))
    assert isinstance(pilot, DddqnPilot)
    beyond = load_weights(shipped()["thesis-obstacles"]).layout.tours_at + TOURS.index("its steps beyond the shortest")
    for _ in range(30):
        action = pilot.act(world.view(0, 0))
        assert action < 4
        legal_A = pilot.moves[0, :, BLOCKED_AT] == 0.0
        assert pilot.moves[0, action, beyond] == pilot.moves[0, legal_A, beyond].min()
        world.step(np.array([[action]]))
    assert policy.provenance() == Dddqn().provenance()


def test_without_a_network_the_best_candidate_is_followed_on_large_maps(tmp_path: Path) -> None:
    world = World(PRESETS["small-cave"].for_evaluation())
    world.reset([1])
    weights = write_network(tmp_path / "weights.safetensors", 1, ObservationConfig(tours=False, prospects=True))
    pilot = Dddqn(weights=weights, network=False, guard=False).pilot(world.briefing(0, 0))
    assert isinstance(pilot, DddqnPilot)
    behind = load_weights(Path(weights)).layout.prospects_at + PROSPECT.index("steps behind the best")
    action = pilot.act(world.view(0, 0))
    legal_A = pilot.moves[0, :, BLOCKED_AT] == 0.0
    assert pilot.moves[0, action, behind] == pilot.moves[0, legal_A, behind].min()


def test_large_maps_are_flown_from_place_to_place() -> None:
    alone, whole = (flown(Dddqn(network=network), "small-cave") for network in (False, True))
    assert np.array_equal(whole, flown(DddqnPlaces(), "small-cave"))
    assert np.array_equal(alone, flown(DddqnPlaces(network=False), "small-cave"))
    assert not np.array_equal(alone, whole)


def test_a_network_cannot_be_left_out_where_there_are_no_planner_features() -> None:
    with pytest.raises(InputError, match="expected map_alone with a network"):
        Dddqn(map_alone=True, network=False)
    with pytest.raises(InputError, match="expected weights with planner features"):
        Dddqn(weights="thesis-obstacles-map", network=False).pilot(briefed("thesis-obstacles"))


@pytest.mark.parametrize(("reach", "told"), [(3, {}), (4, {"other_range": 1.0})])
def test_results_tell_that_weights_fly_a_lidar_range_they_were_not_trained_with(
    reach: int, told: dict[str, float]
) -> None:
    briefing = briefed("thesis-open", **{"lidar.range": reach})
    assert Dddqn(guard=False).pilot(briefing).tally() == told
    assert Dddqn(guard=False, weights="thesis-open").pilot(briefing).tally() == {}


def test_the_weights_suit_the_scenario() -> None:
    def suited(name: str, **settings: object) -> str:
        return Dddqn().suited(briefed(name, **settings))

    assert suited("office") == "places"
    for name in ("thesis-open", "thesis-obstacles", "thesis-team-2-radio-unlimited"):
        assert suited(name, **{"lidar.range": 4}) == "thesis-obstacles"
    alone = {name: suited(name) for name in ("thesis-open", "thesis-obstacles")}
    assert alone == {name: name for name in alone}
    teams = [suited(f"thesis-team-{team}-radio-{radio}") for team in (2, 4) for radio in (0, 3, "unlimited")]
    assert teams == 6 * ["thesis-obstacles"]
    assert {*alone, *teams} <= shipped().keys()


def test_weights_that_see_the_map_alone_are_for_small_rooms() -> None:
    def suited(name: str, **settings: object) -> str:
        return Dddqn(map_alone=True).suited(briefed(name, **settings))

    names = {name: suited(name) for name in ("thesis-open", "thesis-obstacles", "thesis-team-2")}
    assert list(names.values()) == ["thesis-open-map", "thesis-obstacles-map", "thesis-obstacles-map"]
    assert {*names.values()} <= shipped().keys()
    for name in names.values():
        seen = load_weights(shipped()[name]).observation
        assert (seen.gains, seen.tours, seen.prospects) == (False, False, False)
    for settings in ({"lidar.range": 9}, {"map.width": 17}):
        with pytest.raises(InputError, match=r"expected a map of up to 16x16 cells and a lidar range of 3 for we"):
            suited("thesis-obstacles", **settings)
    with pytest.raises(
        InputError, match=r"expected weights or map_alone, got both: 'thesis-open'; leave one of them out"
    ):
        Dddqn(weights="thesis-open", map_alone=True)


def test_tours_are_searched_as_wide_as_asked(tmp_path: Path) -> None:
    """The same width, asked of the policy or written in the weights, is the same flight; another is another."""
    room = small_room().with_settings({"map.height": 12, "map.width": 12})

    def seen(policy: Dddqn) -> list[bytes]:
        world = World(room)
        world.reset([3])
        pilot = policy.pilot(world.briefing(0, 0))
        assert isinstance(pilot, DddqnPilot)
        looks = []
        for _ in range(8):
            world.step(np.array([[pilot.act(world.view(0, 0))]]))
            looks.append(pilot.moves.tobytes())
        return looks

    plain, wide = (
        write_network(tmp_path / f"{width}.safetensors", 1, ObservationConfig(tour_width=width)) for width in (1, 64)
    )
    assert seen(Dddqn(weights=plain, tour_width=64)) == seen(Dddqn(weights=wide)) != seen(Dddqn(weights=plain))
    for wrong in (0, -3, 2000, 2.5, "wide"):
        with pytest.raises(InputError, match=r"expected tour_width from 1 to 1024, got"):
            Dddqn(weights=plain, tour_width=wrong)  # type: ignore[arg-type]


def test_division_is_off_with_shipped_weights_and_replaces_what_is_stored(tmp_path):
    room = PRESETS["thesis-team-2-radio-unlimited"]
    world = World(room)
    world.reset([3])
    stored = write_network(tmp_path / "stored.safetensors", 1, ObservationConfig(division=True))
    for policy, parts in (
        (Dddqn(), 0),
        (Dddqn(division=True), 2),
        (Dddqn(weights=stored), 2),
        (Dddqn(weights=stored, division=False), 0),
    ):
        pilot = policy.pilot(world.briefing(0, 0))
        assert isinstance(pilot, DddqnPilot)
        assert pilot._memory.theirs.shape == (1, parts, 4)


def test_a_trainings_folder_is_opened(tmp_path: Path) -> None:
    write_network(tmp_path / "weights.safetensors", 1)
    policy = make_policy(f"dddqn:{tmp_path}", guard=False)
    assert policy == Dddqn(weights=str(tmp_path), guard=False)
    assert len(policy.provenance()["weights_sha256"]) == 64
    assert make_policy("dddqn:thesis-open") == Dddqn(weights="thesis-open")
    with pytest.raises(InputError, match=r"weights\.safetensors: expected a safetensors file, found none"):
        make_policy(f"dddqn:{tmp_path.parent}")


@pytest.mark.parametrize("frames", [1, 3])
def test_a_pilot_sees_what_the_training_saw(tmp_path: Path, frames: int) -> None:
    sight = ObservationConfig(layers=LAYERS, identity=True, progress=True, frames=frames)
    policy = Dddqn(weights=write_network(tmp_path / "weights.safetensors", 1, sight), guard=False)
    scenario = small_room().with_settings({"team": 3, "radio.model": "square", "radio.range": 3})
    flight = VectorFlight(scenario, sight, some_prior(1), 1, lambda: 7)
    pilots = [policy.pilot(flight.world.briefing(0, n)) for n in range(3)]
    actions = np.zeros(3, np.int64)
    for _ in range(25):
        flight.observe(np.arange(3))
        for n, pilot in enumerate(pilots):
            assert isinstance(pilot, DddqnPilot)
            actions[n] = pilot.act(flight.world.view(0, n))
            assert np.array_equal(pilot.scenes, flight.scenes[n : n + 1])
            assert np.array_equal(pilot.moves, flight.moves[n : n + 1])
        flight.step(actions)


def test_shipped_weights_tell_the_rooms_that_former_ones_were_compared_on() -> None:
    seen = make_policy("dddqn").seen_seeds()
    assert range(1_000_000, 1_000_500) in seen["tuning"]
    assert [use_of(seeds) for seeds in (seen["training"][0], seen["validation"][0])] == ["training", "validation"]
    assert "tuning" not in {use for use, ranges in make_policy("dddqn:thesis-open-map").seen_seeds().items() if ranges}

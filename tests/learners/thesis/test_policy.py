"""The policy: its contract, its observation the training's, its errors in one line."""

import pickle

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from indoor_explorers.env import PRESETS, InputError, World, check_policy, make_policy
from indoor_explorers.learners.thesis.policy import DddqnThesis
from indoor_explorers.learners.thesis.vector_flight import ImageFlight

from .rooms import CENTRED, MENDED_FORMAT, THESIS, write_network


@pytest.fixture(params=[THESIS, MENDED_FORMAT, CENTRED], ids=["thesis", "mended", "centred"])
def untrained(request, tmp_path):
    """The path of the weights of an untrained network."""
    return write_network(tmp_path / "untrained.safetensors", 3, request.param)


@pytest.mark.slow  # with shipped weights it is checked among all policies
def test_the_policy_passes_the_conformance_suite(untrained):
    check_policy(DddqnThesis(weights=untrained))


def test_the_shipped_weights_are_the_thesiss_network():
    policy = make_policy("dddqn-thesis")
    assert policy == DddqnThesis()
    assert policy.image_format[:2] == (16, 16)
    assert len(policy.provenance()["weights_sha256"]) == 64


def test_a_pilot_sees_what_its_training_saw(untrained):
    policy = DddqnThesis(weights=untrained)
    scenario = PRESETS["thesis-team-4-radio-3"].with_settings({"on_collision": "block"})
    image_format, seeds = policy.image_format, iter([5, 6])
    looks = {"frames": image_format.frames, "identity": image_format.identity, "centred": image_format.centred}
    flight = ImageFlight(scenario, 2, lambda: next(seeds), pilots=range(4), **looks)
    world = World(scenario, 2)
    world.reset([5, 6])
    keys = [(b, n) for b in range(2) for n in range(4)]
    pilots = [policy.pilot(world.briefing(*key)) for key in keys]
    rng, seen = np.random.default_rng(1), np.empty((image_format.frames, *image_format[:2]), np.uint8)
    for _ in range(20):
        for column, (pilot, key) in enumerate(zip(pilots, keys, strict=True)):
            pilot.perceive(world.view(*key), seen)
            assert np.array_equal(seen, flight.images[column])
        actions = rng.integers(0, 4, 8)
        flight.step(actions, np.arange(8))
        world.step(actions.reshape(2, 4))


def test_acting_together_equals_acting_alone(untrained):
    policy = DddqnThesis(weights=untrained)
    world = World(PRESETS["thesis-team-2"].with_settings({"on_collision": "block"}), 3)
    world.reset([1, 2, 3])
    keys = [(b, n) for b in range(3) for n in range(2)]
    crews = [[policy.pilot(world.briefing(*key)) for key in keys] for _ in range(2)]
    for _ in range(15):
        views = [world.view(*key) for key in keys]
        together = policy.act(crews[0], views)
        assert together == [pilot.act(view) for pilot, view in zip(crews[1], views, strict=True)]
        world.step(np.array(together).reshape(3, 2))


def test_with_the_mask_no_wall_is_hit(untrained):
    for mask in (True, False):
        world = World(PRESETS["thesis-obstacles"].with_settings({"on_collision": "block"}))
        world.reset([4])
        policy = DddqnThesis(weights=untrained, mask=mask)
        pilot = policy.pilot(world.briefing(0, 0))
        for _ in range(30):
            world.step(np.array([[pilot.act(world.view(0, 0))]]))
        assert bool(world.state.collisions.sum() == 0) is mask


def test_a_copy_is_small_and_equal(untrained):
    policy = DddqnThesis(weights=untrained)
    assert pickle.loads(pickle.dumps(policy)) == policy
    assert len(pickle.dumps(policy)) < 1000


def test_files_that_are_no_such_weights_are_refused_in_one_line(tmp_path):
    good = write_network(tmp_path / "good.safetensors", 1)
    arrays = load_file(good)
    with pytest.raises(InputError, match=r"none\.safetensors: expected a safetensors file, found none"):
        DddqnThesis(weights=str(tmp_path / "none.safetensors"))
    save_file(arrays, tmp_path / "bare.safetensors")
    with pytest.raises(InputError, match="expected weights of the thesis's network, got others") as error:
        DddqnThesis(weights=str(tmp_path / "bare.safetensors"))
    assert "\n" not in str(error.value)
    metadata = {"eye": '{"height": 16, "width": 16, "frames": 2, "identity": false}'}
    save_file(arrays, tmp_path / "other.safetensors", metadata)
    with pytest.raises(InputError, match="expected the arrays of the thesis's network, got others"):
        DddqnThesis(weights=str(tmp_path / "other.safetensors"))
    with (tmp_path / "large.safetensors").open("wb") as file:
        file.truncate(70_000_000)
    with pytest.raises(InputError, match="expected weights of at most 64 MB, got 70 MB"):
        DddqnThesis(weights=str(tmp_path / "large.safetensors"))

"""The policy: it observes as its training did, and its errors are one line."""

import json
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from indoor_explorers.env import PRESETS, InputError, World, check_policy, make_policy
from indoor_explorers.learners.thesis.inference import trained
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


def test_with_the_mask_no_wall_is_hit(untrained):
    for mask in (True, False):
        world = World(PRESETS["thesis-obstacles"].with_settings({"on_collision": "block"}))
        world.reset([4])
        policy = DddqnThesis(weights=untrained, mask=mask)
        pilot = policy.pilot(world.briefing(0, 0))
        for _ in range(30):
            world.step(np.array([[pilot.act(world.view(0, 0))]]))
        assert bool(world.state.collisions.sum() == 0) is mask


def test_files_that_are_no_such_weights_are_refused_in_one_line(tmp_path):
    good = write_network(tmp_path / "good.safetensors", 1)
    arrays = load_file(good)
    with pytest.raises(InputError, match=r"none\.safetensors: expected a safetensors file, found none"):
        DddqnThesis(weights=str(tmp_path / "none.safetensors"))
    save_file(arrays, tmp_path / "bare.safetensors")
    with pytest.raises(InputError, match="expected weights of dddqn-thesis with its description") as error:
        DddqnThesis(weights=str(tmp_path / "bare.safetensors"))
    assert "\n" not in str(error.value)
    for name, changed, match in (
        ("other", {"frames": 2}, r"with 'convolutions.0.weight' of shape \(32, 2, 8, 8\), got"),
        ("small", {"height": 14}, "expected a map of at least 15 x 15 cells"),
    ):
        image_format = {"height": 16, "width": 16, "frames": 1, "identity": False} | changed
        save_file(arrays, tmp_path / f"{name}.safetensors", {"eye": json.dumps(image_format)})
        with pytest.raises(InputError, match=match) as error:
            DddqnThesis(weights=str(tmp_path / f"{name}.safetensors"))
        assert f"{name}.safetensors: expected" in str(error.value)


def test_weights_of_version_0_2_0_are_read(tmp_path):
    good = write_network(tmp_path / "good.safetensors", 1)
    about = {"height": 16, "width": 16, "frames": 1, "identity": False}  # as in the file that ships
    save_file(load_file(good), tmp_path / "former.safetensors", {"eye": json.dumps(about)})
    found, former = trained(Path(good)), trained(tmp_path / "former.safetensors")
    assert former.image_format == found.image_format
    assert all(np.array_equal(a, b) for a, b in zip(former.weights, found.weights, strict=True))

"""One request behind the command line, the experiment file and the function."""

import inspect

import numpy as np
import pytest

from indoor_explorers.env import PRESETS, InputError, make_policy
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.readers.ros import parse_ros
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.cli.commands.compare import CompareOptions
from indoor_explorers.evaluation.cli.commands.maps import MapsOptions
from indoor_explorers.evaluation.cli.parser import build_parser
from indoor_explorers.evaluation.harness.experiment.planning import plan, read_experiment
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest


def test_the_function_and_the_command_take_every_field():
    parameters = inspect.signature(compare).parameters
    assert list(parameters) == ["out", *ComparisonRequest.model_fields, "watcher", "command"]
    assert {part.kind for name, part in parameters.items() if name != "out"} == {inspect.Parameter.KEYWORD_ONLY}
    (commands,) = [action.choices for action in build_parser()._actions if action.dest == "command"]
    given = {action.dest for action in commands["compare"]._actions}
    assert given == {*ComparisonRequest.model_fields, "out", "help"}


def test_the_three_ways_ask_for_the_same_experiment(tmp_path):
    file = tmp_path / "plan.toml"
    file.write_text('policies = ["random"]\nscenarios = ["thesis-open"]\nepisodes = 3\nseed = 4\n[set]\ngoal = 0.5\n')
    words = [*("--policies", "random", "--scenario", "thesis-open", "--episodes", "3"), "--seed", "4"]
    given = vars(build_parser().parse_args(["compare", *words, "--set", "goal=0.5", "--out", "x"]))
    typed = ComparisonRequest(**{key: value for key, value in given.items() if key in ComparisonRequest.model_fields})
    asked = ComparisonRequest.of(
        policies=["random"], scenario=PRESETS["thesis-open"], episodes=3, seed=4, settings={"goal": 0.5}
    )
    assert plan(typed) == plan(asked) == plan(ComparisonRequest(experiment=file))
    assert read_experiment(file) == typed


def test_one_name_is_a_list_of_one():
    assert ComparisonRequest.of(policies="random", scenario="thesis-open", maps="floor.png") == ComparisonRequest(
        policies=["random"], scenario=["thesis-open"], maps=["floor.png"]
    )


def test_a_request_cannot_be_changed_and_refuses_what_it_does_not_know(tmp_path):
    with pytest.raises(ValueError, match="frozen"):
        ComparisonRequest().team = 3
    with pytest.raises(InputError, match="comparison: unknown key 'polices'; did you mean 'policies'"):
        compare(tmp_path, polices=["random"])
    with pytest.raises(InputError, match=r"comparison: team: Input should be a valid integer.*got 'many'"):
        compare(tmp_path, team="many")
    with pytest.raises(InputError, match="experiment: episodes: Input should be greater than or equal to 1, got 0"):
        compare(tmp_path, episodes=0)


def test_a_tilde_is_the_home_folder_everywhere(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    np.save(tmp_path / "m.npy", np.zeros((5, 5), np.uint8))
    (tmp_path / "own.toml").write_text('[map]\nsource = "files"\npaths = ["~/m.npy"]\n')
    (tmp_path / "plan.toml").write_text('policies = ["random"]\nscenarios = ["~/own.toml"]\n')
    options = CompareOptions(experiment="~/plan.toml", out="~/out")
    assert options.out == tmp_path / "out"
    assert ComparisonRequest(data="~/clones").data == (tmp_path / "clones",)
    own = [str(tmp_path / "m.npy")]
    settings = {"map.source": "files", "map.paths": ["~/m.npy"]}
    for request in (
        options,
        ComparisonRequest(scenario="~/own.toml"),
        ComparisonRequest(maps="~/m.npy"),
        ComparisonRequest(scenario="thesis-open", settings=settings),
    ):
        assert [*plan(request).scenarios[0].map.paths] == own
    assert MapsOptions(paths=("~/m.npy", "~nobody-of-that-name/x")).paths[0] == tmp_path / "m.npy"
    assert read_map("~/m.npy").shape == (5, 5)
    keys = "resolution: 1\nnegate: 0\noccupied_thresh: .65\nfree_thresh: .2"
    (tmp_path / "m.yaml").write_text(f"image: ~/a/m.pgm\n{keys}\n")
    assert parse_ros(tmp_path / "m.yaml").image == tmp_path / "a" / "m.pgm"
    for name in ("dddqn", "dddqn-places", "dddqn-thesis"):
        with pytest.raises(InputError, match=str(tmp_path)):
            make_policy(name, weights="~/none.safetensors")

"""From a request to an experiment: what of a file is flown."""

from pathlib import Path

import pytest

from indoor_explorers.env import PRESETS, InputError, Scenario
from indoor_explorers.env.scenarios.parts import Radio
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, declared_margin
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest, read_setting
from indoor_explorers.evaluation.harness.experiment.selection import DEFAULT_POLICIES

EXPERIMENTS = Path(__file__).parents[4] / "evaluation" / "experiments"
FILE = """
policies = [
    "random", {use = "pso", name = "dddqn, no guard", parameters = {candidates = 8}}, {use = "pso", name = "pso "},
]
episodes = 4
seed = 9
scenarios = [
    "thesis-open", "far.toml", {preset = "office", name = "office, far", lidar.range = 20.0, goal = 0.95},
    {name = "pso", team = 3, spawn = [[0, 0], [0, 1], [0, 2]]},
]
"""


@pytest.fixture
def file(tmp_path):
    (tmp_path / "far.toml").write_text('preset = "thesis-open"\nname = "a far one"\nlidar.range = 5.0\n')
    (tmp_path / "plan.toml").write_text(FILE)
    return tmp_path / "plan.toml"


def test_everything_that_the_file_lists_is_flown(file):
    planned = plan(ComparisonRequest(experiment=file))
    assert [choice.name for choice in planned.policies] == ["random", "dddqn, no guard", "pso "]
    assert [task.name for task in planned.scenarios] == ["thesis-open", "a far one", "office, far", "pso"]


def test_names_of_entries_are_those_entries(file):
    names = ["dddqn, no guard", "frontier-nearest", "pso"]
    planned = plan(ComparisonRequest(experiment=file, policies=names, scenario=["office, far"]))
    assert [(choice.use, choice.name) for choice in planned.policies] == [
        *[("pso", "dddqn, no guard"), ("frontier-nearest", "frontier-nearest"), ("pso", "pso ")]
    ]
    assert planned.policies[0].parameters == {"candidates": 8}
    assert planned.scenarios[0].lidar.range == 20.0
    assert (planned.episodes, planned.seed) == (4, 9)


def test_the_margin_is_that_of_the_request_or_the_file_and_is_stored(file):
    assert plan(ComparisonRequest(experiment=file)).margin == 0.05
    file.write_text("margin = 0.1\n" + FILE)
    planned = plan(ComparisonRequest(experiment=file))
    assert (planned.margin, declared_margin(planned.to_toml())) == (0.1, 0.1)
    assert plan(ComparisonRequest(experiment=file, margin=0)).margin == 0.0
    assert (declared_margin(""), declared_margin('margin = "wide"'), declared_margin("margin = 7")) == (0.05,) * 3
    with pytest.raises(InputError, match="margin"):
        plan(ComparisonRequest(experiment=file, margin=1.5))


def test_other_names_are_presets_files_and_policies(file, monkeypatch):
    assert plan(ComparisonRequest(experiment=file, scenario="maze")).scenarios[0] == PRESETS["maze"].for_evaluation()
    monkeypatch.chdir(file.parent)
    assert plan(ComparisonRequest(experiment=file, scenario=["far.toml"])).scenarios[0].name == "a far one"
    with pytest.raises(InputError, match=r"unknown scenario 'offic' \(expected a preset or a .toml file\)"):
        plan(ComparisonRequest(experiment=file, scenario=["offic"]))
    assert tuple(choice.use for choice in plan(ComparisonRequest()).policies) == DEFAULT_POLICIES


def test_a_table_is_flown_as_it_says_and_else_as_comparisons_are(file):
    told, untold = plan(ComparisonRequest(experiment=file, scenario=["office, far", "pso"])).scenarios
    assert (told.goal, told.goal_of, told.denominator, told.budget) == (0.95, "team", "reachable", 1500)
    assert (untold.goal, untold.goal_of, untold.stuck.rule, untold.budget) == (1.0, "team", "off", None)
    assert untold.spawn == ((0, 0), (0, 1), (0, 2))
    (far,) = plan(ComparisonRequest(experiment=file, scenario="a far one", settings={"goal": 0.5})).scenarios
    assert far.goal == 0.5


def test_an_experiment_printed_is_the_same_experiment(file, tmp_path):
    for settings in ({}, {"goal": 0.9, "goal_of": "agent", "denominator": "map", "stuck.rule": "oscillation"}):
        planned = plan(ComparisonRequest(experiment=file, settings=settings))
        (tmp_path / "again.toml").write_text(planned.to_toml())
        again = plan(ComparisonRequest(experiment=tmp_path / "again.toml"))
        assert isinstance(again, Experiment)
        assert again == planned
        assert [task.fingerprint for task in again.scenarios] == [task.fingerprint for task in planned.scenarios]


def test_map_files_stay_where_they_are(tmp_path, monkeypatch):
    (tmp_path / "floor.png").write_bytes(b"")
    monkeypatch.chdir(tmp_path)
    planned = plan(ComparisonRequest(maps=["floor.png"], policies=["random"]))
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "plan.toml").write_text(planned.to_toml())
    again = plan(ComparisonRequest(experiment=tmp_path / "other" / "plan.toml"))
    assert again.scenarios[0].map.paths == (str(tmp_path / "floor.png"),)
    assert again.scenarios[0].name == planned.scenarios[0].name == "floor"


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("3", "expected scenarios to list presets, .toml files or tables of settings, got 3"),
        ('{name = "x", lidra.range = 3}', "scenario 'x' of the experiment: unknown key 'lidra'; did you mean 'lidar'"),
        ('{preset = "ofice"}', "unknown scenario 'ofice'; did you mean 'office'"),
        ("{preset = 3}", "expected preset to be the name of a scenario, got 3"),
    ],
)
def test_entries_that_are_no_scenario_are_refused(entry, message, tmp_path):
    (tmp_path / "plan.toml").write_text(f"scenarios = [{entry}]\n")
    with pytest.raises(InputError) as caught:
        plan(ComparisonRequest(experiment=tmp_path / "plan.toml"))
    assert message in str(caught.value)


def test_a_scenario_of_ones_own_is_flown_as_comparisons_are():
    own = Scenario(name="own", team=2)
    assert plan(ComparisonRequest(scenario=own)).scenarios == (own.for_evaluation(),)


@pytest.mark.parametrize("path", sorted(EXPERIMENTS.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_experiments_can_be_planned(path):
    experiment = plan(ComparisonRequest(experiment=path))
    assert len(experiment.policies) >= 3
    assert all(scenario.goal_of == "team" for scenario in experiment.scenarios)
    told = 0.9 if path.stem.endswith("-90") else 1.0
    assert {scenario.goal for scenario in experiment.scenarios} == {told}


def test_experiments_that_ship_have_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    named, filed = (plan(ComparisonRequest(experiment=each)) for each in ("teams", EXPERIMENTS / "teams.toml"))
    assert named == filed
    with pytest.raises(InputError, match=r"unknown experiment 'temas' \(expected a file or .* did you mean 'teams'"):
        plan(ComparisonRequest(experiment="temas"))
    (tmp_path / "teams").write_text('scenarios = ["maze"]')
    assert [scenario.name for scenario in plan(ComparisonRequest(experiment="teams")).scenarios] == ["maze"]


def test_the_buildings_differ_in_team_and_radio_alone():
    experiment = plan(ComparisonRequest(experiment=EXPERIMENTS / "planners-buildings.toml"))
    assert len(experiment.scenarios) == 20
    assert len({scenario.fingerprint for scenario in experiment.scenarios}) == 20
    for kind in ("rooms", "offices", "cave", "maze"):
        mine = [scenario for scenario in experiment.scenarios if scenario.name.startswith(kind)]
        alike = [scenario.model_copy(update={"name": "", "team": 1, "radio": Radio()}) for scenario in mine]
        assert all(each == alike[0] for each in alike)
        assert [(each.team, each.radio.model) for each in mine] == [
            *((1, "unlimited"), (2, "unlimited"), (2, "disc"), (4, "unlimited"), (4, "disc"))
        ]


def test_parameters_stand_in_parentheses():
    asked = ["pso", "pso(length=1)", "dddqn( map_alone = true, guard = false )", "dddqn-places:a/b(network=false)"]
    plain, short, alone, folder = plan(ComparisonRequest(policies=asked, scenario="thesis-open")).policies
    assert (plain.name, plain.parameters) == ("pso", {})
    assert (short.name, short.use, short.parameters) == ("pso(length=1)", "pso", {"length": 1})
    assert (alone.use, alone.parameters) == ("dddqn", {"map_alone": True, "guard": False})
    assert (folder.use, folder.parameters) == ("dddqn-places:a/b", {"network": False})
    assert short.make().length == 1


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("pso(length)", r"policy 'pso\(length\)': expected parameters as in pso\(length=1\) .*, got 'length'"),
        ("pso(length=one)", "with values as in TOML, got 'length=one'"),
        ("pso(lenght=1)", "unknown parameter 'lenght'; did you mean 'length'"),
        ("psso(length=1)", "unknown policy 'psso'; did you mean 'pso'"),
    ],
)
def test_other_parentheses_are_refused_in_one_line(name, told):
    with pytest.raises(InputError, match=told) as error:
        plan(ComparisonRequest(policies=[name], scenario="thesis-open")).policies[0].make()
    assert "\n" not in str(error.value)


def test_several_values_of_a_setting_make_a_scenario_each():
    settings = dict(map(read_setting, ("radio.range=1,3", "radio.model=disc,square", "goal=0.9")))
    planned = plan(ComparisonRequest(scenario="thesis-team-2", settings=settings)).scenarios
    assert [(each.radio.range, each.radio.model, each.goal) for each in planned] == [
        *((1.0, "disc", 0.9), (1.0, "square", 0.9), (3.0, "disc", 0.9), (3.0, "square", 0.9))
    ]
    assert planned[0].name == "thesis-team-2 radio.range=1 radio.model=disc"


def test_an_experiment_file_sweeps_as_the_command_line_does(tmp_path):
    (tmp_path / "flat.toml").write_text('scenarios = ["thesis-open"]\n[set]\n"lidar.range" = [2, 4]\n')
    planned = plan(ComparisonRequest(experiment=tmp_path / "flat.toml")).scenarios
    assert [(each.name, each.lidar.range) for each in planned] == [
        *(("thesis-open lidar.range=2", 2.0), ("thesis-open lidar.range=4", 4.0))
    ]


def test_a_setting_that_takes_a_list_is_not_swept():
    settings = dict(map(read_setting, ("team=2", "spawn=[[0,0],[0,1]]")))
    (planned,) = plan(ComparisonRequest(settings=settings)).scenarios
    assert planned.spawn == ((0, 0), (0, 1))


@pytest.mark.parametrize(
    ("setting", "message"),
    [("radio.rang=1,3", "did you mean 'radio.range'"), ("radio.range=1,far", "radio.range: .* got 'far'")],
)
def test_values_of_a_sweep_that_do_not_fit_are_named(setting, message):
    with pytest.raises(InputError, match=message):
        plan(ComparisonRequest(settings=dict([read_setting(setting)])))

"""Scenarios: validation, settings, TOML, fingerprints."""

import pytest

from indoor_explorers.env import PRESETS, InputError, load_scenario, scenario
from indoor_explorers.env.maps.sources import RoomsMaps


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_prints_itself_and_is_read_back(name, tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(PRESETS[name].to_toml())
    again = load_scenario(path)
    assert again == PRESETS[name]
    assert again.fingerprint == PRESETS[name].fingerprint


def test_a_file_may_start_from_a_preset(tmp_path):
    path = tmp_path / "far.toml"
    path.write_text(
        'preset = "thesis-team-2"\nteam = 3\n[radio]\nrange = 6.0\n[map]\nsource = "thesis"\nobstacles = 9\n'
    )
    task = load_scenario(path)
    assert (task.name, task.team, task.radio.range, task.radio.model) == ("far", 3, 6.0, "square")
    assert task.map.obstacles == 9
    assert task.stuck == PRESETS["thesis-team-2"].stuck


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("taem = 2", "unknown key 'taem'; did you mean 'team'"),
        ("[lidar]\nrnage = 2", "unknown key 'lidar.rnage'; did you mean 'range'"),
        ('[map]\nsource = "thesis"\nobstacels = 2', "did you mean 'obstacles'"),
        ("team = 0", "team: .*greater than or equal to 1.*got 0"),
        ("goal = nan", "goal"),
        ("team = 2\nspawn = [[0, 0]]", "spawn lists 1 cells for a team of 2"),
        ('preset = "thesis-opne"', "unknown scenario 'thesis-opne'; did you mean 'thesis-open'"),
        ("team = ", "expected TOML"),
        pytest.param(f"team = {'9' * 5000}", "expected TOML, got Exceeds the limit", id="many digits"),
        pytest.param(f"team = 0x{'f' * 5000}", "team: .*, got a number of thousands of digits", id="in hexadecimal"),
        ("preset = 3", "expected preset to be the name"),
        ("lidar = 3", "lidar: expected a table of settings, got 3"),
        ("map = 3", "map: expected a table of settings, got 3"),
        ('[map]\nsource = "romos"', "map.source: expected a kind of map, got 'romos'; did you mean 'rooms'"),
        ("[map]\nheight = 3", "map.source: expected a kind of map, got 'none'; known: cave, files"),
        ('[map]\nsource = "rooms"\nheight = 3', "map.height: .*greater than or equal to 5"),
        (
            'spawn = "here"',
            "spawn: expected random, clustered, or a list of .*, got 'here'",
        ),
        ("spawn = [[1.5, 2]]", "spawn: expected random, clustered, or a list"),
        ('preset = "rooms"\ngoal.a = 3', "no setting 'goal.a', since 'goal' is a single one; set that"),
    ],
)
def test_bad_files_give_one_clear_line(toml, message, tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(toml)
    with pytest.raises(InputError, match=message) as caught:
        load_scenario(path)
    assert "\n" not in str(caught.value)
    assert "bad.toml" in str(caught.value)


def test_settings_are_dotted_and_checked():
    changed = scenario("thesis-open").with_settings({"lidar.range": 5, "goal": 0.5})
    assert (changed.lidar.range, changed.goal) == (5.0, 0.5)
    with pytest.raises(InputError, match=r"no setting 'lidar\.rang'; did you mean 'lidar\.range'"):
        scenario("thesis-open").with_settings({"lidar.rang": 5})
    with pytest.raises(InputError, match=r"no setting 'radoi'; did you mean 'radio'"):
        scenario("thesis-open").with_settings({"radoi.range": 5})
    with pytest.raises(InputError, match=r"no setting 'lidar\.range\.x', since 'lidar\.range' is a single one"):
        scenario("thesis-open").with_settings({"lidar.range.x": 5})


def test_another_kind_of_map_brings_its_own_settings():
    for settings in ({"map.source": "rooms", "map.loops": 0.5}, {"map.loops": 0.5, "map.source": "rooms"}):
        assert scenario("thesis-open").with_settings(settings).map == RoomsMaps(loops=0.5)
    assert scenario("rooms").with_settings({"map.source": "rooms", "map.height": 40}).map == RoomsMaps(height=40)
    for wrong, message in (("romos", "map.source: expected a kind of map"), ("files", "map.paths: ")):
        with pytest.raises(InputError, match=message):
            scenario("thesis-open").with_settings({"map.source": wrong})


def test_the_fingerprint_is_of_the_task_and_not_of_its_name():
    task = scenario("thesis-open")
    assert task.with_settings({"name": "other"}).fingerprint == task.fingerprint
    assert task.with_settings({"lidar.range": 4}).fingerprint != task.fingerprint


def test_the_thesis_s_experiments_are_presets():
    """Tables 4.1 and 4.2, and the tests of section 4.2, one by one."""
    table = {1: (-0.5, -400, -400, 1, 400), 2: (-1, -100000, -10000, 10, 10000), 3: (-10, -1000, -1000, 10, 1000)}
    for number, (step, crash, stuck, cell, goal) in table.items():
        for method, rule in enumerate(("off", "no-discovery", "oscillation")):
            task = scenario(f"thesis-rewards-{number}-stuck-{method}")
            paid = task.rewards
            assert (paid.step, paid.collision, paid.out_of_bounds, paid.stuck) == (step, crash, crash, stuck)
            assert (paid.discovered, paid.received, paid.goal) == (cell, cell, goal)
            assert (task.stuck.rule, task.stuck.window, task.stuck.repeats) == (rule, 50, 20)
            assert (task.map.obstacles, task.team, task.budget) == (0, 1, 400)
    for team in (2, 4):
        for reach in (0, 1, 3):
            task = scenario(f"thesis-team-{team}-radio-{reach}")
            assert (task.team, task.radio.range, task.map.obstacles) == (team, reach, 5)
            assert task.radio.model == ("square" if reach else "none")
            assert task.rewards.received == task.rewards.discovered == 1.0


def test_map_files_are_looked_for_beside_the_scenario(tmp_path):
    (tmp_path / "task.toml").write_text('team = 2\n[map]\nsource = "files"\npaths = ["floor.png"]\n')
    assert load_scenario(tmp_path / "task.toml").map.paths == (str(tmp_path / "floor.png"),)


def test_comparisons_fly_to_full_coverage_of_the_team_or_to_the_goal_of_every_uav():
    office = scenario("office")
    flown, every = office.for_evaluation(), office.with_settings({"goal": 0.95, "goal_of": "every"}).for_evaluation()
    assert (flown.goal, flown.goal_of, flown.stuck.rule) == (1.0, "team", "off")
    assert (every.goal, every.goal_of, every.stuck.rule) == (0.95, "every", "off")

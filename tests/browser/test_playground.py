"""The playground in a real browser: its world is the program's, step by step, and its controls do what they say."""

import json
import re

import numpy as np
import pytest

from indoor_explorers.env import World, make_policy, scenario
from indoor_explorers.env.simulation.rollout import ask_pilots, make_pilots, rollout
from indoor_explorers.evaluation.studies.playground.page import maps, playground, write_playground

from .conftest import opened

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]

TASKS = {
    "room": ("thesis-obstacles", {}),
    "dense": ("thesis-obstacles", {"map.obstacles": 14, "map.obstacle_size": [1, 3]}),
    "offices": ("small-offices", {"map.height": 30, "map.width": 34}),
    "cave": ("small-cave", {"map.height": 24, "map.width": 30}),
    "maze": ("small-maze", {"map.height": 21, "map.width": 25, "map.corridor": 1}),
}
PLAY = """([truth, starts, settings, actions]) => {
  const grid = new Grid(truth.length, truth[0].length, Uint8Array.from(truth.flat()));
  const episode = new Episode(grid, starts, settings), told = [];
  const tell = () => told.push({cells: [...episode.cells], covered: episode.covered,
                                beliefs: episode.beliefs.map((each) => Array.from(each))});
  tell();
  for (const each of actions) { episode.advance(each); tell(); }
  return {told, budget: episode.budget, total: episode.total, curve: episode.curve};
}"""
FOLLOW = """([truth, start, range, steps]) => {
  const grid = new Grid(truth.length, truth[0].length, Uint8Array.from(truth.flat()));
  const episode = new Episode(grid, [start], {range, radio: {model: "none"}, seed: 0});
  let goals = [];
  for (const [k, action] of steps.entries()) {
    const belief = episode.beliefs[0], cell = episode.cells[0], open = new Set(frontierCells(grid, belief));
    const possible = new Set([...goals.filter((goal) => open.has(goal)), ...nearestFrontier(grid, belief, cell)]);
    goals = [...possible].filter((goal) => firstActions(grid, belief, cell, goal).includes(action));
    if (!goals.length) return `step ${k}: action ${action} leads to no frontier cell that was nearest`;
    episode.advance([action]);
  }
  return `explored ${episode.covered} of ${episode.total}`;
}"""


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    """The playground, which must have nothing to complain of and ask for nothing."""
    path = tmp_path_factory.mktemp("playground") / "play.html"
    write_playground(path)
    with opened(browser, path.as_uri()) as shown:
        yield shown.page
    assert shown.complaints == []
    assert shown.asked == [path.as_uri()]


def task_of(name, **more):
    preset, settings = TASKS[name]
    changes = {"budget": None, "on_collision": "block", **settings, **more}
    return scenario(preset).for_evaluation().with_settings(changes)


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize(
    ("team", "radio", "reach"), [(1, "none", 0.0), (2, "disc", 4.0), (4, "disc", 6.0), (4, "unlimited", 0.0)]
)
def test_the_world_is_the_program_s_at_every_step(page, name, team, radio, reach):
    reached = {"room": 3.0, "dense": 5.5, "offices": 4.0, "cave": 7.2, "maze": 2.0}[name]
    task = task_of(name, team=team, **{"radio.model": radio, "radio.range": reach, "lidar.range": reached})
    world, seed, rng = World(task), 11, np.random.default_rng(team)
    world.reset([seed])
    state, width = world.state, world.state.truth.shape[2]
    actions = rng.integers(0, 5, (60, team))
    settings = {"range": reached, "radio": {"model": radio, "range": reach}, "seed": seed}
    starts = [int(row * width + col) for row, col in state.cell[0]]
    found = page.evaluate(PLAY, [state.truth[0].tolist(), starts, settings, actions.tolist()])
    assert (found["budget"], found["total"]) == (int(state.budget[0]), int(state.total[0]))
    for step, told in enumerate(found["told"]):
        assert told["cells"] == [int(row * width + col) for row, col in state.cell[0]], step
        assert told["covered"] == int(state.team_covered[0]), step
        np.testing.assert_array_equal(told["beliefs"], state.belief[0].reshape(team, -1), err_msg=str(step))
        if step < len(actions):
            world.step(actions[step][None])


@pytest.mark.parametrize("name", TASKS)
def test_the_nearest_frontier_is_the_planner_s_move_by_move(page, name):
    world = World(task_of(name, team=1))
    for seed in range(2):
        world.reset([seed])
        start, truth = world.state.cell[0, 0].tolist(), world.state.truth[0].tolist()
        policy = make_policy("frontier-nearest")
        flight = rollout(world, ask_pilots(policy, make_pilots(policy, world), world))
        steps = [int(actions[0, 0]) for actions in flight]
        asked = [truth, start[0] * len(truth[0]) + start[1], world.scenario.lidar.range, steps]
        covered, total = int(world.state.team_covered[0]), int(world.state.total[0])
        assert page.evaluate(FOLLOW, asked) == f"explored {covered} of {total}"
        assert covered == total or name == "maze"  # where the budget may be too short


def cell_on_screen(page, row, col):
    """Return where the middle of a cell of the empty room is drawn."""
    box = page.locator("#map").bounding_box()
    side = box["width"] / 16
    return box["x"] + (col + 0.5) * side, box["y"] + (row + 0.5) * side


def status(page):
    return page.locator("#status").inner_text()


def played(page):
    """Fly to the end without waiting for the clock."""
    page.evaluate("() => { while (!playground.episode.over) playground.advance(); }")
    return status(page)


@pytest.mark.parametrize("policy", ["nearest frontier", "most unknown in view per step"])
@pytest.mark.parametrize("team", ["1", "2", "4"])
def test_every_map_is_explored(page, policy, team):
    page.select_option("#team", team)
    page.select_option("#policy", policy)
    for name in maps():
        page.select_option("#preset", name)
        if "all explored" not in played(page):  # the budget is one step for each cell
            assert name == "a maze" or policy != "nearest frontier", (name, status(page))
            least = 0.6 if name == "a maze" else 0.9
            assert page.evaluate("playground.episode.coverage") > least, (name, status(page))


def test_a_wall_is_drawn_and_flown_around(page):
    page.select_option("#team", "1")
    page.select_option("#preset", "an empty room")
    before = page.evaluate("playground.episode.total")
    page.locator("input[value=wall]").check()
    page.mouse.move(*cell_on_screen(page, 2, 4))
    page.mouse.down()
    page.mouse.move(*cell_on_screen(page, 7, 4), steps=20)
    page.mouse.up()
    drawn = page.locator("#text").input_value().splitlines()
    assert [row[4] for row in drawn] == [*"..", *"######", *"........"]
    assert page.evaluate("playground.episode.total") == before - 6
    page.locator("#play").click()
    page.locator("#speed").fill("60")
    page.locator("#status", has_text=re.compile(r"Step [1-9]\d ")).wait_for()
    page.locator("#play").click()
    assert status(page).startswith("Step ")
    assert "T99" in played(page)


def test_fields_keep_to_their_limits(page):
    for typed, kept in (("-5", "1"), ("999", "12"), ("4", "4")):
        page.locator("#range").fill(typed)
        page.locator("#range").dispatch_event("change")
        assert page.locator("#range").input_value() == kept
    assert "% of what can be reached is known" in status(page)


def test_uavs_are_placed_where_the_reader_says(page):
    page.select_option("#preset", "an empty room")
    page.select_option("#team", "2")
    page.locator("input[value=uav]").check()
    for cell in ((1, 1), (14, 13)):
        page.mouse.click(*cell_on_screen(page, *cell))
    assert page.evaluate("playground.episode.cells") == [17, 14 * 16 + 13]
    page.locator("input[value=wall]").check()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("......\n.....", "Row 2 has 5 cells, expected 6"),
        ("......\n...x..", 'got "x"'),
        ("...\n...\n...", "got 3 x 3"),
        ("\n".join(["######"] * 6), "Expected some free cells, got none"),
    ],
)
def test_a_text_that_is_no_map_is_refused_in_one_line(page, text, said):
    before = page.evaluate("playground.episode.total")
    page.locator("summary").click() if not page.locator("#text").is_visible() else None
    page.locator("#text").fill(text)
    page.locator("#load").click()
    assert said in page.locator("#problem").inner_text()
    assert page.evaluate("playground.episode.total") == before
    page.locator("#text").fill("\n".join(["......"] * 6))
    page.locator("#load").click()
    assert page.locator("#problem").inner_text() == ""


def test_the_page_is_the_same_every_time():
    assert playground() == playground()
    assert json.dumps(list(maps())) == json.dumps(list(dict.fromkeys(maps())))

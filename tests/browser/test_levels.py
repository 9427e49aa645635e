"""The replay of a map of several levels in a real browser."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.env import PRESETS, make_policy
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.rendering.level_grid import LevelGrid
from indoor_explorers.env.search.frontiers import frontier_mask
from indoor_explorers.evaluation.harness.episodes.flight import explained_again
from indoor_explorers.evaluation.harness.episodes.resimulate import resimulate
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Experiment, PolicyChoice, Task
from indoor_explorers.evaluation.harness.experiment.policy_facts import policy_facts
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report import write_report
from indoor_explorers.evaluation.report.page import _raw

from .conftest import opened

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]

SCENARIO = PRESETS["small-storeys"].for_evaluation()
POLICY, STEP = "frontier-nearest", 50
#: RGB of a light page's map, by what a cell is.
INKS = {"unknown": "--ghost-free --ghost-wall", "frontier": "--frontier", "free": "--free", "wall": "--wall"}


@pytest.fixture(scope="module")
def record():
    return next(iter(fly(make_policy(POLICY), POLICY, SCENARIO, [Task(SCENARIO.name, 0, 0)])))


@pytest.fixture(scope="module")
def tall(record, tmp_path_factory):
    """The address of a report on levels."""
    path = tmp_path_factory.mktemp("tall") / "report.html"
    settings = {SCENARIO.name: {"fingerprint": SCENARIO.fingerprint, **SCENARIO.model_dump(mode="json")}}
    choices = (PolicyChoice(use=POLICY, name=POLICY),)
    experiment = Experiment(policies=choices, scenarios=(SCENARIO,), episodes=1, seed=0).to_toml()
    facts = {POLICY: policy_facts(make_policy(POLICY), POLICY)}
    write_report(Results(facts, settings, [], [record], (experiment,)), path, explanations=60.0)
    return path.as_uri()


@pytest.fixture(scope="module")
def world(record):
    for step, world in enumerate(resimulate(record, SCENARIO)):
        if step == STEP:
            return world
    raise AssertionError(f"the episode ended before step {STEP}")


@pytest.mark.parametrize("size", [(7, 24, 24), (2, 5, 9), (1, 6, 8)])
def test_the_page_puts_cells_where_pictures_do(page, size):
    levels = Levels(*size)
    height, width = levels.shape
    given = {"height": height, "width": width} | ({"levels": size[0]} if size[0] > 1 else {})
    cells = np.argwhere(~levels.between)
    grids = page.evaluate(
        f"""([episode, cells]) => {{
            {_raw("replay_levels.js")}
            return LevelGrid.options(episode).map((grid) => [[grid.height, grid.width],
                cells.map(([row, column]) => grid.place(row, column))]);
        }}""",
        [given, cells.tolist()],
    )
    for columns, (shape, places) in enumerate(grids, 1):
        grid = LevelGrid(levels, columns)
        assert tuple(shape) == grid.shape
        np.testing.assert_array_equal(places, grid.places(cells))
    assert len(grids) == size[0]


@pytest.mark.parametrize("width", [1280, 390])
def test_levels_lie_beside_each_other_and_show_what_the_team_knows(browser, tall, world, record, width):
    colours = f"#replay=s1;step={STEP};layers=truth,known,frontier"
    with opened(browser, tall + colours, viewport={"width": width, "height": 844}) as visit:
        page, levels = visit.page, record.floorplan.levels
        data = page.evaluate("document.querySelector('#replay-s1 canvas.map').toDataURL().split(',')[1]")
        picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGBA")).astype(int)
        inks = {
            name: page.evaluate(
                "names => names.map((name) => getComputedStyle(document.body).getPropertyValue(name).trim())",
                names.split(),
            )
            for name, names in INKS.items()
        }
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert visit.complaints == []
    grid = next(
        grid
        for grid in (LevelGrid(levels, columns) for columns in range(2, 8))
        if picture.shape[0] * grid.shape[1] == picture.shape[1] * grid.shape[0]
    )
    scale = picture.shape[0] // grid.shape[0]
    rgb = {name: [tuple(bytes.fromhex(ink[1:])) for ink in found] for name, found in inks.items()}
    union, frontier = world.state.union[0], frontier_mask(world.state.union[0], levels.rise)
    assert frontier.any()
    cells = np.argwhere(~levels.between)
    uavs, places = grid.places(world.state.cell[0]), grid.places(cells)
    away = np.abs(places[:, None] - uavs).max(axis=2).min(axis=1) * scale > 12
    for cell, place in zip(cells[away], places[away], strict=True):
        kind = "unknown" if union[tuple(cell)] == UNKNOWN else "frontier" if frontier[tuple(cell)] else "wall"
        kind = "free" if kind == "wall" and union[tuple(cell)] == FREE else kind
        row, col = place * scale + scale // 2
        assert tuple(picture[row, col, :3]) in rgb[kind], (tuple(cell), kind)
    for row, col in map(grid.corner, range(levels.number - grid.columns)):
        below = picture[(row + 24) * scale + scale // 2, (col + 16) * scale : (col + 24) * scale]
        assert not below.any()  # nothing, where the data have a row of obstacles
    for row, col in uavs * scale + scale // 2:
        around = picture[row - 5 : row + 6, col - 5 : col + 6, :3].reshape(-1, 3)
        assert len({tuple(shade) for shade in around} - {ink for found in rgb.values() for ink in found}) > 3


def test_explanations_name_level_row_and_column(browser, tall, record):
    told = list(explained_again(record, SCENARIO, make_policy(POLICY)))[STEP - 1][0]
    with opened(browser, f"{tall}#replay=s1;step={STEP};why={POLICY},0") as visit:
        cells = visit.page.locator("#replay-s1 .why tbody td:nth-child(2)").all_inner_texts()
        said = visit.page.locator("#replay-s1 .why p").first.inner_text()
        assert visit.complaints == []
    voxel = record.floorplan.levels.voxel
    assert cells == [str(voxel(each.cell)) for each in told.candidates[:6]]
    assert {text.split(",")[0] for text in cells} != {"(0"}
    assert f"Flies to {voxel(told.goal)}, " in said


def shown_cells(belief, levels, shown):
    """Return the flat cells of a plane that are drawn of the lowest ``shown`` levels, by what they are."""
    known = levels.volume(belief)[:shown]
    around = np.pad(known == OCCUPIED, 1)
    axes = [(axis, way) for axis in range(3) for way in (-1, 1)]
    enclosed = np.logical_and.reduce([np.roll(around, way, axis)[1:-1, 1:-1, 1:-1] for axis, way in axes])
    below = np.pad(known == OCCUPIED, ((1, 0), (0, 0), (0, 0)), constant_values=True)[:-1]
    frontier = levels.volume(frontier_mask(belief, levels.rise))[:shown]
    found = {
        "walls": (known == OCCUPIED) & ~enclosed,
        "floors": (known == FREE) & below,
        "frontier": frontier,
    }
    numbers = levels.volume(np.arange(belief.size).reshape(levels.shape))[:shown]
    return {name: numbers[mask].tolist() for name, mask in found.items()}


def cut(page, shown):
    """Show so many levels."""
    page.locator("#replay-s1 .cut input").evaluate(
        "(box, levels) => { box.value = levels; box.dispatchEvent(new Event('input')); }", shown
    )


@pytest.mark.parametrize("whose", ["team", "uav-1"])
def test_what_is_drawn_in_three_dimensions_is_what_the_map_shows(drawing_browser, tall, world, record, whose):
    levels = record.floorplan.levels
    belief = world.state.union[0] if whose == "team" else world.view(0, 1).belief
    with opened(drawing_browser, f"{tall}#replay=s1;step={STEP};map={whose}") as visit:
        for shown in (7, 3, 1):
            cut(visit.page, shown)
            cells = visit.page.locator("#replay-s1 canvas.space").evaluate("canvas => canvas.cells")
            assert cells == shown_cells(belief, levels, shown)
            assert all(cells.values())
            assert visit.page.locator("#replay-s1 .cut output").inner_text() == f"{shown} of 7"
        assert [text for text in visit.complaints if "GPU stall" not in text] == []


def picture(page):
    return page.locator("#replay-s1 canvas.space").evaluate("canvas => canvas.toDataURL()")


def test_dragging_turns_the_building_and_the_timeline_moves_it_on(drawing_browser, tall):
    with opened(drawing_browser, f"{tall}#replay=s1;step={STEP}") as visit:
        page, canvas = visit.page, visit.page.locator("#replay-s1 canvas.space")
        before = picture(page)
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        page.mouse.move(box["x"] + 200, box["y"] + 100)
        page.mouse.down()
        page.mouse.move(box["x"] + 320, box["y"] + 130, steps=3)
        page.mouse.up()
        page.evaluate("() => new Promise(requestAnimationFrame)")
        turned = picture(page)
        page.get_by_role("button", name="Look at the whole building").click()
        page.evaluate("() => new Promise(requestAnimationFrame)")
        again = picture(page)
        page.keyboard.press("ArrowRight")
        page.evaluate("() => new Promise(requestAnimationFrame)")
        assert f"at step {STEP + 1} " in canvas.get_attribute("aria-label")
        assert before == again
        assert len({before, turned, picture(page)}) == 3


def test_a_click_in_three_dimensions_explains_a_uav_and_a_drag_from_it_does_not(drawing_browser, tall):
    with opened(drawing_browser, f"{tall}#replay=s1;step={STEP}") as visit:
        page, canvas = visit.page, visit.page.locator("#replay-s1 canvas.space")
        canvas.scroll_into_view_if_needed()
        x, y = canvas.evaluate("canvas => canvas.marks.at(0).map((at) => at * canvas.clientWidth / canvas.width)")
        box = canvas.bounding_box()
        page.mouse.move(box["x"] + x, box["y"] + y)
        page.mouse.down()
        page.mouse.move(box["x"] + x + 60, box["y"] + y, steps=3)
        page.mouse.up()
        assert not page.locator("#replay-s1 .why").is_visible()
        page.get_by_role("button", name="Look at the whole building").click()
        page.evaluate("() => new Promise(requestAnimationFrame)")
        canvas.click(position={"x": x, "y": y})
        page.locator("#replay-s1 .why").wait_for(state="visible")
        page.wait_for_url(f"**why={POLICY},0*")


def test_slices_and_three_dimensions_can_be_had_alone_and_fit_a_phone(drawing_browser, tall):
    with opened(drawing_browser, f"{tall}#replay=s1", viewport={"width": 390, "height": 844}) as visit:
        page = visit.page
        for view, slices, space in (("Slices", 1, 0), ("3D", 0, 1), ("Both", 1, 1)):
            page.locator("#replay-s1").get_by_role("button", name=view, exact=True).click()
            assert page.locator("#replay-s1 canvas.map:visible").count() == slices
            assert page.locator("#replay-s1 canvas.space:visible").count() == space
            assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_without_webgl_the_slices_stay_and_a_line_says_why(browser, tall):
    with opened(browser, f"{tall}#replay=s1") as visit:
        assert visit.page.get_by_text("this browser offers no WebGL 2").is_visible()
        assert visit.page.locator("#replay-s1 canvas.map:visible").count() == 1
        assert visit.page.locator("#replay-s1 canvas.space").count() == 0
        assert not visit.page.locator("#replay-s1 .cut").is_visible()
        assert visit.complaints == []


def test_pages_without_levels_have_nothing_of_it(page):
    assert page.evaluate("typeof THREE") == "undefined"
    assert page.locator("canvas.space, .spacebar").count() == 0

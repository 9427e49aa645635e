"""Lower bounds on the steps to a coverage, which hold for every team, whatever it knows.

They follow from how much the cells that are flown through can show at most. A cell that is visited again shows nothing
new, so every cell counts once for the whole team; and no UAV is in a cell before as many steps have passed as the
nearest start is away.
"""

from __future__ import annotations

import hashlib
import math

import numpy as np

from indoor_explorers.env import World
from indoor_explorers.env.grid.cells import MOVES
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.search.bitsets import bit_count
from indoor_explorers.env.search.visibility import VisibilityTable, add_visible, count_cells, visibility_table
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.evaluation.harness.episodes.flow_bound import flow_bound
from indoor_explorers.evaluation.harness.episodes.mst_bound import spanning_tree_bound

#: Cells x cells in lidar range up to which walls are taken into account, which takes a tenth of a second.
EFFORT = 20_000_000
#: Tasks whose bound a process remembers.
REMEMBERED = 100_000

_FOUND: dict[bytes, int] = {}


def least_steps(world: World, episode: int, share: float) -> int:
    """Return a certified lower bound on the steps to a team coverage of ``share``, for an episode that has just begun.

    It is the largest of the :func:`lower_bounds`. A process works it out once for the episodes of all policies. It is 0
    where a plug-in scans, since nothing is known of what that sees, and where scans or poses err.
    """
    scenario = world.scenario
    if scenario.lidar.custom is not None or scenario.noise.any or scenario.drift.rate > 0.0:
        return 0
    task = _task(world, episode, share)
    if task not in _FOUND:
        if len(_FOUND) >= REMEMBERED:
            _FOUND.clear()
        _FOUND[task] = max(lower_bounds(world, episode, share).values())
    return _FOUND[task]


def _task(world: World, episode: int, share: float) -> bytes:
    """Return a hash of all that the bounds depend on."""
    state = world.state
    facts = (state.truth[episode].shape, *world.scenario.lidar_arguments, world.scenario.denominator, share, EFFORT)
    arrays = (state.truth[episode], state.counts[episode], state.cell[episode])
    return hashlib.sha256(b"".join([repr(facts).encode(), *(array.tobytes() for array in arrays)])).digest()


def lower_bounds(world: World, episode: int, share: float) -> dict[str, int]:
    """Return certified lower bounds on the steps to a team coverage of ``share``, for an episode that has just begun.

    - by range: what is seen lies within lidar range of a cell flown through. The discs around the starts hold a known
      number of cells, and a step shifts a disc, which adds its leading edge at most: some g(y) for a step to cell y.
    - by sight: the first scans show S cells. A UAV that moves from x to y has seen V(x), so that y adds
      V(y) - V(x) - S, at most some g(y) over all neighbours x.
    - by distance: in t steps only what can be seen from cells at most t steps from a start is seen.
    - by spanning tree: see :mod:`indoor_explorers.evaluation.harness.episodes.mst_bound`.
    - by flow: see :mod:`indoor_explorers.evaluation.harness.episodes.flow_bound`, mostly the largest by far.

    For the first two, the most that can be seen in t steps is found by taking, in each step, the N largest gains among
    the cells that can be reached by then and are not taken yet, N UAVs entering no more. No choice does better: if
    one leaves out the largest gain available in some step, taking it there instead loses nothing, now or later.
    On very large maps walls are left out, and only the first bound is used. The first bound is not used on maps of
    several levels, and none on very large ones of these.
    """
    state, sensor = world.state, world.scenario.lidar
    truth, counts, team = state.truth[episode], state.counts[episode], world.scenario.team
    starts = [(row, col) for row, col in state.cell[episode].tolist()]
    total = int(counts.sum())
    lidar, flat = lidar_model(*world.scenario.lidar_arguments), world.scenario.map.level_count == 1
    looks = total * lidar.disc <= EFFORT
    if not (looks or flat):
        return {"distance": 0}
    lidar = lidar if looks else lidar_model(0.0)
    table = visibility_table(truth, starts, lidar, count_all_cells=world.scenario.denominator == "map")
    needed = math.ceil(share * total - 1e-9)
    steps = _steps_from_starts(table, team)
    overshoot = 0.5 if sensor.model == "marsexplorer" else 0.0  # cells that this model sees beyond the range
    half_widths = lidar_model(sensor.range + overshoot).half_widths
    within, edges = _range_gains(counts, table.cells, team, half_widths)
    by_range = {"range": _steps_by_gain(edges, edges.max(), steps, needed - within, team)} if flat else {}
    if not looks:
        return by_range
    seen, news = _sight_gains(table, team)
    return {
        **by_range,
        "sight": _steps_by_gain(news, news.max(), steps, needed - seen, team),
        "distance": _steps_by_distance(table, steps, needed),
        "spanning tree": spanning_tree_bound(table, truth.shape[1], team, total - needed),
        "flow": flow_bound(table, team, max(0, count_cells(table.union) - needed)),
    }


@kernel()
def _steps_from_starts(table: VisibilityTable, team: int) -> np.ndarray:
    """Return the steps (M,) from the nearest start to each cell; cells are numbered in that order."""
    steps = np.full(table.cells.shape[0], -1, np.int64)
    steps[:team] = 0
    for cell in range(table.cells.shape[0]):
        for k in range(table.neighbours.shape[1]):
            other = table.neighbours[cell, k]
            if other >= 0 and steps[other] < 0:
                steps[other] = steps[cell] + 1
    return steps


@kernel()
def _sight_gains(table: VisibilityTable, team: int) -> tuple[int, np.ndarray]:
    """Return how many cells the starts show, and how many each cell adds to them and to any one neighbour's, (M,)."""
    known, seen = np.zeros_like(table.union), 0
    for cell in range(team):
        seen += add_visible(table, cell, known)
    gains, shown = np.zeros(table.cells.shape[0], np.int64), known.copy()
    for cell in range(table.cells.shape[0]):
        for place in range(table.offsets[cell], table.offsets[cell + 1]):
            shown[table.tile[place]] |= table.bits[place]
        for k in range(table.neighbours.shape[1]):
            other = table.neighbours[cell, k]
            if other >= 0:
                new = np.int64(0)
                for place in range(table.offsets[other], table.offsets[other + 1]):
                    new += np.int64(bit_count(table.bits[place] & ~shown[table.tile[place]]))
                gains[other] = max(gains[other], new)
        for place in range(table.offsets[cell], table.offsets[cell + 1]):
            shown[table.tile[place]] = known[table.tile[place]]
    return seen, gains


@leaf(entry=False)
def _edge(left: np.ndarray, row: int, col: int, down: int, right: int, half_widths: np.ndarray) -> int:
    """Count the cells ``left`` (H, W) on the edge of a disc around (row, col) that leads in a direction."""
    height, width = left.shape
    count = np.int64(0)
    for away in range(1 - half_widths.shape[0], half_widths.shape[0]):
        ahead = half_widths[abs(away)]
        r, c = row + down * ahead + right * away, col + right * ahead + down * away
        if 0 <= r < height and 0 <= c < width:
            count += left[r, c]
    return int(count)


@kernel()
def _range_gains(counts: np.ndarray, cells: np.ndarray, team: int, half_widths: np.ndarray) -> tuple[int, np.ndarray]:
    """Return how many cells are in range of the starts, and how many more each cell's disc adds at most, (M,)."""
    (height, width), left, within = counts.shape, counts.copy(), 0
    for n in range(team):
        row, col = divmod(cells[n], width)
        for r in range(max(0, row - half_widths.shape[0] + 1), min(height, row + half_widths.shape[0])):
            half = half_widths[abs(r - row)]
            for c in range(max(0, col - half), min(width, col + half + 1)):
                within += left[r, c]
                left[r, c] = False
    gains = np.zeros(cells.shape[0], np.int64)
    for k in range(cells.shape[0]):
        row, col = divmod(cells[k], width)
        for move in range(4):
            gains[k] = max(gains[k], _edge(left, row, col, MOVES[move, 0], MOVES[move, 1], half_widths))
    return within, gains


@kernel()
def _steps_by_gain(gains: np.ndarray, largest: int, steps: np.ndarray, missing: int, team: int) -> int:
    """Return the fewest steps in which the largest reachable gains add up to ``missing``."""
    waiting = np.zeros(largest + 1, np.int64)
    cell, passed = team, 0
    while missing > 0:
        passed += 1
        while cell < steps.shape[0] and steps[cell] <= passed:
            waiting[gains[cell]] += 1
            cell += 1
        free = team
        for gain in range(waiting.shape[0] - 1, 0, -1):
            taken = min(free, waiting[gain])
            waiting[gain] -= taken
            free -= taken
            missing -= gain * taken
        if free == team and cell == steps.shape[0]:
            break
    return passed


@kernel()
def _steps_by_distance(table: VisibilityTable, steps: np.ndarray, needed: int) -> int:
    """Return the least distance d so that ``needed`` cells can be seen from cells at most d steps from a start."""
    seen, possible = np.zeros_like(table.union), 0
    for cell in range(steps.shape[0]):
        possible += add_visible(table, cell, seen)
        if possible >= needed:
            return int(steps[cell])
    return int(steps[-1])

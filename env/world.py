"""The one simulator: a batch of exploration episodes stepped together by compiled kernels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.arrays import Belief, Cell, Mask
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid import FREE, MOVES, OCCUPIED, UNREACHABLE, distance_field
from indoor_explorers.env.kernels import advance, begin
from indoor_explorers.env.lidar import optics
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.randomness import Stream, counter_key, generator
from indoor_explorers.env.scenario import Scenario
from indoor_explorers.env.state import End, State, empty_state, rules_of
from indoor_explorers.env.view import MESSAGE_LIMIT, Briefing, Mate, Message, View

#: Maps drawn for one seed before a scenario is given up as impossible.
MAX_ATTEMPTS = 100


class World:
    """Simulate ``batch`` episodes of one scenario at once; a single environment is a batch of one.

    All episodes of a batch explore maps of the same shape. Fill them with :meth:`reset` or
    :meth:`begin`, then alternate :meth:`view` and :meth:`step`. An agent that has ended is gone: it
    neither moves, scans, transmits nor stands in anybody's way.
    """

    def __init__(self, scenario: Scenario, batch: int = 1) -> None:
        self.scenario = scenario
        self.batch = batch
        self.floorplans: list[Floorplan | None] = [None] * batch
        self.seeds = [0] * batch
        self._rules = rules_of(scenario)
        self._optics = optics(scenario.lidar.range, scenario.lidar.model)
        self._state: State | None = None
        self._beliefs: list[list[Belief]] = []
        self._legals: list[list[Mask]] = []
        self._visited: list[list[Mask]] = []

    @property
    def state(self) -> State:
        """The arrays of the batch, for readers who know what they are doing."""
        if self._state is None:
            raise InputError("expected a world with episodes in it, got a new one; call reset first")
        return self._state

    def reset(self, seeds: Sequence[int], *, index: int = 0) -> None:
        """Start every episode of the batch on the map and spawns of its seed; ``index`` picks among map files."""
        if len(seeds) != self.batch:
            raise InputError(f"expected one seed for each of {self.batch} episodes, got {len(seeds)}")
        for b, seed in enumerate(seeds):
            self.begin(b, seed, index=index)

    def begin(
        self,
        episode: int,
        seed: int,
        *,
        index: int = 0,
        floorplan: Floorplan | None = None,
        spawns: Sequence[Cell] | None = None,
    ) -> None:
        """Start one episode; a given ``floorplan`` or ``spawns`` replaces what the seed would draw."""
        if floorplan is None:
            floorplan = draw_floorplan(self.scenario, seed, index)
        if spawns is None:
            spawns = draw_spawns(self.scenario, floorplan, seed)
        if self._state is None:
            self._allocate(floorplan.shape)
        state = self.state
        if floorplan.shape != state.truth.shape[1:]:
            raise InputError(
                f"expected a map of shape {state.truth.shape[1:]} like the others of the batch, "
                f"got {floorplan.shape} ({floorplan.name}); use a world for each shape"
            )
        self.floorplans[episode], self.seeds[episode] = floorplan, seed
        for name, array in state._asdict().items():
            array[episode] = -1 if name in {"history", "heard_step", "heard_size", "outbox_size"} else 0
        state.truth[episode] = floorplan.truth
        state.cell[episode] = spawns
        state.order_key[episode] = counter_key(seed, Stream.ORDER)
        reachable = reachable_cells(floorplan.truth, spawns)
        state.counts[episode] = reachable if self.scenario.denominator == "reachable" else True
        state.total[episode] = int(state.counts[episode].sum())
        state.needed[episode] = int(np.ceil(self.scenario.goal * state.total[episode] - 1e-9))
        state.budget[episode] = self.scenario.budget_for(int(reachable.sum()))
        begin(self._rules, state, self._optics, episode)

    def _allocate(self, shape: tuple[int, int]) -> None:
        window = self.scenario.stuck.window if self.scenario.stuck.rule == "oscillation" else 1
        self._state = empty_state(self.batch, self.scenario.team, shape, window)
        self._beliefs = [[_read_only(belief) for belief in team] for team in self._state.belief]
        self._legals = [[_read_only(legal) for legal in team] for team in self._state.legal]
        self._visited = [[_read_only(visited) for visited in team] for team in self._state.visited]

    def step(self, actions: NDArray[np.integer[Any]]) -> None:
        """Advance all running episodes by one step; ``actions`` is (B, N), those of ended agents are ignored."""
        actions = np.ascontiguousarray(actions, np.int64)
        if actions.shape != self.state.end.shape:
            raise InputError(
                f"expected actions of shape {self.state.end.shape} (episodes, agents), got {actions.shape}"
            )
        if actions.min() < 0 or actions.max() > 4:
            raise InputError(f"expected actions from 0 to 4, got {int(actions.min())} to {int(actions.max())}")
        advance(self._rules, self.state, self._optics, actions)

    def post(self, episode: int, agent: int, message: Message) -> None:
        """Put what an agent says into its outbox; it is sent after each move until it is replaced."""
        state = self.state
        if message is None:
            state.outbox_size[episode, agent] = -1
            return
        if len(message) > MESSAGE_LIMIT:
            raise InputError(f"expected a message of at most {MESSAGE_LIMIT} numbers, got {len(message)}")
        state.outbox[episode, agent, : len(message)] = message
        state.outbox_size[episode, agent] = len(message)

    def view(self, episode: int, agent: int) -> View:
        """Return what one agent knows now."""
        state = self.state
        row, col = state.cell[episode, agent].tolist()
        return View(
            belief=self._beliefs[episode][agent],
            cell=(row, col),
            legal=self._legals[episode][agent],
            step=int(state.step[episode]),
            budget=int(state.budget[episode]),
            mates=self._mates(episode, agent) if self.scenario.team > 1 else (),
            visited=self._visited[episode][agent],
        )

    def _mates(self, episode: int, agent: int) -> tuple[Mate, ...]:
        state = self.state
        now = int(state.step[episode])
        mates = []
        for mate, when in enumerate(state.heard_step[episode, agent].tolist()):
            if when >= 0:
                row, col = state.heard_cell[episode, agent, mate].tolist()
                size = int(state.heard_size[episode, agent, mate])
                message = tuple(state.heard[episode, agent, mate, :size].tolist()) if size >= 0 else None
                mates.append(Mate(mate, (row, col), now - when, message))
        return tuple(mates)

    def briefing(self, episode: int, agent: int, *, privileged: bool = False) -> Briefing:
        """Return what one agent's pilot is told before the episode."""
        return Briefing(
            agent=agent,
            team=self.scenario.team,
            shape=self.state.truth.shape[1:],
            lidar_range=self.scenario.lidar.range,
            scenario=self.scenario,
            rng=generator(self.seeds[episode], Stream.PILOT, agent),
            truth=_read_only(self.state.truth[episode]) if privileged else None,
        )

    @property
    def flying(self) -> Mask:
        """(B, N) agents that have not ended."""
        return np.asarray(self.state.end == End.FLYING)

    @property
    def team_coverage(self) -> NDArray[np.float64]:
        """(B,) share of the denominator that the team knows together."""
        return np.asarray(self.state.team_covered / self.state.total)

    @property
    def coverage(self) -> NDArray[np.float64]:
        """(B, N) share of the denominator that each agent knows."""
        return np.asarray(self.state.covered / self.state.total[:, None])


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    window = array.view()
    window.setflags(write=False)
    return window


def reachable_cells(truth: Belief, spawns: Sequence[Cell]) -> Mask:
    """Return the (H, W) mask of free cells that can be reached from any of the spawns."""
    mask = np.zeros(truth.shape, np.bool_)
    for cell in spawns:
        if not mask[tuple(cell)]:
            mask |= distance_field(truth, (int(cell[0]), int(cell[1]))) < UNREACHABLE
    return mask


def draw_floorplan(scenario: Scenario, seed: int, index: int = 0) -> Floorplan:
    """Return the map of an episode seed, drawn again when the goal could not be reached on it."""
    for attempt in range(MAX_ATTEMPTS if scenario.map.generated else 1):
        floorplan = scenario.map.floorplan(index, seed, attempt)
        if attainable(scenario, floorplan):
            return floorplan
    if (room := int(floorplan.main_part.sum())) < scenario.team:
        raise InputError(
            f"{floorplan.name}: expected room for {scenario.team} UAVs, got {room} connected free cells; "
            "use a smaller team or a larger map"
        )
    raise InputError(
        f"scenario {scenario.name!r}: {scenario.goal:.0%} of the map's cells can never be seen on {floorplan.name}; "
        "lower goal, use fewer obstacles, or denominator = 'reachable'"
    )


def attainable(scenario: Scenario, floorplan: Floorplan) -> bool:
    """Tell whether the goal coverage can be reached, and the team fits, on the map's largest free part."""
    part = floorplan.main_part
    if part.sum() < scenario.team:
        return False
    if scenario.denominator == "reachable":
        return True
    walls = np.zeros_like(part)
    for rows, cols in MOVES[:4]:
        walls |= _shifted(part, int(rows), int(cols))
    seen = part.sum() + (walls & (floorplan.truth == OCCUPIED)).sum()
    return bool(seen >= scenario.goal * part.size)


def _shifted(mask: Mask, rows: int, cols: int) -> Mask:
    padded = np.pad(mask, 1)
    height, width = mask.shape
    return padded[1 - rows : 1 - rows + height, 1 - cols : 1 - cols + width]


def draw_spawns(scenario: Scenario, floorplan: Floorplan, seed: int) -> list[Cell]:
    """Return one distinct free cell for each agent: listed, or drawn on the map's largest free part."""
    if not isinstance(scenario.spawn, str):
        return _listed_spawns(scenario.spawn, floorplan)
    cells = np.argwhere(floorplan.main_part)
    rng = generator(seed, Stream.SPAWN)
    if scenario.spawn == "random":
        chosen = cells[rng.choice(len(cells), scenario.team, replace=False)]
    else:
        first = cells[rng.integers(len(cells))]
        steps = distance_field(floorplan.truth, (int(first[0]), int(first[1])))
        chosen = cells[np.argsort(steps[cells[:, 0], cells[:, 1]], kind="stable")[: scenario.team]]
    return [(int(row), int(col)) for row, col in chosen]


def _listed_spawns(spawns: Sequence[Cell], floorplan: Floorplan) -> list[Cell]:
    height, width = floorplan.shape
    for number, (row, col) in enumerate(spawns):
        if not (0 <= row < height and 0 <= col < width and floorplan.truth[row, col] == FREE):
            raise InputError(
                f"{floorplan.name}: spawn {number} at ({row}, {col}) is no free cell of this {height} x {width} map; "
                "list a free one"
            )
    if len(set(spawns)) < len(spawns):
        raise InputError(f"{floorplan.name}: two UAVs cannot spawn in the same cell; list different cells")
    return list(spawns)

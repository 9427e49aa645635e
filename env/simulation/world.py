"""The one simulator: a batch of exploration episodes stepped together by compiled kernels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask, read_only
from indoor_explorers.env.grid.randomness import Stream, checked_seed, generator
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.sources import ThesisMaps
from indoor_explorers.env.policies.view import MESSAGE_LIMIT, Briefing, Mate, Message, View
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.sensing.lidar import optics
from indoor_explorers.env.simulation.engine import Engine, bind, new_work
from indoor_explorers.env.simulation.reset import Ground, new_ground, open_episode, open_rooms
from indoor_explorers.env.simulation.spawns import checked_spawns, draw_floorplan, draw_spawns
from indoor_explorers.env.simulation.state import End, State, empty_state, rules_of
from indoor_explorers.env.simulation.step import advance, are_actions

#: A plain number: comparing an array with an enumeration's member takes numpy ten times as long.
FLYING = int(End.FLYING)
#: Episodes for which another thread is worth its while; waking one takes about as long as stepping so many.
LEAST_SHARE = 16


class World:
    """Simulate ``batch`` episodes of one scenario at once; a single environment is a batch of one.

    All episodes of a batch explore maps of the same shape. Fill them with :meth:`reset` or
    :meth:`begin`, then alternate :meth:`view` and :meth:`step`. An agent that has ended is gone: it
    neither moves, scans, transmits nor stands in anybody's way. With several ``threads`` the episodes are
    shared out among them; what happens in an episode depends on its seed and actions alone.
    """

    def __init__(self, scenario: Scenario, batch: int = 1, *, threads: int = 1) -> None:
        self.scenario = scenario
        self.batch = batch
        self.seeds = [0] * batch
        self.openings = np.zeros(batch, np.int64)
        """(B,) how often an episode has begun in each place of the batch."""
        self._floorplans: list[Floorplan | None] = [None] * batch
        self._rules = rules_of(scenario)
        self._optics = optics(scenario.lidar.range, scenario.lidar.model)
        self._threads = max(1, min(threads, batch))
        self._pool = ThreadPoolExecutor(self._threads - 1, "world") if self._threads > 1 else None
        self._engines: list[Engine] = []
        self._state: State | None = None
        self._grounds: list[Ground] = []
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
        self.restart(range(self.batch), seeds, index=index)

    def restart(self, episodes: Sequence[int], seeds: Sequence[int], *, index: int = 0) -> None:
        """Start some episodes anew, each on the map and spawns of its seed, exactly as :meth:`begin` does."""
        if self._draws_rooms and len(episodes) > 0:
            self._restart_in_rooms(episodes, seeds)
            return
        for episode, seed in zip(episodes, seeds, strict=True):
            self.begin(episode, seed, index=index)

    @property
    def _draws_rooms(self) -> bool:
        """Whether maps and spawns can be drawn in compiled code."""
        return isinstance(self.scenario.map, ThesisMaps) and isinstance(self.scenario.spawn, str)

    def _restart_in_rooms(self, episodes: Sequence[int], seeds: Sequence[int]) -> None:
        maps = self.scenario.map
        assert isinstance(maps, ThesisMaps)
        for episode, seed in zip(episodes, seeds, strict=True):
            self._floorplans[episode], self.seeds[episode] = None, checked_seed(seed)
        self._allocated((maps.height, maps.width))
        room, clustered = maps.room, self.scenario.spawn == "clustered"
        places, keys = np.asarray(episodes, np.int64), np.asarray(seeds, np.int64)
        self.openings[places] += 1

        def open_some(thread: int, first: int, last: int) -> None:
            chosen = slice(first, last)
            opened = open_rooms(
                self._engines[thread], room, clustered, self._grounds[thread], places[chosen], keys[chosen]
            )
            if first + opened < last:
                draw_floorplan(self.scenario, int(keys[first + opened]))  # says what is wrong
                raise AssertionError("a floor plan was drawn where compiled code found none")

        self._in_threads(open_some, len(places))

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
        if floorplan is None and spawns is None and self._draws_rooms:
            self._restart_in_rooms([episode], [seed])
            return
        seed = checked_seed(seed)
        plan = draw_floorplan(self.scenario, seed, index) if floorplan is None else floorplan
        cells = draw_spawns(self.scenario, plan, seed) if spawns is None else checked_spawns(spawns, plan)
        state = self._allocated(plan.shape)
        if plan.shape != state.truth.shape[1:]:
            raise InputError(
                f"expected a map of shape {state.truth.shape[1:]} like the others of the batch, "
                f"got {plan.shape} ({plan.name}); use a world for each shape"
            )
        self._floorplans[episode], self.seeds[episode] = plan, seed
        state.truth[episode], state.cell[episode] = plan.truth, cells
        self.openings[episode] += 1
        open_episode(self._engines[0], self._grounds[0], episode, seed)

    def _allocated(self, shape: tuple[int, int]) -> State:
        if self._state is None:
            window = self.scenario.stuck.window if self.scenario.stuck.rule == "oscillation" else 1
            self._state = empty_state(self.batch, self.scenario.team, shape, window)
            self._grounds = [new_ground(shape) for _ in range(self._threads)]
            self._engines = [
                bind(self._rules, self._state, self._optics, new_work(self._optics, self.scenario.team))
                for _ in range(self._threads)
            ]
            self._beliefs = [list(team) for team in read_only(self._state.belief)]
            self._legals = [list(team) for team in read_only(self._state.legal)]
            self._visited = [list(team) for team in read_only(self._state.visited)]
        return self._state

    def floorplan(self, episode: int) -> Floorplan:
        """Return the true map of an episode and its facts."""
        plan = self._floorplans[episode]
        if plan is None:
            plan = self._floorplans[episode] = Floorplan(self.state.truth[episode].copy(), self.scenario.map.source)
        return plan

    def step(self, actions: NDArray[np.integer[Any]], then: Callable[[Engine, int, int], object] | None = None) -> None:
        """Advance all running episodes by one step; ``actions`` is (B, N), those of ended agents are ignored.

        ``then(engine, first, last)`` is called for each share of the episodes in the thread that has stepped it.
        """
        actions = np.ascontiguousarray(actions, np.int64)
        if actions.shape != self.state.end.shape:
            raise InputError(
                f"expected actions of shape {self.state.end.shape} (episodes, agents), got {actions.shape}"
            )
        if not are_actions(actions):
            raise InputError(f"expected actions from 0 to 4, got {int(actions.min())} to {int(actions.max())}")

        def work(engine: Engine, first: int, last: int) -> None:
            advance(engine, actions, first, last)
            if then is not None:
                then(engine, first, last)

        self.in_slices(work)

    def in_slices(self, work: Callable[[Engine, int, int], object]) -> None:
        """Call ``work(engine, first, last)`` for a share of the episodes in each thread, and wait for all."""
        if self._pool is None:
            work(self._engines[0], 0, self.batch)
        else:
            self._in_threads(lambda thread, first, last: work(self._engines[thread], first, last), self.batch)

    def _in_threads(self, work: Callable[[int, int, int], object], count: int) -> None:
        """Call ``work(thread, first, last)`` for a share of ``count`` things in each thread, and wait for all."""
        threads = min(self._threads, count // LEAST_SHARE + 1)
        if self._pool is None or threads == 1:
            work(0, 0, count)
            return
        bounds = [count * thread // threads for thread in range(threads + 1)]
        others = [self._pool.submit(work, t, bounds[t], bounds[t + 1]) for t in range(1, threads)]
        work(0, 0, bounds[1])
        for other in others:
            other.result()

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
        return View(
            belief=self._beliefs[episode][agent],
            cell=(state.cell.item(episode, agent, 0), state.cell.item(episode, agent, 1)),
            legal=self._legals[episode][agent],
            step=state.step.item(episode),
            budget=state.budget.item(episode),
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
            truth=read_only(self.state.truth[episode]) if privileged else None,
            starts=tuple((row, col) for row, col in self.state.cell[episode].tolist()) if privileged else None,
        )

    @property
    def flying(self) -> Mask:
        """(B, N) agents that have not ended."""
        return np.asarray(self.state.end == FLYING)

    @property
    def team_coverage(self) -> NDArray[np.float64]:
        """(B,) share of the denominator that the team knows together."""
        return np.asarray(self.state.team_covered / self.state.total)

    @property
    def coverage(self) -> NDArray[np.float64]:
        """(B, N) share of the denominator that each agent knows."""
        return np.asarray(self.state.covered / self.state.total[:, None])

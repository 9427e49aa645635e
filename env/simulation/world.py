"""The simulator: a batch of exploration episodes stepped together by compiled kernels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask, copied, read_only
from indoor_explorers.env.grid.cells import UNKNOWN
from indoor_explorers.env.grid.randomness import Stream, generator
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.policies.policy import checked_action, integers
from indoor_explorers.env.policies.view import LIVE_ARRAYS, Arrays, Briefing, Message, View, message_numbers, view_of
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.sensing.lidar import lidar_model
from indoor_explorers.env.simulation.custom_models import CustomModels
from indoor_explorers.env.simulation.engine import Engine, bind, new_work
from indoor_explorers.env.simulation.preparation import Preparation, Prepared, Threads
from indoor_explorers.env.simulation.prior_map import prior_map
from indoor_explorers.env.simulation.reset import start_episodes
from indoor_explorers.env.simulation.slam.state import Slam, empty_slam
from indoor_explorers.env.simulation.slam.step import UncertainModel
from indoor_explorers.env.simulation.state import State, empty_state, received_mates, rules_of
from indoor_explorers.env.simulation.step import FLYING, advance, are_actions


class World:
    """Simulate ``batch`` episodes of one scenario at once; a single environment is a batch of one.

    All episodes of a batch explore maps of the same shape. Start them with :meth:`reset` or :meth:`begin`, then
    alternate :meth:`view` and :meth:`step`. An agent that has ended neither moves, scans, transmits nor blocks others.
    With several ``threads`` the episodes are divided among them; an episode depends on its seed and actions alone.
    """

    def __init__(self, scenario: Scenario, batch: int = 1, *, threads: int = 1) -> None:
        self.scenario = scenario
        failures = scenario.failures.model_copy(update={"stops": ()})
        self._briefed_scenario = scenario.model_copy(update={"map": scenario.map.without_files(), "failures": failures})
        self.batch = batch
        self.seeds = [0] * batch
        self.begun = np.zeros(batch, np.int64)
        """(B,) number of episodes begun in each place of the batch."""
        self._floorplans: list[Floorplan | None] = [None] * batch
        self.slam: Slam | None = None
        """Scans, estimated poses and maps of log-odds, for reading; None where sensors and poses are exact."""
        self._state: State | None = None
        self._complete(threads)

    def _complete(self, threads: int) -> None:
        """Set the attributes that are not copied."""
        self._priors: dict[int, Belief] = {}
        """Prior maps of the episodes that were asked for theirs."""
        self._shown: dict[tuple[int, int], Arrays] = {}
        """The arrays of each (episode, agent) that was viewed."""
        self._models: CustomModels | UncertainModel | None = CustomModels.of(self.scenario)
        self._threads = Threads(max(1, min(threads, self.batch)))
        self._preparation = Preparation(self.scenario, self.batch, self._threads)
        self._engines: list[Engine] = []
        if self._state is not None:
            self._bind(self._state)

    def copy(self) -> World:
        """Return an independent world at the same step of the same episodes; the same actions have the same results.

        ``copy.deepcopy`` and ``pickle`` make the same copy. It includes no pilots, no encoders and no
        :class:`~indoor_explorers.env.observations.incremental.LivePlanes`.
        """
        twin = object.__new__(type(self))
        twin.__setstate__(self.__getstate__())
        return twin

    def __deepcopy__(self, memo: dict[int, Any]) -> World:
        return self.copy()

    def __getstate__(self) -> dict[str, Any]:
        """Return the arrays and settings, from which the engines of compiled code are rebuilt."""
        kept = ("scenario", "_briefed_scenario", "batch", "seeds", "begun", "_floorplans", "slam", "_state")
        return {name: getattr(self, name) for name in kept} | {"threads": self._threads.count}

    def __setstate__(self, kept: dict[str, Any]) -> None:
        """Take over what :meth:`__getstate__` returned, in lists and arrays of its own."""
        threads = kept.pop("threads")
        self.__dict__ |= kept
        self.seeds, self._floorplans, self.begun = self.seeds[:], self._floorplans[:], self.begun.copy()
        self._state = None if self._state is None else copied(self._state)
        self.slam = None if self.slam is None else copied(self.slam)
        self._complete(threads)

    @property
    def state(self) -> State:
        """The arrays of the batch, for reading."""
        if self._state is None:
            raise InputError("expected a world with episodes in it, got a new one; call reset first")
        return self._state

    def reset(self, seeds: Sequence[int], *, index: int = 0) -> None:
        """Start every episode of the batch on the map and spawns of its seed; ``index`` picks among map files."""
        self.restart(range(self.batch), seeds, index=index)

    def restart(self, episodes: Sequence[int], seeds: Sequence[int], *, index: int = 0) -> None:
        """Start new episodes in some places of the batch, each on the map and spawns of its seed.

        Raises:
            InputError: one of them cannot be started; then all episodes are left as they were.

        """
        self.start(self.prepare(episodes, seeds, index=index))

    def begin(
        self,
        episode: int,
        seed: int,
        *,
        index: int = 0,
        floorplan: Floorplan | None = None,
        spawns: Sequence[Cell] | None = None,
    ) -> None:
        """Start one episode; a given ``floorplan`` or ``spawns`` replaces what the seed would draw.

        Raises:
            InputError: it cannot be started; then the episode is left as it was.

        """
        if floorplan is None and spawns is None:
            self.restart([episode], [seed], index=index)
        else:
            self.start(self._preparation.given(episode, seed, index, self._shape, floorplan, spawns))

    def prepare(self, episodes: Sequence[int], seeds: Sequence[int], *, index: int = 0) -> Prepared:
        """Draw the maps and spawns of new episodes for :meth:`start`; nothing in the world changes.

        Raises:
            InputError: an episode, a seed or ``index`` is out of range, or a map or its spawns cannot be used.

        """
        return self._preparation.drawn(episodes, seeds, index, self._shape)

    def start(self, prepared: Prepared) -> None:
        """Start the episodes that :meth:`prepare` has drawn."""
        episodes, seeds, starts, floorplans = prepared
        if len(episodes) == 0:
            return
        if self._state is None:
            self.allocate((starts.truth.shape[1], starts.truth.shape[2]))
        for episode, seed, plan in zip(episodes.tolist(), seeds.tolist(), floorplans, strict=True):
            self._floorplans[episode], self.seeds[episode] = plan, seed
            self._priors.pop(episode, None)
        self.begun[episodes] += 1
        self._threads.share(
            lambda thread, first, last: start_episodes(self._engines[thread], starts, episodes, seeds, first, last),
            len(episodes),
        )
        if self._models is not None:
            self._models.begin(self._engines[0], self.state, episodes.tolist(), seeds.tolist())

    @property
    def _shape(self) -> tuple[int, ...] | None:
        """(H, W) of the maps, None before the first episode."""
        return None if self._state is None else self._state.truth.shape[1:]

    def allocate(self, shape: tuple[int, int]) -> None:
        """Allocate the arrays for maps of a ``shape`` (H, W), which the first episodes do otherwise."""
        self._state = empty_state(self.scenario, self.batch, shape)
        if self.scenario.uncertain:
            self.slam = empty_slam(self.scenario, self.batch, shape)
        self._bind(self._state)

    def _bind(self, state: State) -> None:
        """Bind the arrays to an engine of compiled code for each thread."""
        if self.slam is not None:
            self._models = UncertainModel(self.scenario, self.slam)
        rules, lidar = rules_of(self.scenario), lidar_model(*self.scenario.lidar_arguments)
        self._engines = [
            bind(rules, state, lidar, new_work(lidar, self.scenario.team)) for _ in range(self._threads.count)
        ]

    def floorplan(self, episode: int) -> Floorplan:
        """Return the true map of an episode and its facts."""
        plan = self._floorplans[episode]
        if plan is None:
            maps = self.scenario.map
            truth = self.state.truth[episode].copy()
            plan = self._floorplans[episode] = Floorplan(truth, maps.source, level_count=maps.level_count)
        return plan

    def prior(self, episode: int) -> Belief | None:
        """Return the prior map of an episode, (H, W) uint8, read-only; None where there is none."""
        if self.scenario.prior.kind == "none":
            return None
        if episode not in self._priors:
            made = prior_map(self.state.truth[episode], self.scenario.prior, self.seeds[episode])
            self._priors[episode] = read_only(made)
        return self._priors[episode]

    def step(self, actions: ArrayLike, then: Callable[[Engine, int, int], object] | None = None) -> None:
        """Advance all running episodes by one step; ``actions`` is (B, N), those of ended agents are ignored.

        ``then(engine, first, last)`` is called for each share of the episodes in the thread that has stepped it.
        """
        actions = self.checked_actions(actions)

        def work(engine: Engine, first: int, last: int) -> None:
            if self._models is None:
                advance(engine, actions, first, last)
            else:
                self._models.advance(engine, self.state, actions, first, last)
            if then is not None:
                then(engine, first, last)

        self.in_slices(work)

    def checked_actions(self, actions: ArrayLike) -> NDArray[np.int64]:
        """Return (B, N) actions as int64, refusing another shape and what is no action."""
        count = self.scenario.actions
        checked = np.ascontiguousarray(integers(actions, count), np.int64)
        if checked.shape != self.state.end.shape:
            raise InputError(
                f"expected actions of shape {self.state.end.shape} (episodes, agents), got {checked.shape}"
            )
        if not are_actions(checked, count):
            for action in checked.flat:
                checked_action(int(action), count)
        return checked

    def in_slices(self, work: Callable[[Engine, int, int], object]) -> None:
        """Call ``work(engine, first, last)`` for a share of the episodes in each thread, and wait for all."""
        self._threads.share(lambda thread, first, last: work(self._engines[thread], first, last), self.batch)

    def post(self, episode: int, agent: int, message: Message) -> None:
        """Put an agent's message into its outbox; it is sent after each move until it is replaced."""
        state, numbers = self.state, message_numbers(message)
        state.outbox_size[episode, agent] = -1 if numbers is None else len(numbers)
        if numbers is not None:
            state.outbox[episode, agent, : len(numbers)] = numbers

    def view(self, episode: int, agent: int) -> View:
        """Return the current view of one agent."""
        state, slam = self.state, self.slam
        arrays = self._shown.get((episode, agent)) or self._show(episode, agent)
        cell = (state.believed_cell.item(episode, agent, 0), state.believed_cell.item(episode, agent, 1))
        step, budget = state.step.item(episode), state.budget.item(episode)
        mates = received_mates(state, episode, agent) if self.scenario.team > 1 else ()
        contact = state.base_step.item(episode, agent) if self.scenario.base.exists else -1
        base_age, pose_std, heading = None if contact < 0 else step - contact, 0.0, None
        if slam is not None:
            pose_std = slam.variance.item(episode, agent, step) ** 0.5
            heading = slam.heading.item(episode, agent, step) if self.scenario.turns else None
        return view_of(arrays, (cell, step, budget, mates, base_age, pose_std, heading))

    def _show(self, episode: int, agent: int) -> Arrays:
        """Return the arrays of an agent's views, none of which leads to the arrays of the batch by its ``base``."""
        owners = [(name, self.slam if kind.uncertain else self.state) for name, kind in LIVE_ARRAYS.items()]
        self._shown[episode, agent] = shown = tuple(
            None if owner is None else read_only(getattr(owner, name)[episode, agent]) for name, owner in owners
        )
        return shown

    def briefing(self, episode: int, agent: int, *, privileged: bool = False) -> Briefing:
        """Return the briefing of one agent's pilot."""
        return Briefing(
            agent=agent,
            team=self.scenario.team,
            shape=self.state.truth.shape[1:],
            lidar_range=self.scenario.lidar.range,
            scenario=self.scenario if privileged else self._briefed_scenario,
            rng=generator(self.seeds[episode], Stream.PILOT, agent),
            truth=read_only(self.state.truth[episode]) if privileged else None,
            starts=tuple((row, col) for row, col in self.state.cell[episode].tolist()) if privileged else None,
            level_count=self.scenario.map.level_count,
            base=tuple(self.state.base_cell[episode].tolist()) if self.scenario.base.exists else None,
            prior=self.prior(episode),
        )

    @property
    def flying(self) -> Mask:
        """(B, N) agents that have not ended."""
        return np.asarray(self.state.end == FLYING)

    @property
    def team_coverage(self) -> NDArray[np.float64]:
        """(B,) coverage of the union of the team's maps, as a share of the denominator."""
        return np.asarray(self.state.team_covered / self.state.total)

    def claimed_coverage(self, episode: int) -> float:
        """Return the coverage that the team's map claims: what it would be if all that the map shows were right."""
        known = (self.state.union[episode] != UNKNOWN) & self.state.counts[episode]
        return float(known.sum() / self.state.total[episode])

    @property
    def counted_coverage(self) -> NDArray[np.float64]:
        """(B,) coverage that counts for the goal: the base's if UAVs must return, else the team's."""
        return self.base_coverage if self.scenario.base.must_return else self.team_coverage

    @property
    def base_coverage(self) -> NDArray[np.float64]:
        """(B,) coverage of the home base's map, as a share of the denominator; 0 without a base."""
        return np.asarray(self.state.base_covered / self.state.total)

    @property
    def coverage(self) -> NDArray[np.float64]:
        """(B, N) coverage of each agent's map, as a share of the denominator."""
        return np.asarray(self.state.covered / self.state.total[:, None])

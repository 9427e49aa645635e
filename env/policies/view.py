"""All knowledge of one UAV: the briefing before an episode and the view at each step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from operator import itemgetter
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Belief, Cell, Mask
from indoor_explorers.env.grid.levels import Levels

if TYPE_CHECKING:
    from indoor_explorers.env.maps.sources import MapSource
    from indoor_explorers.env.scenarios.scenario import Scenario

#: A message to the teammates in radio range: None, or a few numbers.
Message = tuple[float, ...] | None
#: The most numbers one message may hold.
MESSAGE_LIMIT = 16


def message_numbers(message: Message) -> Message:
    """Return a message as Python floats, None for no message.

    Raises:
        InputError: there are too many.
        ValueError: they are no numbers; or TypeError.

    """
    if message is None:
        return None
    if len(message) > MESSAGE_LIMIT:
        raise InputError(f"expected a message of at most {MESSAGE_LIMIT} numbers, got {len(message)}")
    numbers = np.empty(len(message))
    numbers[:] = message
    return tuple(numbers.tolist())


class Mate(NamedTuple):
    """The last message and position received from one teammate."""

    agent: int
    """Number of the teammate, 0 to team - 1."""
    cell: Cell
    """Its last received cell (row, column)."""
    age: int
    """Steps since then; 0 while linked."""
    message: Message
    """Its last received message."""


@dataclass(frozen=True)
class LiveArray:
    """Annotation of a field of :class:`View` that is one of the world's arrays.

    Such fields reach the process of an isolated policy through shared memory, all others as plain values.
    """

    dtype: type[np.generic]
    of: Literal["map", "moves"] = "map"
    """Its shape: (H, W), or (A,), one for each move and ``STAY``."""
    uncertain: bool = False
    """Whether the field is None where maps are certain."""

    def shape_on(self, shape: tuple[int, int], moves: int = 5) -> tuple[int, ...]:
        """Return the field's shape on an (H, W) map; ``moves`` is that of its levels."""
        return shape if self.of == "map" else (moves,)


class View(NamedTuple):
    """The knowledge of one UAV at a step.

    Sharing views with other processes and comparing them follows from the declarations of this class.
    """

    belief: Annotated[Belief, LiveArray(np.uint8)]
    """(H, W) uint8, 0 unknown, 1 free, 2 occupied. Read-only and live: copy it to keep it. Where there are levels, the
    plane of them; ``briefing.levels.volume(view.belief)`` is (L, H, W)."""
    cell: Cell
    """The UAV's own (row, column); ``briefing.levels.voxel(view.cell)`` is (level, row, column)."""
    legal: Annotated[Mask, LiveArray(np.bool_, "moves")]
    """(5,) bool: actions that end neither in a wall nor off the map; (7,) where there are levels. A teammate may still
    be in the way."""
    step: int
    """Steps flown so far."""
    budget: int
    """Steps of the whole episode."""
    mates: tuple[Mate, ...]
    """All teammates heard so far, by number."""
    visited: Annotated[Mask, LiveArray(np.bool_)]
    """(H, W) bool: cells the UAV itself has been in, its own included. Read-only and live."""
    base_age: int | None = None
    """Steps since the last contact with the home base, directly or through teammates; None for never, or no base."""
    log_odds: Annotated[NDArray[np.float32] | None, LiveArray(np.float32, uncertain=True)] = None
    """(H, W) log-odds that each cell is occupied, 0 without evidence; ``belief`` shows the more probable. Read-only and
    live. None where maps are certain."""
    pose_std: float = 0.0
    """Standard deviation of the error that ``cell`` is expected to have, in cells; 0 where poses are certain."""
    heading: int | None = None
    """The action whose direction the UAV faces, 0 to 3; None where the lidar sees all around. Where it is not None,
    action 5 turns the UAV by 90 degrees."""

    @property
    def occupancy(self) -> NDArray[np.float64]:
        """(H, W) probability that each cell is occupied: .5 for unknown ones, and 0 or 1 where maps are certain."""
        if self.log_odds is None:
            return np.array((0.5, 0.0, 1.0))[self.belief]
        return np.asarray(1.0 / (1.0 + np.exp(-self.log_odds.astype(np.float64))))


def _live_arrays() -> dict[str, LiveArray]:
    hints = get_type_hints(View, include_extras=True)
    marks = {name: getattr(hints[name], "__metadata__", (None,))[0] for name in View._fields}
    return {name: mark for name, mark in marks.items() if isinstance(mark, LiveArray)}


#: The fields of a view that are arrays, and the others, in the order of the fields.
LIVE_ARRAYS: Final = _live_arrays()
PLAIN_FIELDS: Final = tuple(name for name in View._fields if name not in LIVE_ARRAYS)

#: The arrays of a view as a tuple, in the order of LIVE_ARRAYS; None for an absent one.
Arrays = tuple[NDArray[Any] | None, ...]
#: Returns the arrays of a view.
arrays_of: Callable[[View], Arrays] = itemgetter(*map(View._fields.index, LIVE_ARRAYS))
#: Returns the other fields of a view, in the order of PLAIN_FIELDS.
values_of: Callable[[View], tuple[Any, ...]] = itemgetter(*map(View._fields.index, PLAIN_FIELDS))

_in_order: Callable[[tuple[Any, ...]], Any] = itemgetter(*map((*LIVE_ARRAYS, *PLAIN_FIELDS).index, View._fields))
_made: Any = tuple.__new__  # what View's constructor calls, in half its time


def view_of(arrays: Arrays, values: tuple[Any, ...]) -> View:
    """Return the view that has these arrays and these values: the inverse of ``arrays_of`` and ``values_of``."""
    view: View = _made(View, _in_order(arrays + values))
    return view


@dataclass(frozen=True, kw_only=True)
class Briefing:
    """The knowledge of one UAV's pilot before the episode."""

    agent: int
    """The UAV's own number, 0 to team - 1."""
    team: int
    """UAVs in the team."""
    shape: tuple[int, int]
    """(H, W) of the map in cells; with several levels, of their plane."""
    lidar_range: float
    """Lidar range in cells."""
    scenario: Scenario
    """The whole task with the goal coverage; the names of map files and the listed failures are included for privileged
    policies alone."""
    rng: np.random.Generator = field(repr=False)
    """The pilot's own random generator."""
    truth: Belief | None = field(default=None, repr=False)
    """The true map (H, W) uint8, for privileged policies; None for other policies."""
    starts: tuple[Cell, ...] | None = field(default=None, repr=False)
    """Where all UAVs start, by number, for privileged policies; None for other policies."""
    base: Cell | None = None
    """The home base's (row, column); None where there is none."""
    level_count: int = 1
    """Levels of the map; 1 for a plain map."""
    prior: Belief | None = field(default=None, repr=False)
    """The prior map (H, W) uint8, 1 free, 2 occupied, read-only; it may be wrong. None where there is none."""

    @property
    def levels(self) -> Levels:
        """What is where on a map of several levels."""
        return Levels.of(self.shape, self.level_count)

    @property
    def rise(self) -> int:
        """Rows from a cell to the one a level higher; 0 where there is one level."""
        return self.levels.rise

    @property
    def generator(self) -> MapSource | None:
        """The settings of the random generator that draws the maps; None if maps come from files.

        Any policy may read them: they describe the distribution of maps, such as the number of obstacles in a room, and
        never the map of the episode. A policy that reads them must declare
        :attr:`~indoor_explorers.env.policies.policy.Policy.uses_generator`. Other policies must not depend on the
        source of the maps, ``scenario.map`` included.
        """
        return self.scenario.map if self.scenario.map.generated else None

"""The training maps of ``places`` and ``pockets``: generated maps, and real floors turned, scaled and cut at random."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BeforeValidator, Field
from scipy import ndimage

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.files import expanded
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.env.maps.base import GeneratedMaps
from indoor_explorers.env.maps.files import read_map
from indoor_explorers.env.maps.floorplan import Floorplan
from indoor_explorers.env.maps.generators.cave import CaveMaps
from indoor_explorers.env.maps.generators.floors.plans import FloorsMaps
from indoor_explorers.env.maps.generators.halls import HallsMaps
from indoor_explorers.env.maps.generators.homes import HomesMaps
from indoor_explorers.env.maps.generators.interiors import InteriorsMaps
from indoor_explorers.env.maps.generators.maze import MazeMaps
from indoor_explorers.env.maps.generators.offices import OfficesMaps
from indoor_explorers.env.maps.generators.racks import RacksMaps
from indoor_explorers.env.maps.generators.rooms import RoomsMaps
from indoor_explorers.env.maps.generators.storeys import StoreysMaps
from indoor_explorers.env.maps.reduction import Source, reduced
from indoor_explorers.env.maps.sources import FileMaps
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.scenarios.seed_sets import SeedUse
from indoor_explorers.env.scenarios.suites.catalogue import suite_of
from indoor_explorers.env.scenarios.suites.clones import maps_of
from indoor_explorers.env.scenarios.suites.suite import Part, Repository, SuiteMap
from indoor_explorers.env.search.connected_parts import largest_part
from indoor_explorers.learners.sessions.record import TrainingRecord, new_record
from indoor_explorers.learners.sessions.settings import LearnerSettings

#: Folder of the flights inside that of a training.
FLIGHTS = "flights"
#: Name of generated maps.
GENERATED = "generated"
#: Share of generated maps that are floors; the others are offices, rooms, caves and mazes.
FLOORS = 0.6
#: Share of maps turned by any angle instead of quarter turns, and of maps cut to a part.
TURNED, CUT = 0.33, 0.3
#: Smallest and largest factor on the size of a cell, for map files.
SCALES = (0.75, 1.4)
#: Share of generated maps with ragged walls, and the largest share of wall and border cells that change.
RAGGED, RAGGEDNESS = 0.4, 0.15
#: Least free cells of a training map, and side of a cell in metres.
LEAST_FREE, METRES = 150, 0.5
#: Attempts to find a map of that size.
ATTEMPTS = 20


@dataclass(frozen=True)
class TrainingMaps:
    """The source of training maps: a map file, varied at random, or a generator with random settings."""

    paths: tuple[str, ...] = ()
    """Map files with a scale, or pictures of 4 pixels a cell."""
    real: float = 0.6
    """Share of maps from files, if there are any."""
    number: int = 0
    """Different maps; 0: every map is new."""
    left_out: frozenset[str] = frozenset()
    """Those of the files that generated maps take the place of; what is drawn instead of others stays the same."""
    levels: float = 0.0
    """Share of generated buildings of several levels."""
    halls: float = 0.0
    """Share of the other generated maps that are halls or homes."""

    def draw(self, rng: np.random.Generator) -> Floorplan:
        """Return a map; its name is ``GENERATED`` or that of its file.

        Raises :class:`InputError` where no attempt finds one that is large enough.
        """
        if self.number:
            rng = np.random.default_rng([int(rng.integers(self.number)), 13])
        for _ in range(ATTEMPTS):
            plan = self._attempt(rng)
            if plan is not None and np.count_nonzero(plan.truth == FREE) >= LEAST_FREE:
                return plan
        raise InputError(
            f"expected training maps of at least {LEAST_FREE} free cells, got none in {ATTEMPTS} attempts; add larger "
            "ones"
        )

    def _attempt(self, rng: np.random.Generator) -> Floorplan | None:
        if self.levels and rng.random() < self.levels:
            return Floorplan.from_free(random_building(rng).draw(rng), GENERATED)
        if self.paths and rng.random() < self.real:
            path = self.paths[rng.integers(len(self.paths))]
            if path not in self.left_out:
                return varied(path, rng)
        other = self.halls > 0.0 and rng.random() < self.halls
        free = (random_open_plan(rng) if other else random_generator(rng)).draw(rng)
        if rng.random() < RAGGED:
            free = ragged(free, rng.uniform(0.0, RAGGEDNESS), rng)
        return Floorplan.from_free(turned(free, rng), GENERATED)


def random_generator(rng: np.random.Generator) -> GeneratedMaps:
    """Return a generator with random settings."""
    if rng.random() < FLOORS:
        return FloorsMaps()
    sides = {"height": int(rng.integers(30, 110)), "width": int(rng.integers(30, 110))}
    depth, width = int(rng.integers(4, 9)), int(rng.integers(4, 9))
    kinds: list[GeneratedMaps] = [
        OfficesMaps(
            **sides,
            corridor=int(rng.integers(2, 6)),
            room_depth=(depth, depth + int(rng.integers(1, 8))),
            room_width=(width, width + int(rng.integers(1, 10))),
            links=float(rng.uniform(0.0, 0.5)),
            furniture=float(rng.uniform(0.0, 0.25)),
        ),
        RoomsMaps(**sides, room_size=(depth, depth + int(rng.integers(1, 9))), corridor=int(rng.integers(1, 4))),
        CaveMaps(**sides),
        MazeMaps(**{name: min(side, 60) for name, side in sides.items()}, corridor=int(rng.integers(1, 4))),
    ]
    return kinds[rng.choice(4, p=(0.4, 0.3, 0.2, 0.1))]


def random_open_plan(rng: np.random.Generator) -> GeneratedMaps:
    """Return a generator of halls or of homes, in equal shares, with random settings."""
    sides = {"height": int(rng.integers(20, 80)), "width": int(rng.integers(20, 80))}
    if rng.random() < 0.5:
        return HallsMaps(**sides, side_rooms=float(rng.uniform(0.0, 0.8)), furniture=float(rng.uniform(0.0, 0.15)))
    rooms = int(rng.integers(3, 7))
    return HomesMaps(
        **sides,
        room_size=(rooms, 2 * rooms + int(rng.integers(0, 8))),
        door=int(rng.integers(1, 4)),
        loops=float(rng.uniform(0.0, 0.4)),
        wide=float(rng.uniform(0.0, 0.5)),
        furniture=float(rng.uniform(0.0, 0.25)),
    )


@lru_cache(maxsize=256)
def _pixels(path: str) -> tuple[Mask, float]:
    """Return the free pixels of a map file, (H, W) bool, and metres a pixel."""
    plan = read_map(Path(path))
    return plan.truth == FREE, METRES / 4.0 if plan.resolution in (None, 1.0) else plan.resolution


def random_building(rng: np.random.Generator) -> GeneratedMaps:
    """Return a generator of buildings of several levels with random settings."""
    sides = {"height": int(rng.integers(16, 31)), "width": int(rng.integers(16, 31))}
    room, storeys = int(rng.integers(3, 5)), int(rng.integers(1, 4))
    rooms = {"room_size": (room, room + int(rng.integers(2, 6))), "corridor": int(rng.integers(1, 3))}
    kinds: list[GeneratedMaps] = [
        StoreysMaps(
            **sides, **rooms, storeys=storeys + 1, storey_height=int(rng.integers(2, 5)), hall_size=(3, 7),
            openings=int(rng.integers(1, 4)), halls=int(rng.integers(3)), furniture=float(rng.uniform(0.0, 0.15)),
        ),
        InteriorsMaps(
            **sides, **rooms, storeys=storeys, storey_height=int(rng.integers(4, 7)), halls=int(rng.integers(2)),
            wells=int(rng.integers(3)), hatches=int(rng.integers(1, 3)), crawl_spaces=int(rng.integers(3)),
            furniture=float(rng.uniform(0.0, 0.25)),
        ),
        RacksMaps(**sides, levels=int(rng.integers(5, 11)), goods=float(rng.uniform(0.3, 0.9))),
    ]  # fmt: skip
    return kinds[rng.choice(3, p=(0.5, 0.3, 0.2))]


def varied(path: str, rng: np.random.Generator) -> Floorplan | None:
    """Return the map of a file, turned, mirrored, scaled and cut at random; None if too little is left."""
    free, metres = _pixels(path)
    free = turned(free, rng)
    if rng.random() < CUT:
        free = cut(free, rng)
    cells = np.where(free, FREE, OCCUPIED).astype(np.uint8)
    try:
        return reduced(Source(name=Path(path).stem, where=path, cells=cells, resolution=metres), METRES * scale(rng))
    except InputError:
        return None


def scale(rng: np.random.Generator) -> float:
    """Return a random factor for the size of a cell, mostly 1."""
    return 1.0 if rng.random() < 0.5 else float(rng.uniform(*SCALES))


def turned(free: Mask, rng: np.random.Generator) -> Mask:
    """Return a (H, W) map turned by quarters or any angle, and perhaps mirrored."""
    free = np.rot90(free, int(rng.integers(4)))
    if rng.random() < 0.5:
        free = free[:, ::-1]
    if rng.random() < TURNED:
        free = ndimage.rotate(free.astype(np.uint8), rng.uniform(0.0, 90.0), order=0, cval=0).astype(bool)
    return largest_part(np.pad(np.ascontiguousarray(free), 1))


def cut(free: Mask, rng: np.random.Generator) -> Mask:
    """Return the largest connected part of a random window of a map (H, W) bool."""
    sides = [int(side * rng.uniform(0.4, 1.0)) for side in free.shape]
    row, col = (int(rng.integers(whole - side + 1)) for whole, side in zip(free.shape, sides, strict=True))
    return largest_part(np.pad(free[row : row + sides[0], col : col + sides[1]], 1))


def ragged(free: Mask, share: float, rng: np.random.Generator) -> Mask:
    """Return a map (H, W) bool with a share of the cells on both sides of its walls changed, as in robots' maps."""
    edge = ndimage.binary_dilation(free) & ndimage.binary_dilation(~free)
    edge[[0, -1]] = edge[:, [0, -1]] = False
    return largest_part(free ^ (edge & (rng.random(free.shape) < share)))


def map_files(suite: str, part: Part, data: Sequence[Path]) -> FileMaps:
    """Return the map files of a part of a suite, from clones in the folders ``data``.

    Raises :class:`InputError` where files are missing, or the suite generates its maps.
    """
    named = suite_of(suite)
    maps = None if named.generated else maps_of(named, part, data)
    if not isinstance(maps, FileMaps):
        raise InputError(f"expected suites of map files, got {suite!r}: generated maps are learned from without it")
    return maps


#: One name, or several.
Names = Annotated[tuple[str, ...], BeforeValidator(lambda value: (value,) if isinstance(value, str) else value)]


class MapSettings(LearnerSettings):
    """The settings of a training that draws its maps, and the task of each flight, itself."""

    suites: Names = ()
    """Suites whose train parts to learn from, besides generated maps."""
    data: Names = Field((), exclude=True)
    """Folders with clones of the repositories of the suites; not part of the record."""
    left_out: Names = ()
    """Repositories of these suites whose maps to leave out, such as ``amrl_maps``; generated maps take their place."""
    halls: float = Field(0.0, ge=0.0, le=1.0)
    """Share of generated maps of one level that are halls, with or without columns, desks or racks, or homes."""
    map_count: int = Field(0, ge=0)
    """Different maps in the training; 0: each flight draws a new one."""

    @property
    def folders(self) -> list[Path]:
        """The folders of ``data``."""
        return [expanded(folder) for folder in self.data]

    def maps(self) -> TrainingMaps:
        """Return the training maps.

        Raises :class:`InputError` where files are missing, a suite generates its maps, or none has what to leave out.
        """
        paths = [path for name in self.suites for path in map_files(name, Part.TRAIN, self.folders).paths]
        left_out = self._left_out(paths)
        return TrainingMaps(tuple(paths), number=self.map_count, left_out=left_out, halls=self.halls)

    def _left_out(self, paths: Sequence[str]) -> frozenset[str]:
        homes = [home.name for home, _ in self._listed()] if self.left_out else []
        for name in self.left_out:
            if name not in homes:
                known = f"repositories of {', '.join(self.suites)}"
                raise InputError(f"expected {known} to leave out, got {name!r}{did_you_mean(name, homes)}")
        return frozenset(path for path, home in zip(paths, homes, strict=bool(homes)) if home in self.left_out)

    def seen_maps(self) -> tuple[str, ...]:
        """Return what is learned from: parts of suites, or the digests of maps and layouts where some are left out."""
        if not self.left_out:
            return tuple(f"{name}/{Part.TRAIN}" for name in self.suites)
        seen = (each for home, each in self._listed() if home.name not in self.left_out)
        return tuple(dict.fromkeys(digest for each in seen for digest in (each.digest, each.layout)))

    def _listed(self) -> Iterator[tuple[Repository, SuiteMap]]:
        return (each for name in self.suites for each in suite_of(name).maps(Part.TRAIN))


def map_record(learner: str, config: MapSettings, scenario: Scenario | None, seed: int) -> TrainingRecord:
    """Return the record of a new training that draws its maps itself.

    Raises :class:`InputError` where a scenario is given, or :meth:`MapSettings.maps` does.
    """
    if scenario is not None:
        raise InputError(f"learner {learner!r} draws its own maps and tasks, got scenario {scenario.name!r}; give none")
    config.maps()
    record = new_record(learner, config, None, seed, ("scipy",))
    seen = config.seen_maps()
    return record.model_copy(update={"seen_maps": {SeedUse.TRAINING: seen} if seen else {}})

"""A suite: a fixed, versioned list of tasks in up to three parts that share no building, no map and no seed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from enum import StrEnum
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from indoor_explorers.env.maps.base import BaseMaps
from indoor_explorers.env.maps.sources import FileMaps, MapSource
from indoor_explorers.env.scenarios.parts import Radio
from indoor_explorers.env.scenarios.presets import on_maps, scenario
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.scenarios.seed_sets import SeedSet, seed_set

#: The radio of one UAV, by the ending of the scenario's name.
ALONE = {"": Radio()}


class Part(StrEnum):
    """The use of a part's tasks."""

    TRAIN = "train"
    """Training."""
    VALIDATION = "validation"
    """Choices among weights and settings."""
    TEST = "test"
    """Published figures."""


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class SuiteMap(_Table):
    """A map file of a public repository."""

    part: Part
    building: str
    """Maps of one building are similar: they are in one part, and count as one cluster in confidence intervals."""
    cells: int
    """Free cells at the resolution of the suite."""
    digest: str
    """Digest of the map, see :attr:`~indoor_explorers.env.maps.floorplan.Floorplan.digest`."""
    layout: str
    """Digest of the layout, see :attr:`~indoor_explorers.env.maps.floorplan.Floorplan.layout`."""
    files: dict[str, str] = Field(min_length=1)
    """SHA-256 by path in the repository's folder; the first file is read as a map, and names the others."""

    @property
    def path(self) -> str:
        """The file that is read as a map."""
        return next(iter(self.files))

    @property
    def name(self) -> str:
        """The name of that file up to its first dot."""
        return self.path.rpartition("/")[2].partition(".")[0]


class Repository(_Table):
    """A public repository, and the maps of it that a suite flies."""

    url: str
    commit: str
    licence: str
    """Licence of the maps, as far as the repository states it."""
    folder: str = ""
    """The folder in it that paths are relative to, with a slash at its end; empty for the repository's own."""
    maps: tuple[SuiteMap, ...]

    @property
    def name(self) -> str:
        """The name of the folder that ``git clone`` makes."""
        return self.url.rpartition("/")[2]


class GeneratedPart(_Table):
    """The maps of a part that a generator makes, one for each seed of the part's range."""

    maps: int = Field(ge=1)
    """Number of maps."""
    digest: str = ""
    """:func:`digest_of` the maps, which detects a changed generator; empty where each scenario has its own."""


class ListedScenario(_Table):
    """A scenario of a suite whose scenarios differ in more than team and radio."""

    preset: str
    """The scenario that it is a variant of."""
    settings: dict[str, Any] = {}
    """Changed settings of that scenario, by dotted keys."""
    digests: dict[Part, str]
    """:func:`digest_of` the maps of each part, which detects a changed generator."""

    def named(self, name: str) -> Scenario:
        """Return the scenario as comparisons fly it."""
        changed = scenario(self.preset).for_evaluation().with_settings(self.settings)
        return changed.model_copy(update={"name": name})


class Suite(_Table):
    """A suite, as its TOML file describes it; its files, or its generator, make the maps."""

    name: str
    version: int = Field(ge=1)
    """A suite never changes: with any other task it is another version."""
    about: str
    """Description of the maps, in a line."""
    split: str
    """Description of the division into parts, in a line."""
    preset: str | None = None
    """The scenario that the tasks are variants of; None: the default scenario of map files."""
    settings: dict[str, Any] = {}
    """Changed settings of that scenario, by dotted keys."""
    teams: tuple[int, ...] = (1, 2, 4)
    """Numbers of UAVs."""
    radios: dict[str, Radio] = {}
    """Radios of teams by name; one UAV flies without."""
    starts: int = Field(1, ge=1)
    """Seeds flown on each map."""
    resolution: float | None = None
    """Metres a cell of maps from files; pixels where the files have no scale."""
    levels: dict[Part, int] = {}
    """Levels of the tallest file of each part with several, so that maps flown alone fly as they do together."""
    repositories: tuple[Repository, ...] = ()
    map: Annotated[MapSource, Field(discriminator="source")] | None = None
    """The generator; None where maps are files."""
    listed: dict[str, ListedScenario] = Field({}, alias="scenarios")
    """The scenarios by the end of their names, where they are not variants of one, each with maps of its own."""
    parts: dict[Part, GeneratedPart] = {}
    """The generated maps by part, of each scenario where these are listed."""

    @model_validator(mode="after")
    def _has_maps(self) -> Self:
        if sum(map(bool, (self.repositories, self.map, self.listed))) != 1:
            raise ValueError(f"suite {self.name!r} needs one of map files of repositories, a generator, and scenarios")
        return self

    @property
    def generated(self) -> bool:
        """Whether the maps are made from seeds."""
        return not self.repositories

    @property
    def title(self) -> str:
        """Name and version, such as ``floors 1``."""
        return f"{self.name} {self.version}"

    def maps(self, part: Part) -> Iterator[tuple[Repository, SuiteMap]]:
        """Yield the map files of a part, in the order of map indices; none where maps are generated."""
        return ((home, each) for home in self.repositories for each in home.maps if each.part is part)

    def has(self, part: Part) -> bool:
        """Return whether a part has maps; a suite for a final test has none to train or validate on."""
        return part in self.parts if self.generated else any(self.maps(part))

    def map_count(self, part: Part) -> int:
        """Return the number of maps of a part, of each scenario where these are listed."""
        return self.parts[part].maps if part in self.parts else sum(1 for _ in self.maps(part))

    def buildings(self, part: Part) -> set[str]:
        """Return the buildings of a part; none where maps are generated."""
        return {each.building for _, each in self.maps(part)}

    def seeds(self, part: Part) -> range:
        """Return the seeds that are flown on each map, or those of the generated maps."""
        first = seeds_of(part).first
        return range(first, first + (self.map_count(part) if self.generated else self.starts))

    def task_count(self, part: Part) -> int:
        """Return the number of tasks of a part: scenarios x maps x starts."""
        return len(self.scenarios()) * len(self.seeds(part)) * (1 if self.generated else self.map_count(part))

    def scenarios(
        self, maps: MapSource | None = None, teams: Iterable[int] | None = None, radios: Iterable[str] | None = None
    ) -> list[Scenario]:
        """Return the scenarios as comparisons fly them, all of them or those of some teams and radios.

        Args:
            maps: The source of maps; None for the generators, or for a placeholder of map files.
            teams: Numbers of UAVs.
            radios: Names of radios; scenarios of one UAV and listed ones have none.

        """
        if self.listed:
            made = [each.named(f"{self.name}-{name}") for name, each in self.listed.items()]
            return [each for each in made if teams is None or each.team in teams]
        source = maps or self.map or FileMaps(paths=(self.name,), resolution=self.resolution)
        base = on_maps(self.name, source) if self.preset is None else scenario(self.preset)
        task = base.model_copy(update={"map": source}).for_evaluation().with_settings(self.settings)
        chosen = [team for team in self.teams if teams is None or team in teams]
        linked = {name: radio for name, radio in self.radios.items() if radios is None or name in radios}
        return [
            task.model_copy(update={"name": f"{self.name}-{team}{suffix}", "team": team, "radio": radio})
            for team in chosen
            for suffix, radio in ({f"-{name}": radio for name, radio in linked.items()} if team > 1 else ALONE).items()
        ]


def seeds_of(part: Part) -> SeedSet:
    """Return the range that the seeds of a part are from, the same for all suites."""
    return seed_set(f"suites-{part}")


def digest_of(maps: BaseMaps, seeds: Iterable[int]) -> str:
    """Return a short hash of the maps that a generator makes of some seeds."""
    joined = "".join(maps.floorplan(0, seed).digest for seed in seeds)
    return hashlib.sha256(joined.encode()).hexdigest()[:16]

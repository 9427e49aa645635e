"""A scenario: one frozen, validated description of a task."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, Literal

from pydantic import Field, ValidationError, ValidatorFunctionWrapHandler, field_validator, model_validator

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.grid.levels import Voxel
from indoor_explorers.env.maps.sources import AnyMaps, ThesisMaps, map_class
from indoor_explorers.env.plugins import source_hash
from indoor_explorers.env.scenarios.parts import (
    Base,
    Drift,
    Failures,
    Lidar,
    Noise,
    Prior,
    Radio,
    Rewards,
    SettingsGroup,
    Stuck,
)
from indoor_explorers.env.scenarios.validation import validated

#: The least number of steps of an episode without a given budget.
LEAST_BUDGET = 200
#: Settings of comparisons: episodes go on to full team coverage or the budget, and no UAV is ended as stuck.
COMPARED: Mapping[str, Any] = {"goal": 1.0, "goal_of": "team", "denominator": "reachable", "stuck.rule": "off"}
#: Settings that were added later; fingerprints include them only if they are not at their defaults.
LATER = ("failures", "base", "prior", "noise", "drift", "lidar.field_of_view", "lidar.elevation")
#: Radio models that reach from level to level.
LEVEL_RADIOS = ("none", "square", "disc", "unlimited")


class Scenario(SettingsGroup):
    """Describe one task completely; equal scenarios have equal fingerprints."""

    name: str = Field("custom", min_length=1, max_length=80)
    """Name in tables and figures."""
    map: AnyMaps = ThesisMaps()
    """The source of maps; ``source`` may be a plug-in, ``module:Class``."""
    team: int = Field(1, ge=1, le=256)
    """UAVs."""
    spawn: Literal["random", "clustered"] | tuple[tuple[int, int], ...] | tuple[Voxel, ...] = "random"
    """Start cells: random, clustered (adjacent, at the map's start mark if any), or listed as (row, column) or, with
    several levels, (level, row, column)."""
    lidar: Lidar = Lidar()
    radio: Radio = Radio()
    rewards: Rewards = Rewards()
    stuck: Stuck = Stuck()
    failures: Failures = Failures()
    base: Base = Base()
    prior: Prior = Prior()
    noise: Noise = Noise()
    drift: Drift = Drift()
    on_collision: Literal["end", "block"] = "end"
    """Effect of a move into an obstacle or off the map: it ends the agent (the thesis) or costs the step."""
    goal: float = Field(0.9, gt=0.0, le=1.0)
    """Coverage that ends the episode, as a share of the denominator."""
    goal_of: Literal["agent", "team", "every"] = "agent"
    """Whose coverage: ``agent``: each agent's own map, which ends that agent (the thesis); ``team``: the team's union;
    ``every``: the own maps of all that fly, until the last of them has it. The last two reward every agent."""
    denominator: Literal["reachable", "map"] = "reachable"
    """Coverage counts free cells reachable from the spawns, or all cells of the map (the thesis)."""
    budget: int | None = Field(None, ge=1, le=10_000_000)
    """Steps after which the episode is truncated; None: one for each reachable cell of the map, at least 200."""

    @field_validator("spawn", mode="wrap")
    @classmethod
    def _places(cls, value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
        try:
            return handler(value)
        except ValidationError as error:
            raise ValueError("expected random, clustered, or a list of a [row, column] cell for each UAV") from error

    @model_validator(mode="after")
    def _consistent(self) -> Scenario:
        if isinstance(self.spawn, tuple) and len(self.spawn) != self.team:
            raise ValueError(f"spawn lists {len(self.spawn)} cells for a team of {self.team}; list one for each UAV")
        if self.stuck.repeats > self.stuck.window:
            raise ValueError(
                f"stuck.repeats is {self.stuck.repeats}, more than stuck.window {self.stuck.window}; lower it"
            )
        agents = [agent for agent, _ in self.failures.stops]
        if len(set(agents)) < len(agents) or any(not 0 <= agent < self.team for agent in agents):
            raise ValueError(f"failures.stops is about UAVs {agents}; list each once, from 0 to {self.team - 1}")
        if any(step < 1 for _, step in self.failures.stops):
            raise ValueError("failures.stops has a step before the first one; steps count from 1")
        if self.base.must_return and not self.base.exists:
            raise ValueError("base.must_return needs a base; set base.at = 'start', or a [row, column]")
        if self.uncertain and (self.lidar.custom is not None or self.radio.custom is not None):
            raise ValueError(
                "noise, drift and a limited lidar.field_of_view need a lidar and a radio model of this package, "
                f"got {self.lidar.model} and {self.radio.model}"
            )
        if self.map.level_count > 1 and (first := next(self._without_levels(), None)):
            raise ValueError(f"maps of several levels need {first}")
        return self

    def _without_levels(self) -> Iterator[str]:
        """Yield what would have to be set for maps of several levels, and is not."""
        if self.lidar.model != "exact" or self.lidar.field_of_view < 360.0:
            yield f"lidar.model exact and lidar.field_of_view 360, got {self.lidar.model}, {self.lidar.field_of_view:g}"
        if self.radio.model not in LEVEL_RADIOS:
            yield f"radio.model {', '.join(LEVEL_RADIOS[:-1])} or {LEVEL_RADIOS[-1]}, got {self.radio.model}"
        if self.uncertain:
            yield "a world without noise and drift; remove them"
        if self.prior.kind != "none":
            yield f"prior.kind none, got {self.prior.kind}"
        if self.denominator != "reachable":
            yield f"denominator reachable, got {self.denominator}"
        if not isinstance(self.base.at, str):
            yield f"base.at start or none, got {list(self.base.at)}"

    @property
    def lidar_arguments(self) -> tuple[float, str, int, float]:
        """Range, model, levels and elevation, as :func:`~indoor_explorers.env.sensing.lidar.lidar_model` takes them."""
        return self.lidar.range, self.lidar.model, self.map.level_count, self.lidar.elevation

    @property
    def uncertain(self) -> bool:
        """Whether maps are of log-odds: sensors or poses err, or the field of view is limited."""
        return self.noise.any or self.drift.rate > 0.0 or self.turns

    @property
    def turns(self) -> bool:
        """Whether UAVs have a heading and the action ``turn``."""
        return self.lidar.field_of_view < 360.0

    @property
    def actions(self) -> int:
        """How many actions a UAV has: five, a sixth to turn where the field of view is limited; seven with levels."""
        return 7 if self.map.level_count > 1 else 6 if self.turns else 5

    @cached_property
    def fingerprint(self) -> str:
        """A short canonical hash of the task, without its name; map files count by their cells."""
        plugins = [part.custom for part in (self.lidar, self.radio) if part.custom is not None]
        facts = task_facts(self.model_dump(mode="json")) | {"map": self.map.identity()}
        return hashed(facts | ({"code": [source_hash(plugin) for plugin in plugins]} if plugins else {}))

    def budget_for(self, reachable: int) -> int:
        """Return the step budget on a map with ``reachable`` free cells."""
        return self.budget if self.budget is not None else max(LEAST_BUDGET, reachable)

    def for_evaluation(self) -> Scenario:
        """Return the task as comparisons fly it, with the settings of :data:`COMPARED`; a goal of every UAV stays."""
        kept = ("goal", "goal_of") if self.goal_of == "every" else ()
        return self.with_settings({key: value for key, value in COMPARED.items() if key not in kept})

    def with_settings(self, settings: Mapping[str, Any]) -> Scenario:
        """Return a copy with dotted keys replaced, such as ``{"lidar.range": 5, "team": 2}``.

        Another ``map.source`` brings its own settings, at their defaults where they are not replaced too.
        """
        data = self.model_dump()
        if settings.get("map.source", self.map.source) != self.map.source:  # another kind of map has other settings
            data["map"] = _defaults_of(settings["map.source"]) or data["map"]
        for key, value in settings.items():
            *parents, leaf = key.split(".")
            place: Any = data
            for depth, parent in enumerate(parents):
                if parent in place and not isinstance(place[parent], dict):
                    whole = ".".join(parents[: depth + 1])
                    raise InputError(f"no setting {key!r}, since {whole!r} is a single one; set that")
                if parent not in place:
                    known = [name for name, entry in place.items() if isinstance(entry, dict)]
                    raise InputError(f"no setting {'.'.join(parents[: depth + 1])!r}{did_you_mean(parent, known)}")
                place = place[parent]
            if leaf not in place:
                raise InputError(f"no setting {key!r}{did_you_mean(leaf, place, key.removesuffix(leaf))}")
            place[leaf] = value
        return validated(Scenario, data, "scenario")

    def to_toml(self) -> str:
        """Return the scenario as TOML; :func:`~indoor_explorers.env.scenarios.loading.load_scenario` reads it back."""
        import tomli_w

        return tomli_w.dumps(self.model_dump(mode="json", exclude_none=True))


def task_facts(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a task as JSON, without its maps and without those of :data:`LATER` at their defaults.

    So equal settings give the same facts in all versions.
    """
    facts = {key: value for key, value in settings.items() if key not in ("name", "fingerprint", "map")}
    for part, _, setting in (name.partition(".") for name in LATER):
        default = Scenario.model_fields[part].default.model_dump(mode="json")
        if setting and part in facts and facts[part].get(setting) == default[setting]:
            facts[part] = {key: value for key, value in facts[part].items() if key != setting}
        elif facts.get(part) == default:
            del facts[part]
    return facts


def hashed(facts: Mapping[str, Any]) -> str:
    """Return the fingerprint of a task's facts: its :func:`task_facts`, the identity of its maps, and code."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]


def _defaults_of(source: str) -> dict[str, Any]:
    """Return the default settings of a source of maps, None for required ones; empty for an unknown source."""
    kind = map_class(source)
    fields = {} if kind is None else kind.model_fields
    return {name: None if field.is_required() else field.get_default() for name, field in fields.items()}

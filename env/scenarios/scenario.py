"""A scenario: one frozen, validated description of a task."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidatorFunctionWrapHandler,
    field_validator,
    model_validator,
)

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.maps.sources import AnyMaps, ThesisMaps, map_class
from indoor_explorers.env.plugins import LIDARS, RADIOS, load_plugin, source_hash
from indoor_explorers.env.scenarios.codes import LIDAR_MODELS, RADIO_MODELS, StuckRuleName
from indoor_explorers.env.scenarios.validation import validated

#: Steps that an episode without a budget has at least.
LEAST_BUDGET = 200
#: Settings of comparisons: episodes go on to full team coverage or the budget, and no UAV is ended as stuck.
COMPARED: Mapping[str, Any] = {"goal": 1.0, "goal_of": "team", "denominator": "reachable", "stuck.rule": "off"}
#: Settings that older fingerprints do not know; they count where they are not at their defaults.
LATER = ("failures", "base", "prior", "noise", "drift", "lidar.field_of_view")


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


def _refuse_uncallable(plugin: Any, name: str) -> None:
    if plugin is not None and not callable(plugin):
        raise ValueError(f"{name}: expected a function, got {type(plugin).__name__}")


class Lidar(_Part):
    """The range sensor."""

    model: str = "exact"
    """``exact``: line of sight (:mod:`indoor_explorers.env.sensing.shadowcasting`); ``marsexplorer``: the ancestor's
    rays (:mod:`indoor_explorers.env.sensing.marsexplorer`); or a plug-in, ``module:function``."""
    range: float = Field(3.0, ge=1.0, le=200.0)
    """Range in cells, Euclidean to a cell's centre."""
    field_of_view: float = Field(360.0, ge=30.0, le=360.0)
    """Degrees that the lidar sees, half of them to each side of the UAV's heading; proximity sensors see the eight
    neighbours all around. Below 360 a UAV has a heading, the direction of its last move, and one action more: ``turn``,
    clockwise by 90 degrees. Maps are then of log-odds, as with ``noise`` and ``drift``."""

    @property
    def custom(self) -> Callable[..., Any] | None:
        """The function of a plug-in; None for a model of this package."""
        return None if self.model in LIDAR_MODELS else load_plugin(LIDARS, self.model, "lidar model", LIDAR_MODELS)

    @model_validator(mode="after")
    def _known(self) -> Lidar:
        _refuse_uncallable(self.custom, self.model)
        return self


class Radio(_Part):
    """Which UAVs are in radio contact; linked UAVs merge their maps and exchange positions and messages."""

    model: str = "none"
    """``none``; ``square``: Chebyshev distance at most ``range`` (the thesis); ``disc``: Euclidean; ``line-of-sight``:
    the same with no obstacle between; ``path-loss``: log-distance path loss with a loss for each wall between;
    ``unlimited``; or a plug-in, ``module:function``."""
    range: float = Field(0.0, ge=0.0)
    """Range in cells, in the open; not read by ``none`` and ``unlimited``."""
    exponent: float = Field(3.0, ge=1.0, le=10.0)
    """``path-loss``: the path loss exponent n, 2 in free space, about 3 indoors (Rappaport 2002, section 4.9)."""
    wall_loss: float = Field(6.0, ge=0.0, le=200.0)
    """``path-loss``: dB lost at each wall, a run of obstacle cells on the straight line between two UAVs. With w walls
    between, the range shrinks to ``range`` 10^(-w wall_loss / (10 n))."""
    loss: float = Field(0.0, ge=0.0, lt=1.0)
    """Probability that a contact fails in a step, drawn for each pair of UAVs and each step."""

    @property
    def custom(self) -> Callable[..., Any] | None:
        """The function of a plug-in; None for a model of this package."""
        return None if self.model in RADIO_MODELS else load_plugin(RADIOS, self.model, "radio model", RADIO_MODELS)

    @model_validator(mode="after")
    def _known(self) -> Radio:
        _refuse_uncallable(self.custom, self.model)
        return self


class Rewards(_Part):
    """The rewards of an agent; a step's reward is the sum of those that apply (thesis, Table 4.2, scenario 1)."""

    step: float = -0.5
    """Each step flown."""
    discovered: float = 1.0
    """Each cell that the agent first saw with its own lidar."""
    received: float = 0.0
    """Each cell that the agent first received by radio; the thesis rewarded these like discoveries."""
    collision: float = -400.0
    """A move into an obstacle."""
    out_of_bounds: float = -400.0
    """A move off the map."""
    stuck: float = -400.0
    """Being ended by the stuck rule."""
    goal: float = 400.0
    """Reaching the goal coverage."""


class Stuck(_Part):
    """When an agent without progress is ended."""

    rule: StuckRuleName = "off"
    """``no-discovery``: no new cell for H*W steps; ``oscillation``: one cell too often among the last positions."""
    window: int = Field(50, ge=2, le=10_000)
    """Number of last positions that ``oscillation`` considers."""
    repeats: int = Field(20, ge=2)
    """How often the most frequent of them must appear (the thesis's text: 20, its settings file: 10)."""


class Failures(_Part):
    """UAVs that stop, and radios that are silent for a while; none by default.

    A UAV that stops is gone, and what it alone knew is lost: coverage counts what the others know.
    """

    hazard: float = Field(0.0, ge=0.0, lt=1.0)
    """Probability that a UAV stops in a step, drawn for each UAV and step: it flies 1 / hazard steps on average."""
    stops: tuple[tuple[int, int], ...] = ()
    """Listed [UAV, step] pairs: that UAV stops in that step, the first of which is 1."""
    last_word: bool = False
    """Whether a UAV that stops still exchanges what it knows with those in contact; if not, it stops silently."""
    reward: float = 0.0
    """Reward of a UAV that stops."""
    radio_hazard: float = Field(0.0, ge=0.0, lt=1.0)
    """Probability that a working radio fails in a step, drawn for each UAV and step."""
    radio_outage: int = Field(20, ge=1)
    """Steps that a radio is silent then, this one included; it neither sends nor receives."""

    @property
    def any(self) -> bool:
        """Whether anything can fail."""
        return self.hazard > 0.0 or self.radio_hazard > 0.0 or bool(self.stops)


class Base(_Part):
    """The home base, where reports count; none by default.

    It has a radio like the UAVs' and stays where it is. UAVs in contact with it, directly or through teammates, report
    what they know and learn what others have reported.
    """

    at: Literal["none", "start"] | tuple[int, int] = "none"
    """Its cell: where UAV 0 starts, or a listed (row, column)."""
    radius: float = Field(1.5, ge=0.0)
    """Distance in cells within which a UAV is in contact whatever the radio."""
    must_return: bool = False
    """Whether only what the base knows counts: coverage, and the goal."""

    @property
    def exists(self) -> bool:
        """Whether there is one."""
        return self.at != "none"


class Prior(_Part):
    """The prior map that all UAVs are given before the episode; none by default.

    It is made of the true map and the episode's seed alone. An outdated one differs from the true map in some places,
    each drawn by itself.
    """

    kind: Literal["none", "right", "outdated"] = "none"
    """``none``; ``right``: the true map; ``outdated``: the true map with the changes below."""
    doors: float = Field(0.1, ge=0.0, le=1.0)
    """``outdated``: probability that a doorway, a gap of up to three cells in a wall, is shut in the prior."""
    openings: float = Field(0.1, ge=0.0, le=1.0)
    """``outdated``: probability that a straight wall between free cells has a doorway in the prior, and none in
    truth."""
    shift: float = Field(0.1, ge=0.0, le=1.0)
    """``outdated``: probability that a straight wall between free cells is one cell beside its place in the prior."""
    furniture: float = Field(0.5, ge=0.0, le=1.0)
    """``outdated``: probability that a free-standing obstacle of up to four cells along each side is missing in the
    prior."""


class Noise(_Part):
    """Errors of the lidar, drawn for each scan, UAV and cell; none by default.

    Where there are any, UAVs scan in every step and keep maps of log-odds, which can be wrong.
    """

    misses: float = Field(0.0, ge=0.0, lt=0.5)
    """Probability that an obstacle cell lets the beams of one scan through, as glass and black surfaces do."""
    false_returns: float = Field(0.0, ge=0.0, lt=0.5)
    """Probability that a free cell returns the beams of one scan, as dust and reflections do."""
    range_std: float = Field(0.0, ge=0.0, le=10.0)
    """Standard deviation of a normal error of the distance at which an obstacle is read, in cells."""

    @property
    def any(self) -> bool:
        """Whether the lidar errs."""
        return self.misses > 0.0 or self.false_returns > 0.0 or self.range_std > 0.0


class Drift(_Part):
    """Errors of the UAVs' pose estimates, which grow with the way flown; none by default.

    Maps are then of log-odds, drawn where a UAV believes to be, and drawn again when its path is corrected.
    """

    rate: float = Field(0.0, ge=0.0, le=0.5)
    """Probability that the estimate slips by one cell, in a random direction, for each cell flown."""
    closures: float = Field(1.0, ge=0.0, le=1.0)
    """Loop closure: probability that a UAV recognises a cell in which it has been before, and takes the surer pose."""
    closure_gap: int = Field(20, ge=1)
    """Steps that must lie between."""
    mates: bool = True
    """Whether a UAV that is linked to a teammate in sight takes the pose that follows from the teammate's, if that is
    surer."""


class Scenario(_Part):
    """Describe one task completely; equal scenarios have equal fingerprints."""

    name: str = Field("custom", min_length=1, max_length=80)
    """Shown in tables and figures."""
    map: AnyMaps = ThesisMaps()
    """Where maps come from; ``source`` may be a plug-in, ``module:Class``."""
    team: int = Field(1, ge=1, le=256)
    """UAVs."""
    spawn: Literal["random", "clustered"] | tuple[tuple[int, int], ...] = "random"
    """Where UAVs start: in random cells, next to each other (at the map's start mark if it has one), or in listed (row,
    column) cells."""
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
    """What a move into an obstacle or off the map does to the agent: ends it (the thesis) or costs the step."""
    goal: float = Field(0.9, gt=0.0, le=1.0)
    """Coverage that ends the episode, as a share of the denominator."""
    goal_of: Literal["agent", "team"] = "agent"
    """Whose coverage: each agent's own map (the thesis), or the team's union; a team goal rewards every agent."""
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
        return self

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
        """How many actions a UAV has: five, and a sixth to turn where the field of view is limited."""
        return 6 if self.turns else 5

    @cached_property
    def fingerprint(self) -> str:
        """A short canonical hash of the task; the name and where map files lie do not matter, their cells do."""
        facts = self.model_dump(mode="json", exclude={"name", "map"}) | {"map": self.map.identity()}
        for part, _, setting in (name.partition(".") for name in LATER):
            default = type(self).model_fields[part].default
            if setting and getattr(getattr(self, part), setting) == getattr(default, setting):
                del facts[part][setting]
            elif not setting and getattr(self, part) == default:
                del facts[part]
        plugins = [part.custom for part in (self.lidar, self.radio) if part.custom is not None]
        facts |= {"code": [source_hash(plugin) for plugin in plugins]} if plugins else {}
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]

    def budget_for(self, reachable: int) -> int:
        """Return the step budget on a map with that many reachable free cells."""
        return self.budget if self.budget is not None else max(LEAST_BUDGET, reachable)

    def for_evaluation(self) -> Scenario:
        """Return the task as comparisons fly it, with the settings of :data:`COMPARED`."""
        return self.with_settings(COMPARED)

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


def _defaults_of(source: str) -> dict[str, Any]:
    """Return the settings of a kind of map, None where there is no default; none for a kind that is none."""
    kind = map_class(source)
    fields = {} if kind is None else kind.model_fields
    return {name: None if field.is_required() else field.get_default() for name, field in fields.items()}

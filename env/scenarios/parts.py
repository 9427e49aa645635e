"""The groups of a scenario's settings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from indoor_explorers.env.plugins import LIDARS, RADIOS, load_plugin
from indoor_explorers.env.scenarios.codes import LIDAR_MODELS, RADIO_MODELS, StuckRuleName


class SettingsGroup(BaseModel):
    """A frozen group of settings, which refuses unknown ones."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


class _Sensor(SettingsGroup):
    """A group of settings whose ``model`` is one of this package or a plug-in's function."""

    model: str
    _GROUP: ClassVar[str]
    _WHAT: ClassVar[str]
    _OWN: ClassVar[tuple[str, ...]]

    @property
    def custom(self) -> Callable[..., Any] | None:
        """The function of a plug-in; None for a model of this package."""
        return None if self.model in self._OWN else load_plugin(self._GROUP, self.model, self._WHAT, self._OWN)

    @model_validator(mode="after")
    def _callable(self) -> Self:
        if self.custom is not None and not callable(self.custom):
            raise ValueError(f"{self.model}: expected a function, got {type(self.custom).__name__}")
        return self


class Lidar(_Sensor):
    """The range sensor."""

    _GROUP, _WHAT, _OWN = LIDARS, "lidar model", LIDAR_MODELS

    model: str = "exact"
    """``exact``: line of sight (:mod:`indoor_explorers.env.sensing.shadowcasting`); ``marsexplorer``: the ancestor's
    rays (:mod:`indoor_explorers.env.sensing.marsexplorer`); or a plug-in, ``module:function``."""
    range: float = Field(3.0, ge=1.0, le=200.0)
    """Range in cells, Euclidean to a cell's centre."""
    field_of_view: float = Field(360.0, ge=30.0, le=360.0)
    """Degrees that the lidar sees, half of them to each side of the UAV's heading; proximity sensors see the eight
    neighbours all around. Below 360 a UAV has a heading, the direction of its last move, and one action more: ``turn``,
    clockwise by 90 degrees. Maps are then of log-odds, as with ``noise`` and ``drift``."""
    elevation: float = Field(90.0, ge=1.0, le=90.0)
    """Degrees that the lidar sees up and down on maps of several levels, 15 for one of 16 rings; proximity sensors see
    the 26 neighbours all around."""


class Radio(_Sensor):
    """Which UAVs are in radio contact; linked UAVs merge their maps and exchange positions and messages."""

    _GROUP, _WHAT, _OWN = RADIOS, "radio model", RADIO_MODELS

    model: str = "none"
    """``none``; ``square``: Chebyshev distance at most ``range`` (the thesis); ``disc``: Euclidean; ``line-of-sight``:
    the same with no obstacle between; ``path-loss``: log-distance path loss with a loss for each wall between;
    ``path-loss-ir2``: that of the IR2 simulator (:mod:`indoor_explorers.env.simulation.path_loss`); ``unlimited``; or a
    plug-in, ``module:function``."""
    range: float = Field(0.0, ge=0.0)
    """Range in cells, in the open; not read by ``none`` and ``unlimited``. ``path-loss-ir2``: the distance from which
    on the open costs signal, 35 pixels in IR2; contact holds to two to nine times as far, drawn for each episode."""
    exponent: float = Field(3.0, ge=1.0, le=10.0)
    """``path-loss``: the path loss exponent n, 2 in free space, about 3 indoors (Rappaport 2002, section 4.9)."""
    wall_loss: float = Field(6.0, ge=0.0, le=200.0)
    """``path-loss``: dB lost at each wall, a run of obstacle cells on the straight line between two UAVs. With w walls
    between, the range shrinks to ``range`` 10^(-w wall_loss / (10 n))."""
    loss: float = Field(0.0, ge=0.0, lt=1.0)
    """Probability that a contact fails in a step, drawn for each pair of UAVs and each step."""


class Rewards(SettingsGroup):
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


class Stuck(SettingsGroup):
    """When an agent without progress is ended."""

    rule: StuckRuleName = "off"
    """``no-discovery``: no new cell for H*W steps; ``oscillation``: one cell too often among the last positions."""
    window: int = Field(50, ge=2, le=10_000)
    """Number of last positions that ``oscillation`` considers."""
    repeats: int = Field(20, ge=2)
    """How often the most frequent of them must appear (the thesis's text: 20, its settings file: 10)."""


class Failures(SettingsGroup):
    """UAVs that stop, and temporary radio failures; none by default.

    The cells that only a stopped UAV knew are lost: coverage counts the knowledge of the others.
    """

    hazard: float = Field(0.0, ge=0.0, lt=1.0)
    """Probability that a UAV stops in a step, drawn for each UAV and step: it flies 1 / hazard steps on average."""
    stops: tuple[tuple[int, int], ...] = ()
    """Listed [UAV, step] pairs: that UAV stops in that step, the first of which is 1."""
    last_word: bool = False
    """Whether a UAV exchanges maps with the UAVs in contact once more in the step in which it stops."""
    reward: float = 0.0
    """Reward of a UAV that stops."""
    radio_hazard: float = Field(0.0, ge=0.0, lt=1.0)
    """Probability that a working radio fails in a step, drawn for each UAV and step."""
    radio_outage: int = Field(20, ge=1)
    """Duration of a radio failure in steps, including the first; the radio neither sends nor receives."""

    @property
    def any(self) -> bool:
        """Whether anything can fail."""
        return self.hazard > 0.0 or self.radio_hazard > 0.0 or bool(self.stops)


class Base(SettingsGroup):
    """The home base; none by default.

    It has a fixed cell and a radio like the UAVs'. UAVs in contact with it, directly or through teammates, exchange
    maps with it.
    """

    at: Literal["none", "start"] | tuple[int, int] = "none"
    """Its cell: where UAV 0 starts, or a listed (row, column)."""
    radius: float = Field(1.5, ge=0.0)
    """Distance in cells within which a UAV is in contact whatever the radio."""
    must_return: bool = False
    """Whether the coverage and the goal count only the cells that the base knows."""

    @property
    def exists(self) -> bool:
        """Whether there is one."""
        return self.at != "none"


class Prior(SettingsGroup):
    """The prior map that all UAVs are given before the episode; none by default.

    It depends on the true map and the episode's seed alone. Each change of an outdated map is drawn independently.
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


class Noise(SettingsGroup):
    """Errors of the lidar, drawn for each scan, UAV and cell; none by default.

    With errors, UAVs scan in every step and keep maps of log-odds, which can be wrong.
    """

    misses: float = Field(0.0, ge=0.0, lt=0.5)
    """Probability that one scan passes through an obstacle cell, as with glass and black surfaces."""
    false_returns: float = Field(0.0, ge=0.0, lt=0.5)
    """Probability that one scan reads a free cell as an obstacle, as with dust and reflections."""
    range_std: float = Field(0.0, ge=0.0, le=10.0)
    """Standard deviation of the normal error of an obstacle's distance, in cells."""

    @property
    def any(self) -> bool:
        """Whether the lidar errs."""
        return self.misses > 0.0 or self.false_returns > 0.0 or self.range_std > 0.0


class Drift(SettingsGroup):
    """Errors of the UAVs' pose estimates, which grow with the way flown; none by default.

    Maps are then of log-odds: scans are drawn at the estimated pose, and drawn again when the path is corrected.
    """

    rate: float = Field(0.0, ge=0.0, le=0.5)
    """Probability of an unnoticed slip by one cell in a random direction, for each cell flown."""
    closures: float = Field(1.0, ge=0.0, le=1.0)
    """Loop closure: probability that a UAV recognises a visited cell and adopts the pose estimate of lower variance."""
    closure_gap: int = Field(20, ge=1)
    """Least steps between the two visits of a loop closure."""
    mates: bool = True
    """Whether a UAV that is linked to a visible teammate adopts the pose that follows from the teammate's, if that has
    a lower variance."""

"""The settings of a robot that explores, checked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from indoor_explorers.env.errors import InputError
from indoor_explorers.evaluation.robot.occupancy import Area

#: A namespace of ROS 2; empty for none.
NAME = re.compile(r"([A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*)?")


@dataclass(frozen=True, kw_only=True)
class RobotSettings:
    """Describe a robot and how it explores."""

    cell: float = 0.25
    """Metres a cell of the pilot's map."""
    radius: float = 0.22
    """Metres from the robot's centre to its outer edge."""
    lidar_range: float = 8.0
    """Metres."""
    area: Area | None = None
    """What is to be explored; None for all that the map grows to."""
    robots: tuple[str, ...] = ("",)
    """Names of the team, in the same order for all; an empty one for a robot without a namespace."""
    name: str = ""
    """The robot's own name."""
    silence: float = 30.0
    """Seconds without a map after which the robot stops; 0 for never."""
    patience: float = 30.0
    """Seconds in one cell after which a goal has failed."""
    ban: float = 60.0
    """Seconds that a failed goal is banned for."""
    settle: float = 8.0
    """Seconds that the map is given to show what is around a goal, and that no frontier may be left before the end."""
    seed: int = 0
    """Seed of the pilot's random generator."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Scenario settings that pilots are told."""

    def __post_init__(self) -> None:
        if self.name not in self.robots or len(set(self.robots)) < len(self.robots):
            raise InputError(f"expected --name among different --robots, got {self.name!r} and {self.robots}")
        if wrong := [name for name in self.robots if not NAME.fullmatch(name)]:
            raise InputError(f"expected names of robots such as tb1, which are namespaces of ROS, got {wrong[0]!r}")
        if len(self.robots) > 1 and self.area is None:
            raise InputError("expected --area X0,Y0,X1,Y1 for a team, so that all mean the same cells; give it")
        if self.area is not None and not (self.area.x0 < self.area.x1 and self.area.y0 < self.area.y1):
            raise InputError(f"expected an area X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1, got {tuple(self.area)}")

    @property
    def agent(self) -> int:
        """The robot's number in its team."""
        return self.robots.index(self.name)

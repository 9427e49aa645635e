"""``robot`` and ``robot simulate``: explore with a robot that runs ROS 2, and simulated robots to try it on."""

from __future__ import annotations

from argparse import ArgumentTypeError
from typing import Annotated, Literal

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import (
    NO_SETTINGS,
    RESOLUTION,
    SEED,
    ComparisonRequest,
    Option,
    Request,
    Settings,
    read_metres,
    read_names,
    read_seconds,
    read_speed,
)

ROBOTS = Option(metavar="a,b,...", read=read_names)


def read_area(text: str) -> tuple[float, ...]:
    """Read ``X0,Y0,X1,Y1`` in metres."""
    try:
        x0, y0, x1, y1 = map(float, text.split(","))
    except ValueError:
        raise ArgumentTypeError(f"expected X0,Y0,X1,Y1 in metres such as -10,-5,20,15, got {text!r}") from None
    return x0, y0, x1, y1


class RobotOptions(Request):
    """The options of ``robot``."""

    policy: Annotated[str, Option(metavar="NAME")] = "frontier"
    """The policy, with parameters as in 'pso(length=1)'."""
    name: Annotated[str, Option(metavar="NAME")] = ""
    """The robot's own namespace (default none)."""
    robots: Annotated[tuple[str, ...], ROBOTS] = ()
    """The namespaces of the team, in the same order for all of its robots."""
    cell: Annotated[float, Option(metavar="METRES", read=read_metres)] = 0.25
    """The size of the planner's cells. Doors narrower than a cell and twice the radius may be closed to it."""
    radius: Annotated[float, Option(metavar="METRES", read=read_metres)] = 0.22
    """From the robot's centre to its outer edge."""
    lidar: Annotated[float, Option(metavar="METRES", read=read_metres)] = 8.0
    """The range of the lidar."""
    area: Annotated[tuple[float, float, float, float] | None, Option(metavar="X0,Y0,X1,Y1", read=read_area)] = None
    """What to explore, in the frame of the map; teams need it (default: what the map grows to). Write --area=-5,..."""
    goals: Annotated[Literal["topic", "action"], Option(choices=("topic", "action"))] = "topic"
    """topic: goals on goal_pose, for any middleware; action: navigate_to_pose, for rmw_cyclonedds_cpp."""
    map_topic: Annotated[str, Option(metavar="NAME")] = "map"
    """The topic of the map; one such as /map is not in the robot's namespace."""
    map_frame: Annotated[str, Option(metavar="NAME")] = "map"
    """The frame of the map."""
    base_frame: Annotated[str, Option(metavar="NAME")] = "base_link"
    """The frame of the robot."""
    silence: Annotated[float, Option(metavar="SECONDS", read=read_seconds)] = 30.0
    """Stop the robot after as long without a map, until there is one again."""
    patience: Annotated[float, Option(metavar="SECONDS", read=read_seconds)] = 30.0
    """A goal has failed when the robot stays in one cell for as long."""
    ban: Annotated[float, Option(metavar="SECONDS", read=read_seconds)] = 60.0
    """Choose no goal near a failed one for as long."""
    settle: Annotated[float, Option(metavar="SECONDS", read=read_seconds)] = 8.0
    """How long the map may take to show what the robot sees; more than the period of the map."""
    stay: Annotated[bool, Option()] = False
    """Go on when no frontier is left, and explore again if the map gets one."""
    seed: Annotated[int, SEED] = 0
    """Seed of the pilot's random numbers."""
    settings: Settings = NO_SETTINGS
    """Scenario settings that the planner is told, such as radio.range=20 (cells)."""


def run_robot(options: RobotOptions, typed: str) -> int:
    """Explore with one robot."""
    from indoor_explorers.evaluation.harness.experiment.planning import plan
    from indoor_explorers.evaluation.robot.occupancy import Area
    from indoor_explorers.evaluation.robot.running import Wiring, explore
    from indoor_explorers.evaluation.robot.settings import RobotSettings

    (policy,) = plan(ComparisonRequest(policies=(options.policy,), scenario=("thesis-open",))).policies
    wired = {"map_topic": options.map_topic, "map_frame": options.map_frame, "base_frame": options.base_frame}
    same = ("name", "cell", "radius", "silence", "patience", "ban", "settle", "seed", "settings")
    settings = RobotSettings(
        robots=options.robots or (options.name,),
        lidar_range=options.lidar,
        area=None if options.area is None else Area(*options.area),
        **{name: getattr(options, name) for name in same},
    )
    console = make_console()
    wiring = Wiring(action=options.goals == "action", **wired)
    explore(policy.make(), settings, wiring, lambda line: print_line(console, line), stay=options.stay)
    return 0


class SimulateOptions(Request):
    """The options of ``robot simulate``."""

    scenario: Annotated[str | None, Option(metavar="PRESET|FILE.toml")] = None
    """The building and the lidar (default thesis-obstacles)."""
    maps: Annotated[str | None, Option(metavar="PATH")] = None
    """A map file as the building instead."""
    resolution: Annotated[float | None, RESOLUTION] = None
    """Metres per cell to resample the map file to; cells of other buildings have 1 m."""
    robots: Annotated[tuple[str, ...], ROBOTS] = ("",)
    """The namespaces of the robots (default: one robot without a namespace)."""
    shared_map: Annotated[bool, Option()] = False
    """One map of all robots, on /map, instead of one each."""
    speed: Annotated[float, Option(metavar="METRES/SECOND", read=read_speed)] = 0.5
    """The speed of the robots."""
    seed: Annotated[int, SEED] = 0
    """Seed of the building and of the starts."""
    settings: Settings = NO_SETTINGS
    """Scenario settings such as lidar.range=5 (cells)."""


def run_simulate(options: SimulateOptions, typed: str) -> int:
    """Simulate robots until interrupted."""
    from indoor_explorers.evaluation.harness.experiment.planning import plan
    from indoor_explorers.evaluation.robot.simulated import Simulation, simulate

    given = options.model_dump(include={"scenario", "maps", "resolution", "seed", "settings"})
    request = ComparisonRequest(policies=("random",), team=len(options.robots), episodes=1, **given)
    (scenario,) = plan(request).scenarios
    console = make_console()
    simulation = Simulation(
        scenario=scenario,
        seed=options.seed,
        names=options.robots,
        speed=options.speed,
        shared=options.shared_map,
    )
    simulate(simulation, lambda line: print_line(console, line))
    return 0


_ENDED = "the robot was told to stop"
ROBOT = Command(RobotOptions, run_robot, _ENDED)
SIMULATE = Command(SimulateOptions, run_simulate, "the robots are gone")

"""Scenarios with a name: the thesis's experiments, buildings, and the default scenario of map files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import get_args

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.maps.sources import (
    CaveMaps,
    FileMaps,
    FloorsMaps,
    HallsMaps,
    HomesMaps,
    InteriorsMaps,
    MapSource,
    MazeMaps,
    OfficeMap,
    OfficesMaps,
    RacksMaps,
    RoomsMaps,
    StoreysMaps,
)
from indoor_explorers.env.scenarios.codes import StuckRuleName
from indoor_explorers.env.scenarios.parts import Base, Drift, Lidar, Noise, Radio, Rewards, Stuck
from indoor_explorers.env.scenarios.scenario import Scenario


def _old_rewards(step: float, cell: float, crash: float, stuck: float, goal: float) -> Rewards:
    """Rewards as in the thesis, with received cells like discovered ones."""
    return Rewards(
        step=step, discovered=cell, received=cell, collision=crash, out_of_bounds=crash, stuck=stuck, goal=goal
    )


#: The thesis's three reward sets (Table 4.2, its scenarios 1 to 3).
REWARDS = {
    1: _old_rewards(-0.5, 1.0, -400.0, -400.0, 400.0),
    2: _old_rewards(-1.0, 10.0, -100_000.0, -10_000.0, 10_000.0),
    3: _old_rewards(-10.0, 10.0, -1000.0, -1000.0, 1000.0),
}
#: Its stuck rules: "no stuck", "stuck 1" and "stuck 2" (section 4.2).
STUCK: tuple[StuckRuleName, ...] = get_args(StuckRuleName)


def scenario(name: str) -> Scenario:
    """Return the preset scenario of that name."""
    if name not in PRESETS:
        raise InputError(f"unknown scenario {name!r}{did_you_mean(name, PRESETS)}")
    return PRESETS[name]


def _thesis(
    name: str,
    *,
    obstacles: int,
    team: int = 1,
    radio: float = 0.0,
    rewards: Rewards | None = None,
    stuck: Stuck | None = None,
) -> Scenario:
    """A room of the thesis: 16x16, lidar 3, 400 steps, 90 % of the whole map, ended for oscillating."""
    return Scenario(
        name=name,
        map=ThesisMaps(obstacles=obstacles),
        team=team,
        radio=Radio(model="square", range=radio) if radio > 0 else Radio(),
        rewards=rewards or Rewards(),
        stuck=stuck or Stuck(rule="oscillation"),
        denominator="map",
        budget=400,
    )


def _building(name: str, maps: MapSource, budget: int | None) -> Scenario:
    """A building for two UAVs: lidar 10, radio 15, a team goal of 99 % of the reachable cells; obstacles block."""
    return Scenario(
        name=name,
        map=maps,
        team=2,
        spawn="clustered",
        lidar=Lidar(range=10.0),
        radio=Radio(model="disc", range=15.0),
        on_collision="block",
        goal=0.99,
        goal_of="team",
        budget=budget,
    )


def _small(preset: Scenario, maps: MapSource) -> Scenario:
    """A building at two fifths of the size, the same number of lidar ranges across: quick to fly and train on."""
    return preset.model_copy(
        update={
            "name": f"small-{preset.name}",
            "map": maps,
            "lidar": Lidar(range=4.0),
            "radio": Radio(model="disc", range=6.0),
            "budget": 1000,
        }
    )


def _with_base(preset: Scenario, team: int, budget: int) -> Scenario:
    """Return a building in which only cells known to the home base within the budget count."""
    base = Base(at="start", must_return=True)
    name = f"{preset.name}-base-{team}"
    return preset.model_copy(update={"name": name, "team": team, "base": base, "budget": budget})


def _with_errors(preset: Scenario) -> Scenario:
    """Return a building with lidar errors and drifting pose estimates."""
    noise = Noise(misses=0.05, false_returns=0.001, range_std=0.2)
    return preset.model_copy(update={"name": f"{preset.name}-errors", "noise": noise, "drift": Drift(rate=0.001)})


def _with_camera(preset: Scenario) -> Scenario:
    """Return a building for UAVs with forward depth cameras."""
    lidar = preset.lidar.model_copy(update={"field_of_view": 90.0})
    return preset.model_copy(update={"name": f"{preset.name}-camera", "lidar": lidar})


def _with_rings(preset: Scenario) -> Scenario:
    """Return a building of several levels for UAVs with a lidar of 16 rings, 15 degrees up and down."""
    lidar = preset.lidar.model_copy(update={"elevation": 15.0})
    return preset.model_copy(update={"name": f"{preset.name}-rings", "lidar": lidar})


def _buildings() -> Iterator[Scenario]:
    """Yield the bundled office and generated buildings, each kind also small."""
    office = _building("office", OfficeMap(), 1500)
    yield from (office, _with_base(office, 2, 900), _with_base(office, 4, 500))
    offices = OfficesMaps(height=40, width=40, corridor=2, room_depth=(3, 5), room_width=(3, 6), crossing=24)
    halls = HallsMaps(height=40, width=40, spacing=(4, 6), aisle=(1, 2), room_depth=(3, 5), room_width=(3, 6))
    storeys = StoreysMaps(height=24, width=24, room_size=(3, 6), hall_size=(3, 5), corridor=1)
    for name, maps, budget, small in (
        ("rooms", RoomsMaps(), 1000, RoomsMaps(height=40, width=40, room_size=(3, 6), corridor=1)),
        ("offices", OfficesMaps(), 1000, offices),
        ("floors", FloorsMaps(), None, FloorsMaps(height=64, width=90, resolution=1.25, area=(300.0, 2500.0))),
        ("halls", HallsMaps(), 1000, halls),
        ("homes", HomesMaps(), 1000, HomesMaps(height=20, width=25, room_size=(3, 7), door=1)),
        ("cave", CaveMaps(), 1000, CaveMaps(height=40, width=40, chamber=4)),
        ("maze", MazeMaps(), 1500, MazeMaps(height=26, width=26, corridor=1)),
        ("storeys", StoreysMaps(), None, storeys),
    ):
        building = _building(name, maps, budget)
        yield from (building, _small(building, small))
        if name == "floors":
            yield from (_with_errors(_small(building, small)), _with_camera(_small(building, small)))
        if name == "storeys":
            yield _with_rings(building)
    yield from _volumes()


def _volumes() -> Iterator[Scenario]:
    """Yield buildings of several levels, of half a metre each, by what the third dimension is in them."""
    low = InteriorsMaps(height=24, width=30)
    hall = InteriorsMaps(height=24, width=30, storeys=2, storey_height=5, halls=1)
    joined = InteriorsMaps(
        height=24, width=30, storeys=3, storey_height=4, headroom=3, wells=2, crawl_spaces=2, hatches=2
    )
    kinds: tuple[tuple[str, MapSource], ...] = (
        ("one-storey", low),
        ("tall-halls", hall),
        ("racks", RacksMaps(height=24, width=30)),
        ("stair-wells", joined),
    )
    for name, maps in kinds:
        yield _building(name, maps, None)


def _first_phase() -> Iterator[Scenario]:
    """Yield the thesis's first experiments (section 4.2): three reward sets times three stuck rules, no obstacles."""
    for number, rewards in REWARDS.items():
        for stuck, rule in enumerate(STUCK):
            yield _thesis(
                f"thesis-rewards-{number}-stuck-{stuck}", obstacles=0, rewards=rewards, stuck=Stuck(rule=rule)
            )


def _second_phase() -> Iterator[Scenario]:
    """Yield its later ones: two and four UAVs among five obstacles, with radio ranges 0, 1 and 3."""
    for team in (2, 4):
        for reach in (0, 1, 3):
            yield _thesis(
                f"thesis-team-{team}-radio-{reach}", obstacles=5, team=team, radio=float(reach), rewards=REWARDS[1]
            )


def _always_linked() -> Iterator[Scenario]:
    """Yield its teams with unlimited radio, as a bound on the value of communication."""
    for team in (2, 4):
        room = _thesis(f"thesis-team-{team}-radio-unlimited", obstacles=5, team=team)
        yield room.model_copy(update={"radio": Radio(model="unlimited")})


#: Scenarios with a name.
PRESETS: dict[str, Scenario] = {
    preset.name: preset
    for preset in (
        _thesis("thesis-open", obstacles=0),
        _thesis("thesis-obstacles", obstacles=5),
        _thesis("thesis-team-2", obstacles=5, team=2, radio=3.0),
        _thesis("thesis-team-4", obstacles=5, team=4, radio=3.0),
        *_first_phase(),
        *_second_phase(),
        *_always_linked(),
        *_buildings(),
    )
}


def on_files(paths: tuple[str, ...], resolution: float | None) -> Scenario:
    """Return the default scenario for maps from files."""
    name = Path(paths[0]).stem if len(paths) == 1 else f"{len(paths)} maps"
    return on_maps(name, FileMaps(paths=paths, resolution=resolution))


def on_maps(name: str, maps: MapSource) -> Scenario:
    """Return the default scenario for maps of any size: one UAV, sensing as in offices, a budget by map size."""
    return PRESETS["office"].model_copy(update={"name": name, "map": maps, "team": 1, "budget": None})

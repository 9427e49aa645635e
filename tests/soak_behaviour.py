"""Fly every policy over many maps, teams and radios, and list the episodes in which somebody misbehaved.

`make soak` flies all there is; `--policies`, `--teams`, `--worlds` and `--seeds` choose, and `--maps` adds map files:

    python -P tests/soak_behaviour.py --policies pso --maps floor.yaml --resolution 0.25

A policy misbehaves that raises, that does not cover the map, that flies into a wall, or one of whose UAVs stands still
or flies to and fro for longer than is excused while it has something left to find. Each of these episodes is listed
with the command that shows it. The exit status is 1 when there is any.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from indoor_explorers.env.policies.registry import policy_names
from indoor_explorers.evaluation.episodes.metrics import WASTED, excused
from indoor_explorers.evaluation.episodes.record import Outcome, Record
from indoor_explorers.evaluation.episodes.runner import fly
from indoor_explorers.evaluation.experiment.experiment import Task
from indoor_explorers.evaluation.experiment.planning import plan
from indoor_explorers.evaluation.experiment.request import ComparisonRequest

#: A preset, or the path of a map file, and settings.
World = tuple[str, dict[str, Any]]
#: Those that are flown, by name; see :func:`write_maps` for the files.
WORLDS: dict[str, World] = {
    "room": ("thesis-obstacles", {}),
    "pockets": ("thesis-obstacles", {"map.obstacles": 40, "map.obstacle_size": [1, 3]}),
    "rooms": ("rooms", {"map.height": 32, "map.width": 32, "lidar.range": 5}),
    "offices": ("offices", {"map.height": 40, "map.width": 40, "lidar.range": 6}),
    "cave": ("cave", {"map.height": 32, "map.width": 32, "lidar.range": 5}),
    "maze": ("maze", {"map.height": 33, "map.width": 33, "lidar.range": 5}),
    "corridors": ("maze", {"map.height": 21, "map.width": 21, "map.corridor": 1, "map.braid": 0, "lidar.range": 3}),
    "comb": ("comb.npy", {"lidar.range": 2}),
    "plus": ("plus.npy", {"lidar.range": 2}),
}
#: Radio settings by name; the last one asks every UAV to see everything itself.
RADIOS: dict[str, dict[str, Any]] = {
    "none": {"radio.model": "none"},
    "disc": {"radio.model": "disc", "radio.range": 6},
    "unlimited": {"radio.model": "unlimited"},
    "loss": {"radio.model": "unlimited", "radio.loss": 0.3},
    "sight": {"radio.model": "line-of-sight", "radio.range": 12},
    "each": {"radio.model": "none", "goal_of": "agent"},
}
#: Steps of an episode, far more than any of them needs; map files have their own, by size.
BUDGET = 4000
#: Policies that need not get anywhere.
EXEMPT = ("random", "dddqn-thesis")


@dataclass(frozen=True)
class Case:
    """One episode."""

    policy: str
    world: str
    preset: str
    team: int
    settings: dict[str, Any]
    seed: int
    resolution: float | None = None

    @property
    def title(self) -> str:
        """What it is, in short."""
        return f"{self.policy} on {self.world}, {self.team} UAVs"

    def words(self) -> str:
        """Return the command that shows it."""
        source = "--maps" if "." in self.preset else "--scenario"
        words = ["indoor-explorers", "watch", "--policy", self.policy, source, self.preset, "--team", str(self.team)]
        words += ["--resolution", f"{self.resolution:g}"] if self.resolution else []
        changes = [
            f"{key}={str(value).lower() if isinstance(value, bool) else value}" for key, value in self.settings.items()
        ]
        return shlex.join([*words, "--seed", str(self.seed), "--set", *changes])

    def fly(self) -> Record:
        """Fly it."""
        of_files = "." in self.preset
        planned = plan(
            ComparisonRequest(
                policies=[self.policy],
                scenario=None if of_files else self.preset,
                maps=[self.preset] if of_files else (),
                resolution=self.resolution,
                team=self.team,
                settings=self.settings,
            )
        )
        (choice,), (scenario,) = planned.policies, planned.scenarios
        (record,) = fly(choice.make(), choice.name, scenario, [Task(scenario.name, 0, self.seed)])
        return record


def violations(record: Record) -> list[str]:
    """Name what a policy must not do in an episode."""
    found = []
    if record.outcome is Outcome.FAILED:
        return [f"failed: {record.reason}"]
    if record.outcome is not Outcome.COMPLETE:
        found.append(f"covered {record.curve[-1]:.1%} ({record.outcome})")
    crashes = int(record.metrics["collisions"] or 0) - (record.policy.startswith("tests.casualties"))
    if crashes > 0:
        found.append(f"{crashes} collisions")
    return found + [
        f"{metric.replace('_', ' ')} {record.metrics[metric]:g}"
        for metric in WASTED
        if (record.metrics[metric] or 0) > excused(metric, record.team)
    ]


def judged(case: Case) -> tuple[Case, list[str]]:
    """Fly a case in a worker."""
    try:
        return case, violations(case.fly())
    except Exception as error:  # whatever a policy does, the others are flown
        return case, [f"{type(error).__name__}: {error}"]


def quick_cases(policy: str, folder: Path) -> Iterator[Case]:
    """Yield some two dozen episodes of a policy that hold the worst: crowds, dead ends, pockets, and a lost UAV."""
    write_maps(folder)
    small = {world: WORLDS[world] for world in WORLDS if world != "offices"}
    for (world, (preset, settings)), radio in zip(_placed(small, folder).items(), cycle(RADIOS)):
        yield Case(policy, world, preset, 1, settings, 1)
        yield Case(policy, world, preset, 4, settings | {"spawn": "clustered", **RADIOS[radio]}, 2)
        if world in ("room", "corridors", "plus"):
            yield Case(policy, world, preset, 16, settings | {"spawn": "clustered", **RADIOS["none"]}, 3)
            lost = settings | {"spawn": "clustered", "on_collision": "end", **RADIOS["disc"]}
            yield Case(f"tests.casualties:{policy}", world, preset, 3, lost, 4)


def cases(arguments: argparse.Namespace, worlds: dict[str, World]) -> Iterator[Case]:
    """Yield the episodes of every policy."""
    for policy in arguments.policies or [name for name in policy_names() if name not in EXEMPT]:
        for world, (preset, settings) in worlds.items():
            resolution = arguments.resolution if preset in arguments.maps else None
            for team, extra in _teams(arguments):
                for seed in range(arguments.seed, arguments.seed + arguments.seeds):
                    changes = settings | extra
                    yield Case(policy, world, preset, team, changes, seed, resolution)
                    if team > 1 and "goal_of" not in extra:
                        lost = f"tests.casualties:{policy}"
                        yield Case(lost, world, preset, team, changes | {"on_collision": "end"}, seed, resolution)


def _teams(arguments: argparse.Namespace) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield the sizes of teams with settings of starts and radio."""
    for team in arguments.teams:
        for radio, settings in RADIOS.items() if team > 1 else [("none", RADIOS["none"])]:
            if radio in arguments.radios:
                for spawn in ("random", "clustered") if team > 1 else ("random",):
                    yield team, {"spawn": spawn, **settings}


def write_maps(folder: Path) -> None:
    """Write a comb of dead ends and a plus of corridors, all one cell wide."""
    comb = np.ones((13, 25), np.uint8)
    comb[6, 1:-1] = comb[1:6, 1:-1:2] = comb[7:-1, 2:-1:3] = 0
    plus = np.ones((31, 31), np.uint8)
    plus[15, 1:-1] = plus[1:-1, 15] = 0
    plus[13:18, 13:18] = 0
    folder.mkdir(parents=True, exist_ok=True)
    for name, cells in {"comb": comb, "plus": plus}.items():
        np.save(folder / f"{name}.npy", cells)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the arguments."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policies", type=lambda text: text.split(","), metavar="a,b", help="default: all registered")
    parser.add_argument("--worlds", type=lambda text: text.split(","), default=list(WORLDS), metavar="a,b")
    parser.add_argument("--maps", nargs="+", default=[], metavar="PATH", help="map files to fly on as well")
    parser.add_argument("--resolution", type=float, metavar="METRES", help="of those files")
    parser.add_argument("--teams", type=lambda text: [int(n) for n in text.split(",")], default=[1, 2, 4, 8, 16])
    parser.add_argument("--radios", type=lambda text: text.split(","), default=list(RADIOS), metavar="a,b")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="first seed")
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="episodes of each kind")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N")
    parser.add_argument("--out", type=Path, default=Path("results/soak"), metavar="DIR", help="for maps made here")
    return parser


def chosen_worlds(arguments: argparse.Namespace) -> dict[str, World]:
    """Return the worlds asked for, those in map files with their paths."""
    write_maps(arguments.out)
    worlds = _placed({name: WORLDS[name] for name in arguments.worlds}, arguments.out)
    return worlds | {Path(path).stem: (path, {}) for path in arguments.maps}


def _placed(worlds: dict[str, World], folder: Path) -> dict[str, World]:
    """Return the worlds with their budget, and the paths of those that are map files in the folder."""
    paths = {name: str(folder / preset) if preset.endswith(".npy") else preset for name, (preset, _) in worlds.items()}
    return {name: (paths[name], settings | {"budget": BUDGET}) for name, (_, settings) in worlds.items()}


def report(found: Sequence[tuple[Case, list[str]]]) -> None:
    """Print how often each policy misbehaved and how."""
    counts = Counter((case.policy, problem.split(" ")[0]) for case, problems in found for problem in problems)
    for (policy, kind), count in sorted(counts.items()):
        sys.stdout.write(f"{policy:40s} {kind:12s} {count:5d}\n")


def main() -> int:
    """Fly, and print every violation as it is found."""
    sys.path.append(str(Path(__file__).parents[1]))  # where workers find tests.casualties
    arguments = parser().parse_args()
    flown, found = 0, []
    every = list(cases(arguments, chosen_worlds(arguments)))
    with ProcessPoolExecutor(arguments.workers) as pool:
        for case, problems in pool.map(judged, every, chunksize=4):
            flown += 1
            if problems:
                found.append((case, problems))
                sys.stdout.write(f"{case.title}: {'; '.join(problems)}\n    {case.words()}\n")
                sys.stdout.flush()
    report(found)
    sys.stdout.write(f"{flown} episodes, {len(found)} with violations\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

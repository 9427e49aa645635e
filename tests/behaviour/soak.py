"""Fly every policy over many maps, teams and radios, and list the episodes in which a UAV misbehaved.

`make soak` flies the full product. The arguments choose a part of it, and `--maps` adds map files:

    python -m tests.behaviour.soak --policies pso --maps floor.yaml --resolution 0.25

The failure modes of :mod:`indoor_explorers.env.conformance.failure_modes` are flown with every radio.
:func:`~tests.behaviour.episodes.violations` defines misbehaviour. Each such episode is listed with the command that
shows it. The exit status is 1 when there is any.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

from indoor_explorers.env.conformance import FAILURE_MODES
from tests.behaviour.episodes import LOST_UAV, Case, FailureCase
from tests.behaviour.policies import EXPLORERS
from tests.behaviour.worlds import FACTORS, RADIOS, SMALL, WORLDS, Settings, write_maps

AnyCase = Case | FailureCase


def judged(case: AnyCase) -> tuple[AnyCase, list[str]]:
    """Fly a case in a worker."""
    try:
        return case, case.problems()
    except Exception as error:  # whatever a policy does, the others are flown
        return case, [f"{type(error).__name__}: {error}"]


def cases(arguments: argparse.Namespace) -> Iterator[AnyCase]:
    """Yield the episodes of every policy."""
    for policy in arguments.policies or EXPLORERS:
        for mode, radio in product(arguments.modes, [radio for radio in arguments.radios if radio != "each"]):
            for seed in range(arguments.seed, arguments.seed + arguments.seeds):
                yield FailureCase(policy, mode, radio, seed)
        for team, settings in _teams(arguments):
            for seed in range(arguments.seed, arguments.seed + arguments.seeds):
                yield from _on_every_map(arguments, policy, team, settings, seed)
                if team > 1 and "goal_of" not in settings:
                    lost = f"{LOST_UAV}:{policy}"
                    yield from _on_every_map(arguments, lost, team, {**settings, "on_collision": "end"}, seed)


def _on_every_map(
    arguments: argparse.Namespace, policy: str, team: int, settings: Settings, seed: int
) -> Iterator[Case]:
    for world in arguments.worlds:
        for lidar in [{"lidar.range": reach} for reach in FACTORS["lidar"]] if world in SMALL else [{}]:
            yield Case.on(world, arguments.out, policy, team, {**settings, **lidar}, seed)
    for path in arguments.maps:  # large maps may need more than the budget of the others
        yield Case(policy, Path(path).stem, path, team, settings, seed, arguments.resolution)


def _teams(arguments: argparse.Namespace) -> Iterator[tuple[int, Settings]]:
    """Yield the sizes of teams with settings of starts and radio."""
    for team in arguments.teams:
        for radio, settings in RADIOS.items() if team > 1 else [("none", RADIOS["none"])]:
            if radio in arguments.radios:
                for spawn in ("random", "clustered") if team > 1 else ("random",):
                    yield team, {"spawn": spawn, **settings}


def _words(text: str) -> list[str]:
    return [word for word in text.split(",") if word]


def parser() -> argparse.ArgumentParser:
    """Return the parser of the arguments."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policies", type=_words, metavar="a,b", help="default: all registered")
    parser.add_argument("--worlds", type=_words, default=list(WORLDS), metavar="a,b")
    modes = [mode.name for mode in FAILURE_MODES]
    parser.add_argument("--modes", type=_words, default=modes, metavar="a,b", help="failure modes to fly; '' for none")
    parser.add_argument("--maps", nargs="+", default=[], metavar="PATH", help="map files to fly on as well")
    parser.add_argument("--resolution", type=float, metavar="METRES", help="of those files")
    parser.add_argument("--teams", type=lambda text: [int(n) for n in text.split(",")], default=[1, 2, 4, 8, 16])
    parser.add_argument("--radios", type=_words, default=list(RADIOS), metavar="a,b")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="first seed")
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="episodes of each kind")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N")
    parser.add_argument("--out", type=Path, default=Path("results/soak"), metavar="DIR", help="for maps made here")
    return parser


def report(found: Sequence[tuple[AnyCase, list[str]]]) -> None:
    """Print how often each policy misbehaved and how."""
    counts = Counter((case.policy, problem.split(" ")[0]) for case, problems in found for problem in problems)
    for (policy, kind), count in sorted(counts.items()):
        sys.stdout.write(f"{policy:45s} {kind:12s} {count:5d}\n")


def main() -> int:
    """Fly, and print every violation as it is found."""
    arguments = parser().parse_args()
    write_maps(arguments.out)
    flown, found = 0, []
    with ProcessPoolExecutor(arguments.workers) as pool:
        for case, problems in pool.map(judged, list(cases(arguments)), chunksize=4):
            flown += 1
            if problems:
                found.append((case, problems))
                sys.stdout.write(f"{case.title}: {'; '.join(problems)}\n    {case.command()}\n")
                sys.stdout.flush()
    report(found)
    sys.stdout.write(f"{flown} episodes, {len(found)} with violations\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

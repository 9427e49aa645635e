"""The thesis's 14 experiments (section 4.2), what it says of each, and the versions of its learner to train."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from indoor_explorers.env import InputError
from indoor_explorers.env.errors import did_you_mean
from indoor_explorers.evaluation.studies.many_trainings import matching

#: Names of the version with all switches as in the thesis, of that with all corrected, and of one for each switch.
AS_WAS, MENDED, EACH = "thesis", "mended", "each"
#: Factor of the episodes of trainings among obstacles to those in the empty room: 50,000 to 10,000.
LONGER = 5


class ThesisExperiment(NamedTuple):
    """One training of the thesis."""

    name: str
    group: str
    """Experiments of a group share figures."""
    title: str
    """Its name within the group."""
    scenario: str
    """Preset that it trains on."""
    minutes: float
    """Training time that the thesis reports."""
    said: str
    """What the thesis says about it, after the number of the figure."""
    starts_from: str | None = None
    """Name of the experiment whose weights it starts from."""

    def episodes(self, base: int) -> int:
        """Return the number of training episodes, given ``base`` for the empty room."""
        return base if self.group.startswith("rewards") else LONGER * base


_STUCK = ("no stuck rule", "stuck 1: no discovery", "stuck 2: oscillation")
_OPEN = (
    (100.6, "4.1a: the agent persists to get stuck between positions"),
    (78.57, "4.1b: the fewest negative outcomes and the stablest score; a circle along the walls is learnt"),
    (53.39, "4.1c: the most negative outcomes, yet of all nine the best coverage in the fewest steps (4.8)"),
    (149.03, "4.4a: learns the circle, and still gets stuck"),
    (124.36, "4.4b: a stabler exploring process than rule 2"),
    (41.45, "4.4c: never takes 400 steps, at times as good as the others in fewer steps"),
    (63.22, "4.6a: learns the circle, and still gets stuck"),
    (54.25, "4.6b: the stabler curve; gets stuck more often than with rule 2"),
    (35.71, "4.6c: mean score above zero from episode 1,020 to 2,000 on; most episodes take less than 275 steps"),
)
#: Titles of the groups.
GROUPS = {
    "rewards-1": "Reward scenario 1: step -0.5, cell +1, goal +400, crash and stuck -400; empty room",
    "rewards-2": "Reward scenario 2: step -1, cell +10, goal +10,000, crash -100,000, stuck -10,000; empty room",
    "rewards-3": "Reward scenario 3: step -10, cell +10, goal +1,000, crash and stuck -1,000; empty room",
    "obstacles": "Five obstacles, reward scenario 1, stuck 2: one, two and four UAVs",
}
_TEAMS = (
    (2, 0, 226.66, "4.11: more positive scores than alone; both try to take the same path"),
    (2, 1, 216.54, "4.13: more positive scores than range 3; in range of each other, they act alike"),
    (2, 3, 179.6, "4.14, 4.16: no radio gets as far in fewer steps; in range of each other, they act alike"),
    (4, 0, 421.67, "4.18, 4.20: the most positive scores and the fastest; mostly one of the four explores"),
)


def _experiments() -> Iterator[ThesisExperiment]:
    for place, (minutes, said) in enumerate(_OPEN):
        rewards, stuck = place // 3 + 1, place % 3
        name = f"rewards-{rewards}-stuck-{stuck}"
        yield ThesisExperiment(name, f"rewards-{rewards}", _STUCK[stuck], f"thesis-{name}", minutes, said)
    alone = "4.9, 4.10: mostly negative scores, rising slowly; learns to avoid some obstacles, then crashes"
    yield ThesisExperiment("obstacles-1", "obstacles", "one UAV", "thesis-obstacles", 120.19, alone)
    for team, reach, minutes, said in _TEAMS:
        name, title = f"team-{team}-radio-{reach}", f"{team} UAVs, radio {reach}"
        yield ThesisExperiment(name, "obstacles", title, f"thesis-{name}", minutes, said, "obstacles-1")


EXPERIMENTS = tuple(_experiments())


def chosen(patterns: Sequence[str]) -> list[ThesisExperiment]:
    """Return the experiments whose names match any of the patterns, and those whose weights they start from.

    Raises:
        InputError: a pattern matches none.

    """
    wanted = matching([one.name for one in EXPERIMENTS], patterns, "experiment of the thesis")
    needed = {*wanted, *(one.starts_from for one in EXPERIMENTS if one.name in wanted)}
    return [one for one in EXPERIMENTS if one.name in needed]


def versions(names: Sequence[str], mended: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the settings of versions by name: ``thesis``, ``mended``, or a switch that alone is corrected.

    ``each`` stands for one version for each switch.

    Raises:
        InputError: there is no such version.

    """
    known: dict[str, dict[str, Any]] = {AS_WAS: {}, MENDED: dict(mended)}
    known |= {switch: {switch: value} for switch, value in mended.items()}
    spelled = [one for name in names for one in (mended if name == EACH else [name])]
    for name in spelled:
        if name not in known:
            raise InputError(f"unknown version {name!r}{did_you_mean(name, [*known, EACH])}")
    return {name: known[name] for name in spelled}

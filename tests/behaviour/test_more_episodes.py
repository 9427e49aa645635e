"""Every policy in more episodes than make test has time for; `make soak` flies the full product."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle
from pathlib import Path

import pytest

from indoor_explorers.env import PRESETS
from tests.behaviour.episodes import LOST_UAV, Case, violations
from tests.behaviour.policies import EXPLORERS, parametrized
from tests.behaviour.test_every_policy import assert_well_flown, flown
from tests.behaviour.worlds import RADIOS, WORLDS

pytestmark = pytest.mark.slow
every_explorer = parametrized(EXPLORERS)


@every_explorer
@pytest.mark.parametrize("scenario", ["thesis-open", "thesis-obstacles", "thesis-team-2", "thesis-team-4"])
def test_it_completes_more_thesis_rooms(name: str, scenario: str) -> None:
    assert_well_flown(flown(name, PRESETS[scenario].for_evaluation(), range(502, 510)))


def cases(policy: str, folder: Path) -> Iterator[Case]:
    """Yield the worst: crowds, dead ends, pockets, radios that lose messages or need a line of sight, a lost UAV."""
    for world, radio in zip((world for world in WORLDS if world != "offices"), cycle(RADIOS), strict=False):
        yield Case.on(world, folder, policy, 1, {}, 1)
        yield Case.on(world, folder, policy, 4, {"spawn": "clustered", **RADIOS[radio]}, 2)
        if world in ("room", "corridors", "plus"):
            yield Case.on(world, folder, policy, 16, {"spawn": "clustered", **RADIOS["none"]}, 3)
            lost = {"spawn": "clustered", "on_collision": "end", **RADIOS["loss"]}
            yield Case.on(world, folder, f"{LOST_UAV}:{policy}", 3, lost, 4)


@every_explorer
def test_it_misbehaves_in_none_of_the_worst_cases(name: str, map_files: Path) -> None:
    found = {case.command(): violations(case.fly()) for case in cases(name, map_files)}
    assert len(found) > 25
    assert {command: problems for command, problems in found.items() if problems} == {}

"""The gallery: pictures of scenarios, harder tasks, policies and observations, flown and painted with the site."""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import PRESETS, policy_names
from indoor_explorers.env.observations import OBSERVATIONS, PLANES, make_encoder
from indoor_explorers.env.rendering import paint, scene_of
from indoor_explorers.env.rendering.indexed import Palette
from indoor_explorers.env.rendering.side_by_side import SideBySide, paint_side_by_side
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.cli.watch import WatchedFlight
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import NO_SETTINGS, ComparisonRequest

#: Seed of every episode, and the coverage at which pictures are taken.
SEED, TYPICAL = 1, 0.6
#: The scenario of the policies' pictures, and the steps that their charts reach to.
OFFICES, STEPS = "small-offices", 300
#: The policy of the scenarios' pictures.
PILOT = "frontier"
#: The policies of the example of a report.
EXAMPLE = ("frontier-nearest", "frontier", "pso", "reference")
#: Names of scenarios that differ from others in rules or radio only, or are among the harder tasks.
ALIKE = r"-rewards-|-radio-|-base-|-errors$|-camera$"
#: Pixels of a plane's side at least, of its frame, and the greys of both.
SIDE, FRAME, WHITE, GREY = 120, 4, 255, 200


class Harder(NamedTuple):
    """An episode of a harder task."""

    policy: str
    scenario: str
    settings: dict[str, Any]
    caption: str
    """A sentence about the picture."""


#: The episodes of harder tasks by name.
HARDER = {
    "failures": Harder(
        "frontier",
        "small-floors",
        {"team": 4, "failures.stops": ((1, 40), (3, 60))},
        "With `failures.stops = [[1, 40], [3, 60]]`: UAVs 1 and 3 have stopped, and the room that UAV 1 alone had seen "
        "is unknown to the team again.",
    ),
    "base-2": Harder(
        "return-to-base",
        "office-base-2",
        {},
        "What counts is what the home base, H, knows; a line joins it to a UAV in contact.",
    ),
    "base-4": Harder("return-to-base", "office-base-4", {}, "The same for four UAVs."),
    "prior": Harder(
        "prior-tour",
        "small-floors",
        {"prior.kind": "outdated"},
        "With `prior.kind = outdated`: under what is unknown, walls that only the prior map has are violet, and walls "
        "that it lacks orange. The UAVs' own maps have the prior there.",
    ),
    "errors": Harder(
        "frontier",
        "small-floors-errors",
        {},
        "Free cells that the team's map shows as occupied are red, occupied ones that it shows as free pink.",
    ),
    "camera": Harder(
        "frontier",
        "small-floors-camera",
        {},
        "UAVs see ahead, 90 degrees wide, and their eight neighbours; shaded cells are in view.",
    ),
}


@cache
def pictures() -> dict[str, bytes]:
    """Return the PNG files of the gallery by name."""
    found = {}
    for name in scenarios():
        flight = flown(PILOT, name)
        found[f"scenario-{name}"] = paint(scene_of(flight.world, 0, flight.trails))
    for name, task in HARDER.items():
        flight = flown(task.policy, task.scenario, settings=task.settings)
        found[f"harder-{name}"] = paint(scene_of(flight.world, 0, flight.trails))
    for name in policy_names():
        flight = flown(name, OFFICES, STEPS)
        scene = scene_of(flight.world, 0, flight.trails)
        found[f"policy-{name}"] = paint_side_by_side([SideBySide(name, scene, flight.coverage)], STEPS)
    found |= {f"observation-{name}": picture for name, picture in observations()}
    return {f"{name}.png": _png(picture) for name, picture in found.items()}


@cache
def example_report() -> bytes:
    """Return the page of a small comparison."""
    with TemporaryDirectory() as folder:
        compare(folder, policies=EXAMPLE, scenario=["thesis-team-4", "small-offices"], episodes=8, workers=0)
        return (Path(folder) / "report.html").read_bytes()


def scenarios() -> list[str]:
    """Return the scenarios that look different."""
    return [name for name in PRESETS if not re.search(ALIKE, name)]


def flown(
    policy: str, scenario: str, most: int | None = None, settings: Mapping[str, Any] = NO_SETTINGS
) -> WatchedFlight:
    """Fly one episode until most is known, or ``most`` steps."""
    request = ComparisonRequest(policies=[policy], scenario=[scenario], episodes=1, seed=SEED, settings=settings)
    flight = WatchedFlight(plan(request), 0, most)
    for _ in flight.moments():
        if flight.coverage[-1] >= TYPICAL:
            break
    return flight


def observations() -> Iterator[tuple[str, NDArray[np.uint8]]]:
    """Yield observations of one moment, plane beside plane."""
    world = flown(PILOT, OFFICES).world
    for name in OBSERVATIONS:
        encoder = make_encoder(name, world.briefing(0, 0))
        seen = encoder.observation(world.view(0, 0))
        parts = seen.values() if isinstance(seen, dict) else [seen]
        planes = [plane for part in parts if part.ndim > 1 for plane in part.reshape(-1, *part.shape[-2:])]
        if planes:
            yield name, _beside(planes)


def _beside(planes: list[NDArray[np.float64]]) -> NDArray[np.uint8]:
    """Return planes side by side, each as large as whole pixels allow; the darker, the more."""
    large = []
    for plane in planes:
        grey = np.uint8(WHITE * (1.0 - plane / max(float(plane.max()), 1e-9)))
        large.append(np.kron(grey, np.ones((max(1, -(-SIDE // len(plane))),) * 2, np.uint8)))
    height = max(map(len, large))
    framed = [
        np.pad(each, ((FRAME, FRAME + height - len(each)), (FRAME, FRAME)), constant_values=GREY) for each in large
    ]
    return np.repeat(np.concatenate(framed, axis=1)[..., None], 3, axis=2)


def gallery_page() -> str:
    """Return the page that shows the pictures."""
    lines = ["# Gallery", "", f"All episodes have the seed {SEED}, and are shown when {TYPICAL:.0%} are known.", ""]
    lines += ["[The playground](playground.html): draw a map and watch a team explore it.", ""]
    lines += [f"[A report](example-report.html), as every comparison writes one: {', '.join(EXAMPLE)}.", ""]
    lines += [f"## Scenarios, flown by `{PILOT}`", ""]
    lines += _grid((f"scenario-{name}", f"`{name}`") for name in scenarios())
    lines += ["## [Harder tasks](harder-tasks.md)", ""]
    lines += _grid(
        (f"harder-{name}", f"`{one.policy}` on `{one.scenario}`. {one.caption}") for name, one in HARDER.items()
    )
    lines += [f"## Policies, in `{OFFICES}`", ""]
    lines += _grid((f"policy-{name}", f"`{name}`") for name in policy_names())
    lines += ["## Observations", ""]
    lines += [f"Of UAV 0 in the same moment; dark is more. The planes of `channels` are {', '.join(PLANES)}.", ""]
    seen = [name.removesuffix(".png") for name in pictures() if name.startswith("observation-")]
    for name in seen:
        lines += [f"### {name.partition('-')[2]}", "", f"![{name}](gallery/{name}.png)", ""]
    return "\n".join(lines)


def _grid(shown: Iterable[tuple[str, str]]) -> list[str]:
    """Return the lines of pictures side by side, given by name and caption; a click opens the picture alone."""
    lines = ['<div class="pictures" markdown>', ""]
    for name, caption in shown:
        lines += ["<figure markdown>", f"[![{name}](gallery/{name}.png)](gallery/{name}.png)"]
        lines += ["<figcaption markdown>", "", caption, "", "</figcaption>", "</figure>", ""]
    return [*lines, "</div>", ""]


def _png(picture: NDArray[np.uint8]) -> bytes:
    file = io.BytesIO()
    Palette([picture]).image(picture).save(file, format="PNG", optimize=True)
    return file.getvalue()

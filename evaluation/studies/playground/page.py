"""Writes the playground: one HTML file with the scripts and some maps of the generators in it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from indoor_explorers.env import FREE, scenario
from indoor_explorers.env.files import write_whole
from indoor_explorers.env.rendering.palette import uav_colours
from indoor_explorers.env.simulation.spawns import draw_floorplan

#: The files of the page.
FILES = Path(__file__).parent
#: The maps to start from: a preset, what differs from it, and the seed.
MAPS = {
    "a room with obstacles": ("thesis-obstacles", {}, 3),
    "an empty room": ("thesis-open", {}, 0),
    "rooms": ("small-rooms", {"map.height": 30, "map.width": 36}, 2),
    "offices": ("small-offices", {"map.height": 30, "map.width": 40}, 1),
    "a cave": ("small-cave", {"map.height": 32, "map.width": 36}, 4),
    "a maze": ("small-maze", {"map.height": 25, "map.width": 33, "map.corridor": 1}, 5),
}


def write_playground(path: Path) -> None:
    """Write the page, which needs neither other files nor a network."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, playground())


@lru_cache(maxsize=1)
def playground() -> str:
    """Return the page as text."""
    environment = Environment(
        loader=PackageLoader(__package__, "."), autoescape=True, undefined=StrictUndefined, keep_trailing_newline=True
    )
    colours = ["#{:02x}{:02x}{:02x}".format(*colour) for colour in uav_colours(4).tolist()]
    scripts = {name: Markup(script(name)) for name in ("world", "policies", "page")}
    return environment.get_template("page.html").render(
        maps=maps(), colours=colours, css=Markup((FILES / "page.css").read_text("utf-8")), **scripts
    )


def script(name: str) -> str:
    """Return one of the page's scripts: ``world``, ``policies`` or ``page``."""
    return (FILES / f"{name}.js").read_text("utf-8")


def maps() -> dict[str, str]:
    """Return the maps by name as lines of ``#`` and ``.``."""
    return {name: _text(preset, dict(settings), seed) for name, (preset, settings, seed) in MAPS.items()}


def _text(preset: str, settings: dict[str, int], seed: int) -> str:
    truth = draw_floorplan(scenario(preset).with_settings(settings), seed).truth
    return "\n".join("".join(row) for row in np.where(truth == FREE, ".", "#"))

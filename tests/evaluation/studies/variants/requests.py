"""A small room, settings of tiny trainings, and requests of studies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.studies.variants.study import StudyRequest

SHORT = "prior_notes=2000 total_steps=200 environments=4 warmup_steps=40 batch=8 replay_steps=400 evaluation_every=100"
SMALL = "evaluation_episodes=2 device=cpu network.width=16 observation.tours=false observation.coarse=0"
TINY = [*SHORT.split(), *SMALL.split()]


def small_room(folder: Path) -> Path:
    """Write the scenario of a small room and return its path."""
    path = folder / "room.toml"
    small = {"map.height": 8, "map.width": 8, "budget": 60}
    path.write_text(PRESETS["thesis-open"].with_settings(small).model_copy(update={"name": "room"}).to_toml())
    return path


def study_request(out: Path, **asked: Any) -> StudyRequest:
    """Return a request of two trainings of each variant of ``dddqn``, with other values where ``asked``."""
    default: dict[str, Any] = {"learner": "dddqn", "scenario_name": "thesis-open", "scenario": PRESETS["thesis-open"]}
    default |= {"patterns": ("*",), "settings": {}, "seeds": 2, "jobs": 1, "episodes": 6, "command": ""}
    return StudyRequest(out=out, **(default | asked))

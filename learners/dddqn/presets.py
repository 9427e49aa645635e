"""Presets: the trainings of the weights for rooms that ship, and others. Each has a scenario, settings and a seed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple


class Preset(NamedTuple):
    """One training."""

    scenario: str
    """Name of the scenario."""
    settings: Mapping[str, Any]
    """Settings that differ from the defaults of the training's configuration, by dotted keys."""
    seed: int
    """Seed of the whole training."""


#: The network sees the map only, without planner features.
_MAP_ALONE = {"observation.gains": False, "observation.tours": False}

#: With tour features: a high initial discount factor, few random moves, and a pull that keeps near-ties on a tour.
_KEEN = {
    "updates_per_tick": 2,
    "gamma_first": 0.995,
    "epsilon_first": 0.1,
    "action_gap": 0.5,
    "network.tour_pull": 0.03,
}

#: The empty room: steps cost more until 90 % are known.
_OPEN = _KEEN | {"total_steps": 1_000_000, "reward_early_step": -0.25, "evaluation_every": 96_000}

PRESETS: dict[str, Preset] = {
    "thesis-open": Preset("thesis-open", _OPEN, 1),
    #: Some 10,000 episodes with a quarter of the updates; these weights do not ship.
    "thesis-open-quick": Preset(
        "thesis-open",
        _OPEN
        | {
            "total_steps": 520_000,
            "environments": 128,
            "updates_per_tick": 1,
            "evaluation_every": 260_000,
            "evaluation_episodes": 100,
        },
        1,
    ),
    "thesis-obstacles": Preset("thesis-obstacles", _KEEN | {"observation.tour_width": 24, "total_steps": 3_000_000}, 1),
    #: Moves of teams; sooner at 90 % and later at 99 % than ``thesis-obstacles``, which ``dddqn`` flies instead
    #: (DDDQN.md has the figures).
    "thesis-team": Preset(
        "thesis-team-4",
        _KEEN
        | {
            "also": [
                "thesis-team-4-radio-0",
                "thesis-team-4-radio-unlimited",
                "thesis-team-2",
                "thesis-team-4-radio-1",
                "thesis-team-2-radio-0",
                "thesis-team-2-radio-1",
                "thesis-team-2-radio-unlimited",
            ],
            "observation.layers": ["unknown", "free", "chance", "mates", "mates_past"],
            "observation.identity": True,
            "total_steps": 1_500_000,
            "updates_per_tick": 4,
            "epsilon_first": 0.25,
            "action_gap": 0.0,
            "network.tour_pull": 0.015,
            "reward_discovered": 0.03,
            "evaluation_episodes": 60,
        },
        1,
    ),
    "thesis-open-map": Preset("thesis-open", _MAP_ALONE | {"total_steps": 3_000_000}, 1),
    "thesis-obstacles-map": Preset("thesis-obstacles", _MAP_ALONE | {"total_steps": 5_000_000}, 1),
}

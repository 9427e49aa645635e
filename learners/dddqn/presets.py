"""Named trainings: presets, among them those of shipped weights for rooms, and ablations of single settings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
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


#: Settings of all ablation trainings: all are short, and compared after the same number of moves.
ABLATION_SETTINGS: Mapping[str, Any] = {"total_steps": 600_000, "evaluation_every": 48_000, "checkpoint_every": 192_000}

_LAYERS = ("unknown", "free", "chance")
_MATES = {"observation.layers": (*_LAYERS, "mates", "mates_past")}
_IDENTITY = {"observation.identity": True}

#: Changed settings by name; all others are compared with the first.
ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "full": {},
    "no-learning": {"total_steps": 1},
    "no-double": {"double": False},
    "no-dueling": {"network.dueling": False},
    "1-step": {"return_steps": 1},
    "10-step": {"return_steps": 10},
    "prioritised": {"prioritised": 0.6},
    "hard-target": {"target": "hard"},
    "no-layer-norm": {"network.layer_norm": False},
    "double-width": {"network.width": 512},
    "convolution": {"network.encoder": "convolution"},
    "attention": {"network.encoder": "attention"},
    "residual": {"network.residual_blocks": 2},
    "convolution-residual": {"network.encoder": "convolution", "network.residual_blocks": 2},
    "noisy": {"network.noisy": True, "epsilon_first": 0.0, "epsilon_last": 0.0},
    "no-mask": {"mask": False},
    "no-symmetries": {"symmetries": False},
    "no-early-reward": {"reward_early_step": 0.0},
    "high-gamma-first": {"gamma_first": 0.995},
    "gamma-0.99": {"gamma_first": 0.99, "gamma_last": 0.99},
    "no-gains": {"observation.gains": False},
    "no-tour-start": {"network.tour_cost": 0.0},
    "tour-pull": {"network.tour_pull": 0.03},
    "action-gap": {"action_gap": 0.5},
    "wide-tours": {"observation.tour_width": 24},
    "no-tours": {"observation.tours": False},
    "map-alone": {"observation.gains": False, "observation.tours": False},
    "map-alone-no-prior": {
        "observation.gains": False,
        "observation.tours": False,
        "observation.layers": ("unknown", "free"),
    },
    "no-chance": {"observation.layers": ("unknown", "free")},
    "no-coarse": {"observation.coarse": 0},
    "crop-9": {"observation.crop": 9},
    "no-sides": {"observation.sides": False},
    "no-visits": {"observation.visits": False},
    "3-frames": {"observation.frames": 3},
    "prospects": {"observation.prospects": True},
    "frontier-layers": {"observation.layers": (*_LAYERS, "frontier", "distance")},
    "identity-progress": {**_IDENTITY, "observation.progress": True},
}

#: Further ablations for the training of a team.
TEAM_ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "mates": _MATES,
    "identity": _IDENTITY,
    "mates-identity": {**_MATES, **_IDENTITY},
}


def _budget(moves: int) -> dict[str, Any]:
    """Return the settings of a training of so many moves; averaging takes the same share of each."""
    return {
        "total_steps": moves,
        "average_rate": 0.001 * 3_000_000 / moves,
        "evaluation_every": moves // 4,
        "evaluation_episodes": 100,
        "checkpoint_every": 375_000,
    }


#: Moves of the trainings, and of those of other widths and numbers of maps.
_MOVES, _MEDIUM = (46_875, 187_500, 750_000, 3_000_000), 750_000

#: Settings of the trainings of the scaling study, by name.
SCALING: Mapping[str, Mapping[str, Any]] = {
    **{f"steps-{moves}": _budget(moves) for moves in _MOVES},
    **{f"width-{width}": _budget(_MEDIUM) | {"network.width": width} for width in (64, 1024)},
    **{f"maps-{maps}": _budget(_MEDIUM) | {"map_count": maps} for maps in (16, 256, 4096)},
}

#: Its axes: names of trainings by level.
SCALING_AXES: Mapping[str, Mapping[float, str]] = {
    "moves in training": {moves: f"steps-{moves}" for moves in _MOVES},
    "units of a hidden layer": {64: "width-64", 256: f"steps-{_MEDIUM}", 1024: "width-1024"},
    "maps in training": {16: "maps-16", 256: "maps-256", 4096: "maps-4096", math.inf: f"steps-{_MEDIUM}"},
}


def flown(weights: Path) -> dict[str, Any]:
    """Return the policy, as in an experiment file, that flies trained weights without the guard."""
    return {"use": "dddqn", "parameters": {"weights": str(weights.resolve()), "guard": False}}

"""Ablations: trainings that differ from the default in one setting each."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Settings of all ablation trainings: all are short, and compared after the same number of moves.
ABLATION_SETTINGS: Mapping[str, Any] = {
    "total_steps": 600_000,
    "evaluation_every": 48_000,
    "checkpoint_every": 192_000,
}

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


def flown(weights: Path) -> dict[str, Any]:
    """Return the policy, as in an experiment file, that flies trained weights without the guard."""
    return {"use": "dddqn", "parameters": {"weights": str(weights.resolve()), "guard": False}}

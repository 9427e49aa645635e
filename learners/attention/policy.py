"""The graph attention network as a policy."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded
from indoor_explorers.env.policies.policy import TRAINED_GOAL, Policy
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.provenance import recorded_maps
from indoor_explorers.learners.attention.network import load_weights
from indoor_explorers.learners.attention.pilot import AttentionPilot
from indoor_explorers.learners.sessions.record import record_of
from indoor_explorers.learners.sessions.seeds import recorded_seeds
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS


@dataclass(frozen=True, kw_only=True)
class AttentionSac(Policy):
    """Fly from node to node of a graph of viewpoints, as a graph attention network chooses.

    ARiADNE: Cao et al., ICRA 2023, arXiv:2301.11575; trained by discrete soft actor-critic (Christodoulou 2019,
    arXiv:1910.07207) with a privileged critic (Cao et al., RA-L 2024, arXiv:2403.10833). One and more UAVs, each by its
    own map, with the same weights. Only the draws among equally near frontier cells and of deadlocks are random.

    Raises:
        InputError: ``weights`` is missing or not a file of this network.

    """

    plans_for: ClassVar[str] = TRAINED_GOAL

    weights: str
    """Path of a training's folder or weights."""
    guard: bool = True
    """Fly to the nearest frontier after a flight of six lidar ranges without new cells."""

    def __post_init__(self) -> None:
        if not self.weights:
            raise InputError("expected the folder of a training, as in attention:DIR, got none")
        load_weights(self.path)

    @property
    def path(self) -> Path:
        """The path of the weights."""
        given = expanded(self.weights)
        return given / WEIGHTS if given.is_dir() else given

    def pilot(self, briefing: Briefing) -> AttentionPilot:
        """Make the pilot of one UAV for one episode."""
        return AttentionPilot(briefing, load_weights(self.path), guard=self.guard)

    def provenance(self) -> dict[str, str]:
        """Return the hash of the weights."""
        return {"weights_sha256": hashlib.sha256(self.path.read_bytes()).hexdigest()}

    def seen_seeds(self) -> dict[str, list[range]]:
        """Return the seeds of the training."""
        return recorded_seeds(record_of(self.path))

    def seen_maps(self) -> dict[str, list[str]]:
        """Return the map files of the training."""
        return recorded_maps(record_of(self.path))


def opened(path: str, **parameters: Any) -> AttentionSac:
    """Return the policy of a trained network, ``attention:DIR``."""
    return AttentionSac(weights=path, **parameters)

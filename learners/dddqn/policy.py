"""The DDDQN as a policy: dueling double deep Q-learning with shipped weights."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.files import expanded
from indoor_explorers.env.maps.generators.thesis import ThesisMaps
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.provenance import joined
from indoor_explorers.env.search.bitsets import ROOM
from indoor_explorers.learners.dddqn.network.inference import without_network
from indoor_explorers.learners.dddqn.observation.config import WIDEST
from indoor_explorers.learners.dddqn.observation.scales import REFERENCE_RANGE
from indoor_explorers.learners.dddqn.pilot import DddqnPilot
from indoor_explorers.learners.dddqn.weights import load_weights, shipped
from indoor_explorers.learners.places.policy import DddqnPlaces
from indoor_explorers.learners.sessions.record import RecordedWeights, digest_of
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS


@dataclass(frozen=True, kw_only=True)
class Dddqn(RecordedWeights, Policy):
    """Explore with a dueling double deep Q-network.

    Mnih et al. 2015, doi:10.1038/nature14236; van Hasselt, Guez and Silver 2016, arXiv:1509.06461; Wang et
    al. 2016, arXiv:1511.06581. In rooms the UAV makes the legal move of highest value; it stays only when it can reach
    no place with a view of unknown cells. On larger maps it flies to the place of highest value, as ``dddqn-places``
    does. Everything but the guard's back-off and deadlocks is deterministic.

    Raises:
        InputError: ``weights`` is missing or not a file of this network, ``map_alone`` is given with it or without
            ``network``, or ``tour_width`` is out of range.

    """

    uses_generator: ClassVar[bool] = True
    plans_for: ClassVar[str] = "90 % and 99 %"

    weights: str | None = None
    """Name of shipped weights for rooms, or path of a training's folder or weights, which values moves; None: the
    shipped ones for the scenario."""
    map_alone: bool = False
    """Use shipped weights of a network that sees the map only, without planner features; for small rooms only."""
    tour_width: int | None = None
    """Beam width of the search for tours: a wider beam finds shorter tours and takes longer; None: the width stored
    with the weights. Without effect on networks without tour features."""
    division: bool | None = None
    """Whether teammates in a room leave each other parts with equally long tours, and keep to that division without
    contact; else cells are left to the UAV that was closer when last heard. None: as stored with the weights, which is
    off in all shipped ones. Without effect on networks without tour features."""
    network: bool = True
    """Whether the network values moves; without it the UAV follows the planner features alone, from which training
    starts: the shortest tour that was found, or the cheapest order of places."""
    guard: bool = True
    """Fly to the nearest frontier while a network that values moves makes no progress."""

    def __post_init__(self) -> None:
        if self.map_alone and self.weights is not None:
            raise InputError(f"expected weights or map_alone, got both: {self.weights!r}; leave one of them out")
        if self.tour_width is not None and self.tour_width not in range(1, WIDEST + 1):
            raise InputError(f"expected tour_width from 1 to {WIDEST}, got {self.tour_width!r}")
        if self.map_alone and not self.network:
            raise InputError("expected map_alone with a network, as it has no planner features, got network off")
        for path in self._paths().values():
            load_weights(path)

    def _paths(self) -> dict[str, Path]:
        """Return the paths of the weights of moves that this policy may fly, by name."""
        known = shipped()
        if self.weights is None:
            return {name: known[name] for name in (ROOMS_ALONE if self.map_alone else ROOMS)}
        if self.weights in known:
            return {self.weights: known[self.weights]}
        path = expanded(self.weights)
        if path.is_dir():
            return {self.weights: path / WEIGHTS}
        if "/" not in self.weights and path.suffix != ".safetensors":
            raise InputError(
                f"unknown weights {self.weights!r} (expected a name or a path){did_you_mean(self.weights, known)}"
            )
        return {self.weights: path}

    @property
    def _places(self) -> DddqnPlaces | None:
        """The policy that flies large maps; None where the weights that were asked for fly all of them."""
        return None if self.weights is not None or self.map_alone else DddqnPlaces(network=self.network)

    def suited(self, briefing: Briefing) -> str:
        """Return the name of the weights that a UAV with this briefing flies.

        Raises :class:`InputError` if ``map_alone`` is set and there are no such weights for the scenario.
        """
        if self.weights is not None:
            return self.weights
        return suited_alone(briefing) if self.map_alone else suited(briefing)

    def is_outside_training(self, briefing: Briefing) -> bool:
        """Tell whether the weights chosen for a scenario were trained with another lidar range."""
        return self.weights is None and _is_room(briefing) and briefing.lidar_range != REFERENCE_RANGE

    def provenance(self) -> dict[str, str]:
        """Return the hashes of the weights, and which of them are flown in which scenarios."""
        hashes = {name: digest_of(path) for name, path in self._paths().items()}
        if self.weights is not None:
            return {"weights_sha256": hashes[self.weights]}
        facts = {f"weights_{name}_sha256": digest for name, digest in hashes.items()}
        places = self._places
        if places is None:
            return facts | {"weights_for": SUITED_ALONE}
        on_places = places.provenance()
        facts |= {f"weights_{LARGE}_sha256": on_places.pop("weights_sha256")} | on_places
        return facts | {"weights_for": SUITED}

    def weights_paths(self) -> list[Path]:
        """Return the paths of the weights of moves that this policy may fly."""
        return list(self._paths().values())

    def seen_maps(self) -> dict[str, list[str]]:
        """Return the map files that the trainings of these weights flew, of those of places too where they may fly."""
        places = self._places
        return super().seen_maps() if places is None else joined([super().seen_maps(), places.seen_maps()])

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV for one episode."""
        name, places = self.suited(briefing), self._places
        if places is not None and name == LARGE:
            return places.pilot(briefing)
        loaded = load_weights(self._paths()[name])
        changed = {"tour_width": self.tour_width, "division": self.division}
        changed = {name: value for name, value in changed.items() if value is not None}
        loaded = loaded._replace(observation=loaded.observation.model_copy(update=changed))
        if not self.network:
            loaded = loaded._replace(weights=without_network(loaded.weights, loaded.layout))
        return DddqnPilot(briefing, loaded, guard=self.guard, other_range=self.is_outside_training(briefing))


#: The shipped weights of moves that are flown in rooms; with ``map_alone``; and the name of those of places.
ROOMS = ("thesis-open", "thesis-obstacles")
ROOMS_ALONE = ("thesis-open-map", "thesis-obstacles-map")
LARGE = "places"

#: The rule of :func:`suited` in words, for the provenance.
SUITED = (
    "up to 16x16 cells thesis-open for one UAV in rooms without obstacles with a lidar of range 3, else "
    "thesis-obstacles, also for teams and other ranges; elsewhere places"
)

#: The rule of :func:`suited_alone` in words, for the provenance.
SUITED_ALONE = "thesis-open-map for one UAV in rooms without obstacles, else thesis-obstacles-map"


def suited(briefing: Briefing) -> str:
    """Return the name of the shipped weights for a scenario.

    In rooms, ``thesis-obstacles`` flies lidar ranges that nothing was trained on: measured from 1 to 8 cells, it was
    the best of the shipped sets, or level with it (DDDQN.md).
    """
    if not _is_room(briefing):
        return LARGE
    alone = briefing.lidar_range == REFERENCE_RANGE and briefing.team == 1 and _is_empty(briefing)
    return "thesis-open" if alone else "thesis-obstacles"


def suited_alone(briefing: Briefing) -> str:
    """Return the name of the shipped weights for a scenario, of a network that sees the map only.

    Raises :class:`InputError` if the map or the lidar range is too large.
    """
    if not _is_room(briefing) or briefing.lidar_range != REFERENCE_RANGE:
        height, width = briefing.shape
        raise InputError(
            f"expected a map of up to {ROOM}x{ROOM} cells and a lidar range of {REFERENCE_RANGE:g} for weights that "
            f"see the map alone, got {height}x{width} and {briefing.lidar_range:g}; fly without map_alone"
        )
    return "thesis-open-map" if briefing.team == 1 and _is_empty(briefing) else "thesis-obstacles-map"


def _is_room(briefing: Briefing) -> bool:
    return max(briefing.shape) <= ROOM and briefing.level_count == 1


def _is_empty(briefing: Briefing) -> bool:
    return isinstance(briefing.generator, ThesisMaps) and briefing.generator.obstacles == 0


def opened(path: str, **parameters: Any) -> Dddqn:
    """Return the policy of a trained network, ``dddqn:DIR``, or of shipped weights, ``dddqn:NAME``."""
    return Dddqn(weights=path, **parameters)

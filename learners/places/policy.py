"""The policy ``dddqn-places``, and its pilot, which flies to the place of highest value."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.policies.policy import Pilot, Policy
from indoor_explorers.env.policies.view import Briefing
from indoor_explorers.env.provenance import joined, record_of, recorded_maps
from indoor_explorers.learners.places.network import load_weights, without_network
from indoor_explorers.learners.places.option_pilots import with_options
from indoor_explorers.learners.places.pilot import PlacesPilot
from indoor_explorers.learners.sessions.record import digest_of
from indoor_explorers.planners.toolbox.networks.weights_file import weights_path
from indoor_explorers.planners.toolbox.parameters import bounded
from indoor_explorers.planners.toolbox.pockets.outlook import LevelEstimateUser

#: The weights that ship.
SHIPPED = Path(__file__).parent / "weights" / "places.safetensors"
#: Those that value options beside places.
SHIPPED_OPTIONS = SHIPPED.with_name("options.safetensors")
#: The file of the weights in the folder of a training.
NAME = "places.safetensors"


@dataclass(frozen=True, kw_only=True)
class DddqnPlaces(LevelEstimateUser, Policy):
    """Fly to the frontier cluster that a dueling network values most, on maps of any size.

    Each cluster is a place; the network sees all of them, the free space expected behind them, and the costs of the
    orders in which ``frontier-predictive`` would visit them (:mod:`indoor_explorers.learners.places.scene`). It is
    trained by policy iteration with double and dueling estimates
    (:mod:`indoor_explorers.learners.places.learning`). Only the draws of deadlocks between UAVs are random.

    Weights that were trained with options value besides places what else a UAV can do
    (:class:`~indoor_explorers.learners.places.options.Option`): report to a home base, stay as a relay, close a loop.
    In terms of R. S. Sutton, D. Precup, S. Singh, "Between MDPs and semi-MDPs", Artificial Intelligence 112, 1999,
    places are options too.

    Double estimation: H. van Hasselt, "Double Q-learning", NeurIPS 2010; dueling networks: Wang et al. 2016,
    arXiv:1511.06581; advantages: Schulman et al. 2016, arXiv:1506.02438, and Pan et al. 2022, arXiv:2109.06093; layers
    for sets: Zaheer et al. 2017, arXiv:1703.06114; the mean of weights: Izmailov et al. 2018, arXiv:1803.05407.

    Raises:
        InputError: ``weights`` is missing or not a file of this network, is given with ``options``, or ``lookouts`` is
            negative.

    """

    plans_for: ClassVar[str] = "90 % and 99 %"

    weights: str | None = None
    """Path of a training's folder or weights; None: the shipped ones."""
    options: bool = False
    """Fly the shipped weights that value options beside places: one network for plain tasks and for harder ones."""
    network: bool = True
    """Whether the network values places; without it the UAV follows the costs of ``frontier-predictive``."""
    sector: float = bounded(0.0, least=0)
    """Preference for the UAV's own sector of the map while teammates were never heard; see :class:`OutOfContact`."""
    lookouts: int | None = bounded(None, least=0)
    """Most places near the UAV that need not be at a frontier, as ``frontier-predictive`` has them; None: as in the
    training of the weights, 0 for the shipped ones."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.options and self.weights is not None:
            raise InputError(f"expected weights or options, got both: {self.weights!r}; leave one of them out")
        load_weights(self.path)

    @property
    def path(self) -> Path:
        """The path of the weights."""
        return weights_path(self.weights, SHIPPED_OPTIONS if self.options else SHIPPED, NAME)

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV for one episode."""
        loaded = load_weights(self.path)
        if self.lookouts is not None:
            loaded = loaded._replace(lookouts=self.lookouts)
        network = loaded if self.network else without_network(loaded)
        pilot = PlacesPilot(briefing, network, self.sector, self.estimate_files)
        return with_options(pilot, self, self.estimate_files)

    def provenance(self) -> dict[str, str]:
        """Return the hashes of the network's weights and of those of the estimates."""
        return super().provenance() | {"weights_sha256": digest_of(self.path)}

    def seen_maps(self) -> dict[str, list[str]]:
        """Return the maps that the network and the estimates were learned from."""
        return joined([super().seen_maps(), recorded_maps(record_of(self.path))])


def opened(path: str, **parameters: Any) -> DddqnPlaces:
    """Return the policy of a trained network, ``dddqn-places:DIR``."""
    return DddqnPlaces(weights=path, **parameters)

"""GSO: UAVs fly to the brighter ones of the glowworms in their decision range (Krishnanand & Ghose 2009)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell, Distances
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.coordination.independent_pilot import IndependentPilot
from indoor_explorers.planners.toolbox.frontiers.clusters import nearest_cells
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains
from indoor_explorers.planners.toolbox.parameters import GainParameters, bounded

#: Distance, in lidar ranges, within which a frontier cluster is the same glowworm as one before the map grew.
SAME = 0.5

Numbers = NDArray[np.float64]


@renamed(depth="decay_length")
@dataclass(frozen=True, kw_only=True)
class Gso(GainParameters, Policy):
    """Fly to a frontier cluster drawn by its light among the brighter ones in an adaptive decision range.

    Frontier clusters are glowworms that stay, UAVs glowworms that move. Each time the map grows, a cluster's luciferin
    becomes (1 - decay) l + enhancement J, J its view gain (equation 1 of the paper), in which near and isolated unknown
    cells count more (:class:`WeightedGains`). A UAV needs a goal when its last one is explored. Its neighbours are the
    clusters that are at most its decision range r away, as path lengths, and brighter than itself; it draws j with
    probability proportional to (l_j - l_i)^sharpness (equation 2), and flies there. Then r becomes
    r + adaption (wanted - number of neighbours), at least 0 and at most ``sensor`` (equation 4): few frontiers widen
    the range, many narrow it. With no neighbours at all, where a glowworm of the paper would wait for its range to
    grow, the range grows at once, and beyond the sensor range the UAV flies to its nearest frontier (``out_of_range``
    in the tally). The light of a cluster in the lidar range of a linked teammate's goal is dimmed, and those near
    teammates out of contact are left to them by :class:`OutOfContact`.

    Differences: frontier clusters take the place of most of the swarm; a UAV flies the whole path to a neighbour, not
    one step, since new draws at every step make it oscillate; UAVs do not attract each other, since the cells where
    they would meet are known already; a new glowworm starts with the luciferin at which its update rests, not at a
    common l_0; and the draw has a ``sharpness``, 1 in the paper. With ``wanted`` 5, ``adaption`` .08, ``sharpness`` 1
    and ``start`` 2 it needs up to twice the steps of nearest frontiers: it draws small clusters far away. Weakness:
    floors of rooms, where the light of a cluster says little about the space behind it.

    K. N. Krishnanand, D. Ghose, "Glowworm swarm optimization for simultaneous capture of multiple local optima of
    multimodal functions", Swarm Intelligence 3(2), 2009, doi:10.1007/s11721-008-0021-5; first in SIS 2005,
    doi:10.1109/SIS.2005.1501606. The clusters as glowworms are this project's.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    decay: float = bounded(0.4, least=0.01, most=1, tunable=(0.05, 1.0, "log"))
    """Share of its luciferin that a glowworm loses each time the map grows, above 0 and at most 1 (paper: rho)."""
    enhancement: float = bounded(0.6, least=0)
    """Luciferin gained for each weighted cell in view (paper: gamma); it scales all luciferin alike."""
    wanted: int = bounded(1, least=1, tunable=(1, 8))
    """Neighbours that the decision range adapts to (paper: n_t, 5). With more, UAVs fly past near clusters."""
    adaption: float = bounded(0.5, least=0, tunable=(0.05, 2.0, "log"))
    """Change of the decision range for each neighbour too many or too few, in lidar ranges (paper: beta, .08)."""
    sensor: float = bounded(8.0, least=0, tunable=(1.0, 20.0, "log"))
    """Largest decision range, in lidar ranges (paper: r_s)."""
    start: float = bounded(0.5, least=0, tunable=(0.25, 4.0, "log"))
    """Decision range at first, in lidar ranges (paper: the sensor range)."""
    sharpness: float = bounded(8.0, least=0, tunable=(1.0, 32.0, "log"))
    """Exponent of the luciferin difference in the draw: 1 is the paper's, large ones take the brightest neighbour."""
    dimming: float = bounded(0.8, least=0, most=1, tunable=(0.0, 1.0))
    """Share of its view gain that a cluster loses for each linked teammate that flies near it, 0 to 1."""

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return GlowwormPilot(briefing, self)


def brightened(luciferin: Numbers, fitness: Numbers, decay: float, enhancement: float) -> Numbers:
    """Return the luciferin of (K,) glowworms after an update by their fitness, (K,)."""
    return (1.0 - decay) * luciferin + enhancement * fitness


def brighter(luciferin: Numbers, own: float, steps: Distances, reach: float) -> NDArray[np.int64]:
    """Return the indices of the neighbours: glowworms at most ``reach`` steps away and brighter than ``own``."""
    return np.flatnonzero((steps <= reach) & (luciferin > own))


def adapted(reach: float, neighbours: int, wanted: int, change: float, largest: float) -> float:
    """Return the next decision range, in cells, after a decision with ``neighbours`` neighbours."""
    return min(largest, max(0.0, reach + change * (wanted - neighbours)))


def drawn(weights: Numbers, rng: np.random.Generator) -> int:
    """Return an index drawn in proportion to (K,) weights that are not all 0."""
    return int(
        np.searchsorted(np.cumsum(weights / weights.sum()), rng.random(), side="right").clip(0, len(weights) - 1)
    )


class GlowwormPilot(IndependentPilot):
    """Keep the luciferin of the frontier clusters, and draw one of the brighter neighbours."""

    changes_levels: ClassVar[bool] = True

    def __init__(self, briefing: Briefing, policy: Gso) -> None:
        super().__init__(briefing)
        self._policy = policy
        self._gains = WeightedGains(briefing.shape, self.lidar, policy.decay_length, policy.isolation)
        self._cells = np.empty(0, np.int32)
        self._luciferin = np.empty(0)
        self._reach = min(policy.start, policy.sensor) * self._lidar

    def on_map_growth(self, view: View) -> None:
        """Update the luciferin of all glowworms; new ones start with that at which the update rests."""
        policy = self._policy
        cells, steps = nearest_cells(self.steps_from(view, view.cell), self.clusters(view))
        cells = cells[steps < UNREACHABLE]
        fitness = self._fitness(view, cells)
        before = self._before(cells, policy.enhancement / policy.decay * fitness)
        self._cells, self._luciferin = cells, brightened(before, fitness, policy.decay, policy.enhancement)

    def chosen(self, view: View) -> Cell | None:
        """Draw a neighbour, and adapt the decision range; None if there is none in the sensor range."""
        policy, largest = self._policy, self._policy.sensor * self._lidar
        steps = self.steps_from(view, view.cell).ravel()[self._cells]
        light = self._luciferin * self.left_by_others(view, self._cells, steps)
        own = policy.enhancement / policy.decay * self._gains.at(view.belief, self.paths.flat([view.cell]))[0]
        light[self.near_banned(view, self._cells) | (steps == 0)] = -1.0
        change = policy.adaption * self._lidar
        near = brighter(light, own, steps, self._reach)
        while len(near) == 0 and self._reach < largest and change > 0:
            self._reach = adapted(self._reach, 0, policy.wanted, change, largest)
            near = brighter(light, own, steps, self._reach)
        self._reach = adapted(self._reach, len(near), policy.wanted, change, largest)
        if len(near) == 0:
            return None
        difference = light[near] - own
        self.consider(
            self._cells[near], "luciferin; brighter ones are drawn more often", light[near], steps=steps[near]
        )
        chosen = near[drawn((difference / difference.max()) ** policy.sharpness, self.rng)]
        return divmod(int(self._cells[chosen]), self.paths.width)

    def _fitness(self, view: View, cells: NDArray[np.int32]) -> Numbers:
        """Return the view gains of (K,) flat cells, dimmed near the goals of linked teammates, (K,)."""
        return self._gains.at(view.belief, cells) * self.not_dimmed(view, cells, self._policy.dimming)

    def _before(self, cells: NDArray[np.int32], at_rest: Numbers) -> Numbers:
        """Return the luciferin of the glowworms that were at (K,) flat cells before, ``at_rest`` for new ones, (K,)."""
        if len(self._cells) == 0 or len(cells) == 0:
            return at_rest
        away = np.hypot.reduce(self.coordinates(cells)[:, None] - self.coordinates(self._cells)[None], axis=-1)
        nearest = away.argmin(axis=1)
        known = away[np.arange(len(cells)), nearest] <= SAME * self._lidar
        return np.where(known, self._luciferin[nearest], at_rest)

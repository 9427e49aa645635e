"""ACO: UAVs lay pheromone that keeps ants away, and draw frontiers by it and by their worth (De Rango et al. 2017)."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import UNREACHABLE
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.policies.policy import ALL_CELLS, Pilot, Policy
from indoor_explorers.env.policies.renamed import renamed
from indoor_explorers.env.policies.view import Briefing, View
from indoor_explorers.planners.toolbox.coordination.out_of_contact import OutOfContact
from indoor_explorers.planners.toolbox.frontiers.clusters import nearest_cells
from indoor_explorers.planners.toolbox.information.view_gain import WeightedGains
from indoor_explorers.planners.toolbox.navigation.goal_pilot import GoalPilot
from indoor_explorers.planners.toolbox.navigation.teammates import linked, message_of, sent_goal
from indoor_explorers.planners.toolbox.parameters import (
    DiscountParameters,
    GainParameters,
    GoalBonusParameters,
    ReplanParameters,
    bounded,
)

#: Distance within which a cluster counts as at the current goal, in lidar ranges.
SAME = 0.5

Numbers = NDArray[np.float64]


@renamed(depth="decay_length", rate="discount_rate", hold="goal_bonus")
@dataclass(frozen=True, kw_only=True)
class Aco(GainParameters, DiscountParameters, GoalBonusParameters, ReplanParameters, Policy):
    """Fly to a frontier cluster with much to see and little pheromone, by the transition rule of ant colonies.

    Pheromone says where UAVs are and where they are about to be, and repels. At each step a UAV lays ``amount`` times
    e^(-r / spread) on every cell r away and at most a lidar range away: around itself, around its goal, around the
    linked teammates and around their goals, which they send. Then all pheromone evaporates by a share. When a goal is
    explored or the map has grown for some time, the UAV chooses among the frontier clusters j with the weights

        (1 + pheromone_j)^-repulsion * worth_j^attraction,    worth_j = sqrt(gain_j) e^(-discount_rate d_j / R)

    with R the lidar range and d_j the path length: with probability ``greed`` the one of largest weight, and otherwise
    one drawn in proportion to them, the pseudo-random proportional rule of ant colony systems. In a gain, near and
    isolated unknown cells count more (:class:`WeightedGains`). Each UAV keeps its own field of pheromone: it never
    learns of pheromone laid out of contact, and clusters near those teammates are left to them by
    :class:`OutOfContact`. There is no other coordination: linked teammates separate because each knows the others'
    cells and goals.

    The repelling pheromone is that of the exploration by De Rango et al., in which a robot lays it where it senses and
    goes where there is least; in colonies that look for shortest paths it attracts. Differences: the choice is of
    frontier clusters, by worth as well, not of a neighbouring cell, since pheromone alone does not lead a UAV to a
    distant pocket; a UAV's own pheromone has a weight, ``own``, since its track leads along pockets that are worth
    finishing; goals are marked as well.

    F. De Rango, N. Palmieri, X.-S. Yang, S. Marano, "Swarm robotics in wireless distributed protocol design for
    coordinating robots involved in cooperative tasks", Soft Computing 22, 2018, doi:10.1007/s00500-017-2819-9. The
    transition rule: M. Dorigo, L. M. Gambardella, "Ant colony system", IEEE Transactions on Evolutionary Computation
    1(1), 1997, doi:10.1109/4235.585892.
    """

    plans_for: ClassVar[str] = ALL_CELLS

    amount: float = bounded(1.0, least=0, tunable=(0.1, 10.0, "log"))
    """Pheromone that is laid at a place in a step."""
    spread: float = bounded(1.0, least=0.01, tunable=(0.25, 4.0, "log"))
    """Distance at which 1 / e of it is laid, in lidar ranges."""
    evaporation: float = bounded(0.1, least=0, most=1, tunable=(0.01, 1.0, "log"))
    """Share of the pheromone that evaporates in a step, 0 to 1."""
    own: float = bounded(0.1, least=0, tunable=(0.0, 1.0))
    """Weight of the pheromone that a UAV lays for itself, relative to that of teammates."""
    repulsion: float = bounded(4.0, least=0, tunable=(0.0, 10.0))
    """Exponent of the pheromone in the transition rule; 0 ignores it."""
    attraction: float = bounded(4.0, least=0, tunable=(0.5, 16.0, "log"))
    """Exponent of the worth in the transition rule (ant colony system: beta)."""
    greed: float = bounded(0.9, least=0, most=1, tunable=(0.0, 1.0))
    """Probability of taking the cluster of largest weight instead of a draw, 0 to 1 (ant colony system: q_0)."""
    discount_rate: float = 1.0
    isolation: float = 16.0
    period: float = 0.3

    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV."""
        return AntPilot(briefing, self)


class Pheromone:
    """The pheromone on a map as one UAV knows it, (H, W).

    Args:
        levels: The size of the map.
        radius: Distance up to which pheromone is laid around a place, in cells.
        spread: Distance at which 1 / e of it is laid, in cells.

    """

    def __init__(self, levels: Levels, radius: float, spread: float) -> None:
        self.field = np.zeros(levels.shape)
        self._levels, self._volume = levels, levels.volume(self.field, writeable=True)
        self._reach = ceil(radius)
        away = np.arange(-self._reach, self._reach + 1)
        far = np.hypot(away[:, None, None], np.hypot(away[:, None], away))
        self._stamp = np.where(far <= radius, np.exp(-far / spread), 0.0)

    def lay(self, cell: Cell, amount: float) -> None:
        """Lay pheromone around a cell, above and below it, too."""
        place = self._levels.voxel(cell)
        part = self._volume[tuple(slice(max(0, at - self._reach), at + self._reach + 1) for at in place)]
        begins = [max(0, self._reach - at) for at in place]
        part += amount * self._stamp[tuple(map(slice, begins, np.add(begins, part.shape)))]

    def evaporate(self, share: float) -> None:
        """Let a share of all pheromone evaporate."""
        self.field *= 1.0 - share


def preferences(pheromone: Numbers, worth: Numbers, repulsion: float, attraction: float) -> Numbers:
    """Return the weights of the transition rule for (K,) places, (K,), the largest 1."""
    logs = attraction * np.log(np.maximum(worth, 1e-300)) - repulsion * np.log1p(pheromone)
    return np.asarray(np.exp(logs - logs.max()))


def transition(weights: Numbers, greed: float, rng: np.random.Generator) -> int:
    """Return the index of a place by the pseudo-random proportional rule from (K,) weights, the largest 1."""
    if rng.random() < greed:
        return int(weights.argmax())
    return int(
        np.searchsorted(np.cumsum(weights), rng.random() * weights.sum(), side="right").clip(0, len(weights) - 1)
    )


class AntPilot(GoalPilot):
    """Lay pheromone at each step, and choose clusters by it."""

    changes_levels: ClassVar[bool] = True
    straight = True

    def __init__(self, briefing: Briefing, policy: Aco) -> None:
        super().__init__(briefing)
        self._policy, self._lidar = policy, float(briefing.lidar_range)
        self._gains = WeightedGains(briefing.shape, self.lidar, policy.decay_length, policy.isolation)
        self._pheromone = Pheromone(briefing.levels, self._lidar, policy.spread * self._lidar)
        self._out_of_contact = OutOfContact(briefing)
        self.replan_period = self.steps_in(policy.period)

    def act(self, view: View) -> int:
        """Lay pheromone, then fly on or choose."""
        policy = self._policy
        self._pheromone.evaporate(policy.evaporation)
        for cell in filter(None, (view.cell, self.goal)):
            self._pheromone.lay(cell, policy.own * policy.amount)
        for mate in linked(view):
            for cell in filter(None, (mate.cell, sent_goal(mate))):
                self._pheromone.lay(cell, policy.amount)
        return super().act(view)

    def choose(self, view: View) -> Cell | None:
        """Return the nearest cell of the cluster that the transition rule picks."""
        cells, steps = nearest_cells(self.steps_from(view, view.cell), self.clusters(view))
        fine = (steps < UNREACHABLE) & ~self.near_banned(view, cells)
        cells, steps = cells[fine], steps[fine]
        goal = None
        if len(cells):
            policy, smell = self._policy, self._pheromone.field.ravel()[cells]
            worth = self._worth(view, cells, steps)
            weights = preferences(smell, worth, policy.repulsion, policy.attraction)
            self.consider(cells, "weight of the transition rule", weights, worth=worth, pheromone=smell, steps=steps)
            goal = divmod(int(cells[transition(weights, policy.greed, self.rng)]), self.paths.width)
        self.message = message_of(goal)
        return goal

    def _worth(self, view: View, cells: NDArray[np.int32], steps: NDArray[np.int32]) -> Numbers:
        """Return the worth of (K,) flat cells, ``steps`` away, without pheromone, (K,)."""
        left = self._out_of_contact.at_cells(view, cells, steps, self.steps_from)
        worth = (
            left
            * np.sqrt(self._gains.at(view.belief, cells))
            * np.exp(-self._policy.discount_rate / self._lidar * steps)
        )
        return np.asarray(self.goal_factors(self.goal, cells, SAME * self._lidar, self._policy.goal_bonus) * worth)

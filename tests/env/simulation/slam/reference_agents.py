"""Agents of a slow world whose sensors and poses err, from the rules that the documents state.

Maps are summed anew whenever they are asked for: over all scans that a map holder has, where it takes them to be made.
Holders are the agents' numbers and ``"base"``; the pose of a scan is a cell.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.grid.cells import FREE, OCCUPIED, UNKNOWN
from indoor_explorers.env.grid.randomness import Stream, stream_key
from indoor_explorers.env.simulation.state import End
from tests.env.sensing.reference import crosses
from tests.env.simulation.slam.reference_scans import DIRECTIONS, SlowScans, half_up, uniform


@dataclass
class Uav:
    """One agent. Lists have an entry for each of its scans; the last one belongs to where it is."""

    cell: Cell
    believed: Cell
    headings: list[int]
    end: int = End.FLYING
    bumps: list[int] = field(default_factory=lambda: [-1])
    ways: list[int] = field(default_factory=lambda: [0])
    variances: list[np.float32] = field(default_factory=lambda: [np.float32(0)])
    scanned_from: list[Cell] = field(default_factory=list)
    first_visits: dict[Cell, int] = field(default_factory=dict)
    listed: set[Cell] = field(default_factory=set)
    visited: set[Cell] = field(default_factory=set)
    sensed: set[Cell] = field(default_factory=set)
    heard: dict[int, tuple[int, Cell]] = field(default_factory=dict)
    reward: float = 0.0
    discovered: int = 0
    received: int = 0
    collisions: int = 0
    blocked: int = 0
    path_length: int = 0
    sent_bytes: int = 0
    silent_until: int = 0
    pose_error: float = 0.0


class SlowAgents:
    """Maps, moves, scans and poses in one episode, which begins where a world has just begun."""

    def __init__(self, world, seed):
        self.scenario, self.seed, state = world.scenario, seed, world.state
        self.truth, self.counts = state.truth[0].copy(), state.counts[0].copy()
        self.needed, self.budget, self.step_number = int(state.needed[0]), int(state.budget[0]), 0
        self.base = tuple(state.base_cell[0].tolist())
        self.scans = SlowScans(self.scenario, self.truth, seed)
        cells = [tuple(cell) for cell in state.cell[0].tolist()]
        self.team = range(len(cells))
        self.uavs = [Uav(cell, cell, [self.scans.first_heading(n)]) for n, cell in enumerate(cells)]
        self.paths = {holder: {n: [] for n in self.team} for holder in (*self.team, "base")}
        """Where each holder takes each agent's scans to be made."""
        self.remaining = {n: {} for n in self.team}
        """Where the team's map has the scans of an agent that has stopped."""
        self.readings, self.links = {}, set()

    def key(self, stream):
        return stream_key(self.seed, int(stream))

    # ---- Maps

    def summed(self, poses):
        """(H, W) log-odds of scans: ``poses`` maps (agent, scan number) to where it is taken to be made."""
        log_odds = np.zeros(self.truth.shape)
        for (agent, number), pose in poses.items():
            origin = self.uavs[agent].scanned_from[number]
            for place, value in self.readings[agent, number].items():
                row, col = place[0] + pose[0] - origin[0], place[1] + pose[1] - origin[1]
                if 0 <= row < log_odds.shape[0] and 0 <= col < log_odds.shape[1]:
                    log_odds[row, col] += value
        return log_odds

    def log_odds(self, holder):
        return self.summed({(n, k): pose for n, path in self.paths[holder].items() for k, pose in enumerate(path)})

    def team_log_odds(self):
        poses = {}
        for n, uav in enumerate(self.uavs):
            kept = self.remaining[n] if uav.end == End.STOPPED else dict(enumerate(self.paths[n][n]))
            poses |= {(n, k): pose for k, pose in kept.items()}
        return self.summed(poses)

    @staticmethod
    def shown(log_odds):
        """Unknown without evidence, else what is more probable."""
        return np.where(log_odds == 0, UNKNOWN, np.where(log_odds > 0, OCCUPIED, FREE))

    def belief(self, n):
        belief = self.shown(self.log_odds(n))
        belief[self.uavs[n].believed] = FREE
        return belief

    def right(self, belief):
        """How many of the counted cells are right."""
        return int((self.counts & (belief == self.truth)).sum())

    def list_known(self, n):
        """Enter the cells that an agent has evidence of into its log; return how many were not there."""
        new = set(zip(*np.nonzero(self.log_odds(n)), strict=True)) - self.uavs[n].listed
        self.uavs[n].listed |= new
        return len(new)

    def place(self, n):
        uav = self.uavs[n]
        uav.visited.add(uav.believed)
        uav.listed.add(uav.believed)

    # ---- Moves

    def is_inside(self, cell):
        return 0 <= cell[0] < self.truth.shape[0] and 0 <= cell[1] < self.truth.shape[1]

    def clamped(self, cell):
        return tuple(min(max(k, 0), size - 1) for k, size in zip(cell, self.truth.shape, strict=True))

    def drift_draw(self, n, kind):
        return uniform(self.key(Stream.DRIFT), (self.step_number * len(self.uavs) + n) * 3 + kind)

    def act(self, n, action):
        uav, rewards, rate = self.uavs[n], self.scenario.rewards, self.scenario.drift.rate
        uav.reward += rewards.step
        heading, bump, moved = uav.headings[-1], -1, False
        if action == 5:
            heading = (heading + 1) % 4
        elif action < 4:
            heading, ahead = action, (uav.cell[0] + DIRECTIONS[action][0], uav.cell[1] + DIRECTIONS[action][1])
            if not self.is_inside(ahead) or self.truth[ahead] == OCCUPIED:
                bump, outside = action, not self.is_inside(ahead)
                uav.collisions += 1
                uav.reward += rewards.out_of_bounds if outside else rewards.collision
                if self.scenario.on_collision == "end":
                    uav.end = End.OUT_OF_BOUNDS if outside else End.COLLISION
            elif any(mate.cell == ahead and mate.end == End.FLYING for mate in self.uavs):
                uav.blocked += 1
            else:
                before, uav.cell, moved = uav.cell, ahead, True
                uav.believed = self.clamped(
                    (uav.believed[0] + DIRECTIONS[action][0], uav.believed[1] + DIRECTIONS[action][1])
                )
                if self.drift_draw(n, 0) < rate:
                    slip = DIRECTIONS[int(4 * self.drift_draw(n, 1))]
                    aside = ahead[0] + slip[0], ahead[1] + slip[1]
                    taken = any(mate.cell == aside and mate.end == End.FLYING for mate in self.uavs)
                    if self.is_inside(aside) and self.truth[aside] == FREE and not taken:
                        uav.cell = aside
                uav.path_length += abs(uav.cell[0] - before[0]) + abs(uav.cell[1] - before[1])
        uav.headings.append(heading)
        uav.bumps.append(bump)
        uav.ways.append(uav.ways[-1] + moved)
        uav.variances.append(np.float32(float(uav.variances[-1]) + rate * moved))

    def sense(self, n):
        uav, number = self.uavs[n], self.step_number
        uav.scanned_from.append(uav.cell)
        uav.first_visits.setdefault(uav.cell, number)
        read = self.scans.readings(n, number, uav.cell, uav.headings[-1], uav.bumps[-1])
        self.readings[n, number] = read
        self.paths[n][n].append(uav.believed)
        uav.discovered += self.list_known(n)
        uav.sensed |= read.keys()
        self.place(n)

    # ---- Localisation

    def correct(self, n, cell, variance, scanned):
        """Move a believed cell, and the path since the last pose as sure; ``scanned``: with the scan of this step."""
        uav, path, rate = self.uavs[n], self.paths[n][n], self.scenario.drift.rate
        now, target = self.step_number, self.clamped(cell)
        change = target[0] - uav.believed[0], target[1] - uav.believed[1]
        uav.believed = target
        anchor = max(k for k in range(now) if k == 0 or uav.variances[k] <= variance)
        length = uav.ways[now] - uav.ways[anchor]
        uav.variances[now] = variance
        for k in range(anchor + 1, now + scanned):
            share = (uav.ways[k] - uav.ways[anchor]) / max(length, 1)
            bridge = float(variance) + rate * length * share * (1 - share)
            uav.variances[k] = min(uav.variances[k], np.float32(bridge))
            path[k] = self.clamped((path[k][0] + half_up(share * change[0]), path[k][1] + half_up(share * change[1])))
        self.list_known(n)

    def close_loop(self, n):
        uav, drift = self.uavs[n], self.scenario.drift
        first = uav.first_visits.get(uav.cell)
        if first is None or self.step_number - first < drift.closure_gap:
            return
        if uav.variances[first] < uav.variances[-1] and self.drift_draw(n, 2) < drift.closures:
            self.correct(n, self.paths[n][n][first], uav.variances[first], scanned=False)

    def meet_mates(self):
        for n, uav in enumerate(self.uavs):
            for m, mate in enumerate(self.uavs):
                if frozenset((n, m)) not in self.links or not self.sees(uav.cell, mate.cell):
                    continue
                if mate.variances[-1] < uav.variances[-1]:
                    offset = uav.cell[0] - mate.cell[0], uav.cell[1] - mate.cell[1]
                    cell = mate.believed[0] + offset[0], mate.believed[1] + offset[1]
                    self.correct(n, cell, mate.variances[-1], scanned=True)

    def sees(self, a, b):
        far = math.dist(a, b) > self.scenario.lidar.range + 1e-9
        return not far and not crosses(self.truth, (2 * a[0], 2 * a[1]), (2 * b[0], 2 * b[1]))

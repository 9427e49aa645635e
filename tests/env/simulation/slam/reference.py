"""A slow world whose sensors and poses err: contacts, failures, rewards, ends, and the step as a whole."""

import math

import numpy as np

from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.randomness import Stream, shuffled
from indoor_explorers.env.simulation.radio import CELL_BYTES, POSITION_BYTES
from indoor_explorers.env.simulation.state import End
from tests.env.simulation.slam.reference_agents import SlowAgents
from tests.env.simulation.slam.reference_scans import DIRECTIONS, uniform

BASE = "base"


class SlowWorld(SlowAgents):
    """One episode."""

    def __init__(self, world, seed):
        super().__init__(world, seed)
        self.contacts = {}
        """Last step in which each agent was in contact with the base."""
        self.reported = set()
        """Agents in contact with the base in this step."""
        for n in self.team:
            self.sense(n)
        self.contact()

    def flying(self, n):
        return self.uavs[n].end == End.FLYING

    # ---- Contacts

    def reach(self, a, b):
        radio = self.scenario.radio
        distance = {"none": math.inf, "unlimited": 0.0, "disc": math.dist(a, b)}[radio.model]
        return distance <= radio.range or radio.model == "unlimited"

    def is_lost(self, n, m):
        number = (self.step_number * len(self.uavs) + n) * len(self.uavs) + m
        return uniform(self.key(Stream.RADIO), number) < self.scenario.radio.loss

    def talks(self, n):
        return self.flying(n) and self.step_number >= self.uavs[n].silent_until

    def link(self):
        """Draw who is in contact; return the components of more than one agent, or with the base."""
        self.links = {
            frozenset((n, m))
            for n in self.team
            for m in range(n)
            if self.talks(n) and self.talks(m) and self.reach(self.uavs[n].cell, self.uavs[m].cell)
            if not self.is_lost(n, m)
        }
        edges = set(self.links)
        for n, uav in enumerate(self.uavs):
            if self.scenario.base.exists and self.flying(n):
                near = math.dist(uav.cell, self.base) <= self.scenario.base.radius + 1e-9
                if near or (self.talks(n) and self.reach(uav.cell, self.base) and not self.is_lost(n, n)):
                    edges.add(frozenset((n, BASE)))
        components = [{holder} for holder in (*self.team, BASE)]
        for edge in edges:
            joined = set().union(*(each for each in components if each & edge))
            components = [each for each in components if not each & edge] + [joined]
        self.reported = next(each for each in components if BASE in each) - {BASE}
        return [each for each in components if len(each) > 1]

    def contact(self):
        components = self.link()
        if self.scenario.drift.mates and self.scenario.drift.rate > 0:
            self.meet_mates()
        for component in components:
            self.share(component)
        for n in self.team:
            self.place(n)

    def share(self, component):
        """Give all of a component the latest paths that one of them has."""
        agents = sorted(component - {BASE})
        holders = [*agents, *([BASE] if BASE in component else [])]
        for agent in self.team:
            source = max(holders, key=lambda holder: len(self.paths[holder][agent]))  # the first of the best
            latest = self.paths[source][agent]
            for holder in holders:
                old = self.paths[holder][agent]
                if source != BASE:
                    self.uavs[source].sent_bytes += sum(
                        POSITION_BYTES * (old[k] != pose) if k < len(old) else CELL_BYTES * len(self.readings[agent, k])
                        for k, pose in enumerate(latest)
                    )
                self.paths[holder][agent] = list(latest)
        for n in agents:
            self.uavs[n].received += self.list_known(n)
            for m in agents:
                if n != m:
                    self.uavs[n].heard[m] = self.step_number, self.uavs[m].believed
                    self.uavs[m].sent_bytes += POSITION_BYTES
            if BASE in component:
                self.contacts[n] = self.step_number

    # ---- Failures

    def happens(self, n, kind, hazard):
        number = (self.step_number * len(self.uavs) + n) * 2 + kind
        return uniform(self.key(Stream.FAILURE), number) < hazard

    def silence_radios(self):
        failures = self.scenario.failures
        for n, uav in enumerate(self.uavs):
            if self.step_number >= uav.silent_until and self.happens(n, 1, failures.radio_hazard):
                uav.silent_until = self.step_number + failures.radio_outage

    def stop_uavs(self):
        """Let UAVs stop; of all that have stopped, the team's map keeps the scans that other holders have."""
        failures = self.scenario.failures
        now = [
            n
            for n in self.team
            if self.flying(n) and ((n, self.step_number) in failures.stops or self.happens(n, 0, failures.hazard))
        ]
        for n in now:
            self.uavs[n].end = End.STOPPED
            self.uavs[n].reward += failures.reward
        left = [holder for holder in (*self.team, BASE) if holder == BASE or self.uavs[holder].end != End.STOPPED]
        if now:
            for n, uav in enumerate(self.uavs):
                if uav.end == End.STOPPED:
                    self.remaining[n] = {}
                    for holder in reversed(left):  # the first holder that has a scan says where it is
                        self.remaining[n] |= dict(enumerate(self.paths[holder][n]))

    # ---- The step

    def step(self, actions):
        for uav in self.uavs:
            uav.reward, uav.discovered, uav.received = 0.0, 0, 0
        if not any(map(self.flying, self.team)):
            return
        order = np.empty(len(self.uavs), np.int64)
        shuffled(np.uint64(self.key(Stream.ORDER)), self.step_number, order)
        for n in order.tolist():
            if self.flying(n):
                self.act(n, int(actions[n]))
        self.step_number += 1
        for n in filter(self.flying, self.team):
            if self.scenario.drift.rate > 0:
                self.close_loop(n)
            self.sense(n)
        last_word = self.scenario.failures.last_word
        self.silence_radios()
        if not last_word:
            self.stop_uavs()
        self.contact()
        if last_word:
            self.stop_uavs()
        self.settle()

    def settle(self):
        rewards, scenario = self.scenario.rewards, self.scenario
        shared = {"team": self.shown(self.team_log_odds()), "base": self.shown(self.log_odds(BASE))}
        together = scenario.goal_of == "every" and not scenario.base.must_return
        all_know = all(self.right(self.belief(n)) >= self.needed for n in filter(self.flying, self.team))
        for n in filter(self.flying, self.team):
            uav = self.uavs[n]
            uav.pose_error += math.dist(uav.believed, uav.cell)
            uav.reward += rewards.discovered * uav.discovered + rewards.received * uav.received
            goal_map = shared["base"] if scenario.base.must_return else shared.get(scenario.goal_of)
            reached = self.right(self.belief(n) if goal_map is None else goal_map) >= self.needed
            if all_know if together else reached:
                uav.end = End.GOAL
                uav.reward += rewards.goal
            elif self.step_number >= self.budget:
                uav.end = End.BUDGET

    def legal(self, n):
        """Moves that end on the map, and in nothing that the agent takes for an obstacle."""
        belief, (row, col) = self.belief(n), self.uavs[n].believed
        ahead = [(row + down, col + right) for down, right in DIRECTIONS]
        return [*(self.is_inside(cell) and belief[cell] != OCCUPIED for cell in ahead), True]

"use strict";
// The policies of the playground: small scripts that act on what a UAV knows, where its mates in contact are, and chance.

/** A small seeded generator (mulberry32): numbers from 0 to 1. */
function chance(seed) {
  let state = (seed * 2654435761) >>> 0;
  return () => {
    state = (state + 0x6D2B79F5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

const pick = (items, random) => items[Math.floor(random() * items.length)];

/** The known free cells beside unknown ones. */
function frontierCells(grid, belief) {
  const found = [];
  for (let cell = 0; cell < belief.length; cell++) {
    if (belief[cell] === FREE && grid.neighbours(cell).some((next) => belief[next] === UNKNOWN)) found.push(cell);
  }
  return found;
}

/** The frontier cells with the fewest known steps from a cell. */
function nearestFrontier(grid, belief, cell) {
  const steps = stepsFrom(grid, belief, [cell]);
  const reached = frontierCells(grid, belief).filter((each) => steps[each] >= 0);
  const least = Math.min(...reached.map((each) => steps[each]));
  return reached.filter((each) => steps[each] === least);
}

/** The actions that begin a shortest known path from a cell to a goal. */
function firstActions(grid, belief, cell, goal) {
  const steps = stepsFrom(grid, belief, [goal]), width = grid.width;
  const next = (action) => {
    const row = Math.floor(cell / width) + MOVES[action][0], col = cell % width + MOVES[action][1];
    return grid.inside(row, col) ? row * width + col : -1;
  };
  return [0, 1, 2, 3].filter((action) => {
    const target = next(action);
    return target >= 0 && belief[target] === FREE && steps[target] >= 0 && steps[target] === steps[cell] - 1;
  });
}

/** How many unknown cells a lidar in a known cell would show, unknown cells taken as open. */
function viewGain(grid, belief, cell, range) {
  const known = new Grid(grid.height, grid.width, belief);
  const seen = visibleCells(known, Math.floor(cell / grid.width), cell % grid.width, range);
  return seen.reduce((sum, each) => sum + (belief[each] === UNKNOWN), 0);
}

/** A pilot of one UAV: keeps a goal until it is no frontier cell, and gives it up when a mate is in the way for long. */
class GoalPilot {
  constructor(choose, random) {
    Object.assign(this, { choose, random, goal: null, waited: 0 });
  }

  act(episode, n) {
    const { grid } = episode, belief = episode.beliefs[n], cell = episode.cells[n];
    if (this.goal === null || this.waited > 1 || !frontierCells(grid, belief).includes(this.goal)) {
      this.goal = this.choose(episode, n, this.random, this.waited > 1 ? this.goal : null);
      this.waited = 0;
    }
    if (this.goal === null) return STAY;
    const actions = firstActions(grid, belief, cell, this.goal);
    const free = actions.filter((action) => episode._target(n, action) !== null);
    this.waited = free.length ? 0 : this.waited + 1;
    return free.length ? free[0] : this._sidestep(episode, n);
  }

  /** A random move out of the way of a mate. */
  _sidestep(episode, n) {
    const free = [0, 1, 2, 3].filter((action) => episode._target(n, action) !== null);
    return free.length ? pick(free, this.random) : STAY;
  }
}

/** The nearest frontier cell, at random among equals; not one that was given up, if there is another. */
function chooseNearest(episode, n, random, givenUp) {
  const found = nearestFrontier(episode.grid, episode.beliefs[n], episode.cells[n]);
  const others = found.filter((cell) => cell !== givenUp);
  return found.length ? pick(others.length ? others : found, random) : null;
}

/** The frontier cell that shows most unknown cells for the steps that it takes. */
function chooseGain(episode, n, random, givenUp) {
  const { grid, range } = episode, belief = episode.beliefs[n];
  const steps = stepsFrom(grid, belief, [episode.cells[n]]);
  const reached = frontierCells(grid, belief).filter((cell) => steps[cell] >= 0);
  const worth = (cell) => viewGain(grid, belief, cell, range) / (steps[cell] + 1) - (cell === givenUp ? 1e6 : 0);
  return reached.length ? reached.reduce((best, cell) => (worth(cell) > worth(best) ? cell : best)) : null;
}

/** A pilot that moves at random. */
class RandomPilot {
  constructor(random) { this.random = random; }
  act() { return Math.floor(this.random() * 4); }
}

/** The policies by name. */
const POLICIES = {
  "nearest frontier": (random) => new GoalPilot(chooseNearest, random),
  "most unknown in view per step": (random) => new GoalPilot(chooseGain, random),
  "random": (random) => new RandomPilot(random),
};

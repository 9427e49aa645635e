"use strict";
// The world of the playground: the same lidar, moves, radio and coverage as the program's, in a batch of one.
// Tests hold it against recorded episodes, step by step. A map is a flat array of cells, row by row.

const UNKNOWN = 0, FREE = 1, OCCUPIED = 2;
/** Row and column change of down, left, up, right and stay. */
const MOVES = [[1, 0], [0, -1], [-1, 0], [0, 1], [0, 0]];
const STAY = 4;
const LEAST_BUDGET = 200;

/** SplitMix64: 64 random bits for a key and a counter, as BigInt. */
function draw(key, counter) {
  const cut = (x) => BigInt.asUintN(64, x);
  let z = cut(key + (counter + 1n) * 0x9E3779B97F4A7C15n);
  z = cut((z ^ (z >> 30n)) * 0xBF58476D1CE4E5B9n);
  z = cut((z ^ (z >> 27n)) * 0x94D049BB133111EBn);
  return z ^ (z >> 31n);
}

/** The key of the stream that draws the order of moves of an episode. */
function orderKey(seed) {
  return draw(draw(draw(0n, BigInt(seed)), 2n), 0n);
}

/** The order in which n UAVs move in a step. */
function moveOrder(key, step, n) {
  const base = draw(key, BigInt(step)), order = [...Array(n).keys()];
  for (let i = n - 1; i > 0; i--) {
    const j = Number(draw(base, BigInt(i)) % BigInt(i + 1));
    [order[i], order[j]] = [order[j], order[i]];
  }
  return order;
}

/** A map: its size and cells. */
class Grid {
  constructor(height, width, cells) {
    this.height = height;
    this.width = width;
    this.cells = cells;
  }

  inside(row, col) { return row >= 0 && col >= 0 && row < this.height && col < this.width; }
  at(row, col) { return this.cells[row * this.width + col]; }
  occupied(row, col) { return this.inside(row, col) && this.at(row, col) === OCCUPIED; }

  /** The neighbours of a flat cell, in the order of moves. */
  neighbours(cell) {
    const row = Math.floor(cell / this.width), col = cell % this.width, found = [];
    for (const [dr, dc] of MOVES.slice(0, STAY)) {
      if (this.inside(row + dr, col + dc)) found.push((row + dr) * this.width + col + dc);
    }
    return found;
  }
}

/**
 * Whether an obstacle blocks the segment between two points. Coordinates are doubled: centres of cells are odd, borders
 * even. Touching a corner does not block, passing between two obstacles that touch at one does.
 */
function isBlocked(grid, y0, x0, y1, x1) {
  const tall = Math.abs(y1 - y0), wide = Math.abs(x1 - x0);
  const down = y1 > y0 ? 1 : -1, right = x1 > x0 ? 1 : -1;
  let row = (y0 - 1) / 2, col = (x0 - 1) / 2;
  for (let rows = 0, cols = 0; ;) {
    const toRow = 2 * rows + 1, toCol = 2 * cols + 1; // distances to the next borders
    const horizontal = toRow < tall, vertical = toCol < wide;
    if (!horizontal && !vertical) return false;
    const order = !horizontal ? 1 : !vertical ? -1 : toRow * wide - toCol * tall;
    if (order === 0 && grid.occupied(row + down, col) && grid.occupied(row, col + right)) return true;
    if (order <= 0) { row += down; rows++; }
    if (order >= 0) { col += right; cols++; }
    if (grid.occupied(row, col)) return true;
  }
}

/** Whether a lidar in one cell sees another one, ranges aside. */
function sees(grid, row, col, toRow, toCol) {
  const y = 2 * row + 1, x = 2 * col + 1, toY = 2 * toRow + 1, toX = 2 * toCol + 1;
  if (!grid.occupied(toRow, toCol)) return !isBlocked(grid, y, x, toY, toX);
  return MOVES.slice(0, STAY).some(([dr, dc]) =>
    grid.inside(toRow + dr, toCol + dc) && !grid.occupied(toRow + dr, toCol + dc)
    && !isBlocked(grid, y, x, toY + dr, toX + dc));
}

/** The flat cells that a lidar of a range in cells sees. */
function visibleCells(grid, row, col, range) {
  const reach = Math.floor(range + 1e-9), found = [];
  for (let r = Math.max(0, row - reach); r <= Math.min(grid.height - 1, row + reach); r++) {
    for (let c = Math.max(0, col - reach); c <= Math.min(grid.width - 1, col + reach); c++) {
      const near = (r - row) ** 2 + (c - col) ** 2 <= range * range + 1e-9;
      if (near && ((r === row && c === col) || sees(grid, row, col, r, c))) found.push(r * grid.width + c);
    }
  }
  return found;
}

/** Steps through free cells of `cells` from some flat cells to all; -1 where there is no way. */
function stepsFrom(grid, cells, starts) {
  const steps = new Int32Array(cells.length).fill(-1), queue = [...starts];
  for (const start of starts) steps[start] = 0;
  for (let k = 0; k < queue.length; k++) {
    for (const next of grid.neighbours(queue[k])) {
      if (cells[next] === FREE && steps[next] < 0) {
        steps[next] = steps[queue[k]] + 1;
        queue.push(next);
      }
    }
  }
  return steps;
}

/** An episode: a team on a map, with what each UAV knows. */
class Episode {
  /** `starts` are flat cells; `radio` is {model: "none" | "disc" | "unlimited", range}. */
  constructor(grid, starts, { range, radio, seed }) {
    Object.assign(this, { grid, range, radio, key: orderKey(seed) });
    this.cells = [...starts];
    this.step = 0;
    this.beliefs = starts.map(() => new Uint8Array(grid.cells.length));
    this.team = new Uint8Array(grid.cells.length);
    const steps = stepsFrom(grid, grid.cells, starts);
    this.counts = Uint8Array.from(steps, (each) => each >= 0);
    this.total = this.counts.reduce((sum, each) => sum + each, 0);
    this.budget = Math.max(LEAST_BUDGET, this.total);
    this.covered = 0;
    this.curve = [];
    this.trails = starts.map((cell) => [cell]);
    for (let n = 0; n < starts.length; n++) this._scan(n);
    this._exchange();
    this.curve.push(this.coverage);
  }

  get coverage() { return this.covered / this.total; }
  get over() { return this.covered >= this.total || this.step >= this.budget; }

  /** The first step with a share of the floor known; null before. */
  firstStep(share) {
    const found = this.curve.findIndex((each) => each >= share - 1e-12);
    return found < 0 ? null : found;
  }

  /** Carry out one action for each UAV. */
  advance(actions) {
    for (const n of moveOrder(this.key, this.step, this.cells.length)) {
      const target = this._target(n, actions[n]);
      if (target === null) continue;
      this.cells[n] = target;
      this._scan(n);
    }
    this.step++;
    this._exchange();
    this.cells.forEach((cell, n) => this.trails[n].push(cell));
    this.curve.push(this.coverage);
  }

  /** The cell that an action leads into; null where the UAV stays. */
  _target(n, action) {
    if (action === STAY) return null;
    const width = this.grid.width, row = Math.floor(this.cells[n] / width) + MOVES[action][0];
    const col = this.cells[n] % width + MOVES[action][1];
    if (!this.grid.inside(row, col) || this.grid.occupied(row, col)) return null;
    const target = row * width + col;
    return this.cells.includes(target) ? null : target;
  }

  _scan(n) {
    const width = this.grid.width, cell = this.cells[n];
    this._enter(n, visibleCells(this.grid, Math.floor(cell / width), cell % width, this.range));
  }

  /** Let a UAV know some cells. */
  _enter(n, cells) {
    for (const cell of cells) {
      this.beliefs[n][cell] = this.grid.cells[cell];
      if (this.team[cell] === UNKNOWN) {
        this.team[cell] = this.grid.cells[cell];
        this.covered += this.counts[cell];
      }
    }
  }

  /** The pairs of UAVs in contact. */
  contacts() {
    const found = [], width = this.grid.width;
    for (let i = 0; i < this.cells.length; i++) {
      for (let j = 0; j < i; j++) {
        const rows = Math.floor(this.cells[i] / width) - Math.floor(this.cells[j] / width);
        const cols = this.cells[i] % width - this.cells[j] % width;
        const near = rows * rows + cols * cols <= this.radio.range ** 2 + 1e-9;
        if (this.radio.model === "unlimited" || (this.radio.model === "disc" && near)) found.push([j, i]);
      }
    }
    return found;
  }

  /** Merge the maps of all that are in contact, directly or through others. */
  _exchange() {
    const group = this.cells.map((_, n) => n);
    for (const [i, j] of this.contacts()) {
      const [kept, gone] = [Math.min(group[i], group[j]), Math.max(group[i], group[j])];
      group.forEach((each, n) => { if (each === gone) group[n] = kept; });
    }
    for (const number of new Set(group)) {
      const members = group.flatMap((each, n) => (each === number ? [n] : []));
      if (members.length < 2) continue;
      for (let cell = 0; cell < this.team.length; cell++) {
        if (members.some((n) => this.beliefs[n][cell] !== UNKNOWN)) {
          for (const n of members) this.beliefs[n][cell] = this.grid.cells[cell];
        }
      }
    }
    this.group = group;
  }
}

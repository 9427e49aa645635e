/* What is drawn of a flight on one map: cells, lidar, trails, radio links, UAVs. Lengths are in device pixels. */
const LAYERS = [
  ["truth", "true map"], ["prior", "prior map"], ["known", "known"], ["frontier", "frontier"],
  ["lidar", "lidar range"], ["links", "radio links"], ["trails", "trails"],
];
const UAV_COLOURS = 8;

/* The theme's colours, looked up once. */
class Inks {
  constructor() {
    const shade = (name) => {
      const [r, g, b] = [1, 3, 5].map((k) => parseInt(Theme.colour(name).slice(k, k + 2), 16));
      return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
    };
    this.unknown = shade("--unknown");
    this.ghost = [shade("--ghost-free"), shade("--ghost-wall")];
    this.onlyPrior = shade("--prior-wall");
    this.onlyTruth = shade("--prior-gap");
    this.clear = [shade("--free"), shade("--wall")];
    this.frontier = shade("--frontier");
    this.wrong = shade("--bad");
    this.uavs = Array.from({ length: UAV_COLOURS }, (_, k) => Theme.colour(`--u${k}`));
    this.paper = Theme.colour("--paper");
    this.link = Theme.colour("--link");
    this.stopped = Theme.colour("--bad");
    this.ink = Theme.colour("--ink");
    this.soft = Theme.colour("--soft");
    this.line = Theme.colour("--line");
  }
  uav(number) { return this.uavs[number % UAV_COLOURS]; }
  policy(policy) { return Theme.colour(`--c${policy.colour}`); }
}

/* Whether a cell that is known to be free borders on one that is not known; ``rise`` leads to the next level, if any. */
function isFrontier(isUnknown, cell, width, size, rise) {
  const column = cell % width;
  if (rise && ((cell >= rise && isUnknown(cell - rise)) || (cell + rise < size && isUnknown(cell + rise)))) return true;
  return (column > 0 && isUnknown(cell - 1)) || (column < width - 1 && isUnknown(cell + 1))
    || (cell >= width && isUnknown(cell - width)) || (cell + width < size && isUnknown(cell + width));
}

/* What is under the unknown cells: the true map, the prior map, or both with the walls that only one of them has. */
function groundOf({ walls, prior }, layers, inks) {
  if (!prior || !layers.has("prior")) {
    const behind = layers.has("truth") ? inks.ghost : [inks.unknown, inks.unknown];
    return (cell) => behind[walls[cell]];
  }
  if (!layers.has("truth")) return (cell) => inks.ghost[prior[cell]];
  const both = [[inks.ghost[0], inks.onlyPrior], [inks.onlyTruth, inks.ghost[1]]];
  return (cell) => both[walls[cell]][prior[cell]];
}

/* A picture of the cells in their grid, one pixel each, on ``sheet``; ``wrong`` are those that the map shows wrongly. */
function paintCells(sheet, episode, grid, known, wrong, frame, layers, inks) {
  const { width, walls } = episode, size = walls.length, rise = grid.levels > 1 ? (grid.high + 1) * width : 0;
  const image = new ImageData(grid.width, grid.height), pixels = new Uint32Array(image.data.buffer);
  const behind = groundOf(episode, layers, inks);
  const plain = layers.has("known"), edges = layers.has("frontier");
  const isUnknown = (cell) => known[cell] > frame && wrong[cell] > frame && !grid.isBetween(Math.floor(cell / width));
  const shade = (cell) => {
    const wall = walls[cell];
    if (plain && wrong[cell] <= frame) return inks.wrong;
    if (known[cell] > frame) return behind(cell);
    if (edges && !wall && isFrontier(isUnknown, cell, width, size, rise)) return inks.frontier;
    return plain ? inks.clear[wall] : behind(cell);
  };
  for (let row = 0; row * width < size; row++) {
    if (grid.isBetween(row)) continue;
    const [down, right] = grid.place(row, 0), from = down * grid.width + right;
    for (let column = 0; column < width; column++) pixels[from + column] = shade(row * width + column);
  }
  sheet.width = grid.width;
  sheet.height = grid.height;
  sheet.getContext("2d").putImageData(image, 0, 0);
}

/* The marks of one flight at one frame. */
class Marks {
  constructor(pen, flight, base, frame, scale, ratio, inks, grid) {
    Object.assign(this, { pen, flight, base, frame, scale, ratio, inks, grid });
    this.radius = Math.max((flight.team > 1 ? 6.5 : 5) * ratio, scale * 0.42);
  }

  centre(row, column) { return this.grid.place(row, column).reverse().map((place) => (place + 0.5) * this.scale); }

  /* The row and column of a UAV; the home base comes after the last one. */
  cell(uav, frame = this.frame) {
    if (uav === this.flight.team) return this.base;
    const k = 2 * (frame * this.flight.team + uav);
    return [this.flight.cells[k], this.flight.cells[k + 1]];
  }

  at(uav, frame = this.frame) { return this.centre(...this.cell(uav, frame)); }

  level(uav, frame = this.frame) { return this.grid.levelOf(this.cell(uav, frame)[0]); }

  hasStopped(uav) { return this.flight.stops[uav] <= this.frame; }

  eachUav(draw) { for (let uav = 0; uav < this.flight.team; uav++) draw(uav, this.inks.uav(uav)); }

  trails() {
    const { pen } = this;
    pen.lineWidth = Math.max(1.3 * this.ratio, Math.min(3 * this.ratio, this.scale * 0.16));
    pen.lineJoin = "round";
    pen.globalAlpha = 0.7;
    this.eachUav((uav, colour) => {
      pen.strokeStyle = colour;
      pen.beginPath();
      this.line(Array.from({ length: this.frame + 1 }, (_, frame) => this.cell(uav, frame)));
      pen.stroke();
    });
    pen.globalAlpha = 1;
    if (this.grid.levels > 1) this.eachUav((uav, colour) => this.changes(uav, colour));
  }

  /* A line through cells, broken where they change their level. */
  line(cells) {
    let before;
    for (const [row, column] of cells) {
      const level = this.grid.levelOf(row);
      this.pen[level === before ? "lineTo" : "moveTo"](...this.centre(row, column));
      before = level;
    }
  }

  /* Triangles where a UAV left a level, which point up or down. */
  changes(uav, colour) {
    for (let frame = 1; frame <= this.frame; frame++) {
      const rise = this.level(uav, frame) - this.level(uav, frame - 1);
      if (rise) this.triangle(this.at(uav, frame - 1), -Math.sign(rise), colour);
    }
  }

  triangle([x, y], down, colour) {
    const { pen } = this, size = this.radius * 0.55;
    pen.beginPath();
    pen.moveTo(x, y + down * size);
    for (const side of [-1, 1]) pen.lineTo(x + side * size, y - down * size * 0.8);
    pen.closePath();
    pen.fillStyle = colour;
    pen.fill();
    pen.lineWidth = this.ratio;
    pen.strokeStyle = this.inks.paper;
    pen.stroke();
  }

  lidar(range) {
    const { pen } = this;
    this.eachUav((uav, colour) => {
      if (this.hasStopped(uav)) return;
      this.grid.within(this.level(uav), pen, this.scale, () => {
        pen.beginPath();
        pen.arc(...this.at(uav), range * this.scale, 0, 2 * Math.PI);
        pen.fillStyle = pen.strokeStyle = colour;
        pen.globalAlpha = 0.08;
        pen.fill();
        pen.globalAlpha = 0.6;
        pen.lineWidth = 1.2 * this.ratio;
        pen.stroke();
      });
    });
  }

  /* Lines between those in radio contact, dashed where they are on different levels. */
  links() {
    const { pen } = this;
    for (const [width, colour] of [[4.5, this.inks.paper], [2, this.inks.link]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = width * this.ratio;
      for (const [i, j] of this.flight.links[this.frame]) {
        pen.setLineDash(this.level(i) === this.level(j) ? [] : [6 * this.ratio, 5 * this.ratio]);
        pen.beginPath();
        pen.moveTo(...this.at(i));
        pen.lineTo(...this.at(j));
        pen.stroke();
      }
    }
    pen.setLineDash([]);
  }

  /* The home base as a landing pad: an H in a ring. */
  pad() {
    if (!this.base) return;
    const place = this.centre(...this.base), radius = this.radius * 1.35;
    this.disc(place, radius, this.inks.paper, this.inks.ink);
    this.write("H", place, radius, this.inks.ink);
  }

  /* The UAVs, those that have stopped below the others; when the map of one is shown, the others are faint. */
  team(map) {
    for (const stopped of [true, false]) {
      this.eachUav((uav, colour) => {
        if (this.hasStopped(uav) !== stopped) return;
        this.pen.globalAlpha = !/^\d+$/.test(map) || Number(map) === uav ? 1 : 0.45;
        if (stopped) this.wreck(uav, colour); else this.uav(uav, colour);
      });
    }
    this.pen.globalAlpha = 1;
  }

  uav(uav, colour) {
    const place = this.at(uav);
    this.disc(place, this.radius, colour, this.inks.paper);
    if (this.flight.team > 1) this.write(String(uav), place, this.radius, this.inks.paper);
  }

  /* A UAV that has stopped: a hollow disc, crossed out. */
  wreck(uav, colour) {
    const { pen } = this, [x, y] = this.at(uav), arm = this.radius * 1.25;
    this.disc([x, y], this.radius, this.inks.paper, colour);
    for (const [width, ink] of [[4.5, this.inks.paper], [2, this.inks.stopped]]) {
      pen.strokeStyle = ink;
      pen.lineWidth = width * this.ratio;
      pen.beginPath();
      for (const slope of [-1, 1]) {
        pen.moveTo(x - arm, y - slope * arm);
        pen.lineTo(x + arm, y + slope * arm);
      }
      pen.stroke();
    }
    if (this.flight.team > 1) this.write(String(uav), [x + 2 * this.radius, y], this.radius, colour, this.inks.paper);
  }

  disc(place, radius, fill, edge) {
    const { pen } = this;
    pen.beginPath();
    pen.arc(...place, radius, 0, 2 * Math.PI);
    pen.fillStyle = fill;
    pen.fill();
    pen.lineWidth = 1.5 * this.ratio;
    pen.strokeStyle = edge;
    pen.stroke();
  }

  write(text, [x, y], radius, colour, halo = null) {
    const { pen } = this;
    pen.font = `700 ${Math.round(radius * 1.3)}px system-ui, sans-serif`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    if (halo) {
      pen.strokeStyle = halo;
      pen.lineWidth = 4 * this.ratio;
      pen.strokeText(text, x, y + radius * 0.08);
    }
    pen.fillStyle = colour;
    pen.fillText(text, x, y + radius * 0.08);
  }
}

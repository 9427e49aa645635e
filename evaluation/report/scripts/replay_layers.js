/* What is drawn of a flight on one map: cells, lidar, trails, radio links, UAVs. Lengths are in device pixels. */
const LAYERS = [
  ["truth", "true map"], ["known", "known"], ["frontier", "frontier"],
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
    this.clear = [shade("--free"), shade("--wall")];
    this.frontier = shade("--frontier");
    this.uavs = Array.from({ length: UAV_COLOURS }, (_, k) => Theme.colour(`--u${k}`));
    this.paper = Theme.colour("--paper");
    this.link = Theme.colour("--link");
    this.ink = Theme.colour("--ink");
    this.soft = Theme.colour("--soft");
    this.line = Theme.colour("--line");
  }
  uav(number) { return this.uavs[number % UAV_COLOURS]; }
  policy(policy) { return Theme.colour(`--c${policy.colour}`); }
}

/* Whether a cell that is known to be free borders on one that is not known. */
function isFrontier(known, frame, cell, width) {
  const column = cell % width;
  return (column > 0 && known[cell - 1] > frame) || (column < width - 1 && known[cell + 1] > frame)
    || (cell >= width && known[cell - width] > frame) || (cell + width < known.length && known[cell + width] > frame);
}

/* A picture of the cells, one pixel each, on ``sheet``. */
function paintCells(sheet, episode, known, frame, layers, inks) {
  const { width, height, walls } = episode;
  const image = new ImageData(width, height), pixels = new Uint32Array(image.data.buffer);
  const behind = layers.has("truth") ? inks.ghost : [inks.unknown, inks.unknown];
  const clear = layers.has("known") ? inks.clear : behind, edges = layers.has("frontier");
  for (let cell = 0; cell < pixels.length; cell++) {
    const wall = walls[cell];
    if (known[cell] > frame) pixels[cell] = behind[wall];
    else if (edges && !wall && isFrontier(known, frame, cell, width)) pixels[cell] = inks.frontier;
    else pixels[cell] = clear[wall];
  }
  sheet.width = width;
  sheet.height = height;
  sheet.getContext("2d").putImageData(image, 0, 0);
}

/* The marks of one flight at one frame. */
class Marks {
  constructor(pen, flight, frame, scale, ratio, inks) {
    Object.assign(this, { pen, flight, frame, scale, ratio, inks });
    this.radius = Math.max((flight.team > 1 ? 6.5 : 5) * ratio, scale * 0.42);
  }

  at(uav, frame = this.frame) {
    const k = 2 * (frame * this.flight.team + uav);
    return [(this.flight.cells[k + 1] + 0.5) * this.scale, (this.flight.cells[k] + 0.5) * this.scale];
  }

  eachUav(draw) { for (let uav = 0; uav < this.flight.team; uav++) draw(uav, this.inks.uav(uav)); }

  trails() {
    const { pen } = this;
    pen.lineWidth = Math.max(1.3 * this.ratio, Math.min(3 * this.ratio, this.scale * 0.16));
    pen.lineJoin = "round";
    pen.globalAlpha = 0.7;
    this.eachUav((uav, colour) => {
      pen.strokeStyle = colour;
      pen.beginPath();
      for (let frame = 0; frame <= this.frame; frame++) pen.lineTo(...this.at(uav, frame));
      pen.stroke();
    });
    pen.globalAlpha = 1;
  }

  lidar(range) {
    const { pen } = this;
    this.eachUav((uav, colour) => {
      pen.beginPath();
      pen.arc(...this.at(uav), range * this.scale, 0, 2 * Math.PI);
      pen.fillStyle = pen.strokeStyle = colour;
      pen.globalAlpha = 0.08;
      pen.fill();
      pen.globalAlpha = 0.6;
      pen.lineWidth = 1.2 * this.ratio;
      pen.stroke();
      pen.globalAlpha = 1;
    });
  }

  links() {
    const { pen } = this;
    for (const [width, colour] of [[4.5, this.inks.paper], [2, this.inks.link]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = width * this.ratio;
      for (const [i, j] of this.flight.links[this.frame]) {
        pen.beginPath();
        pen.moveTo(...this.at(i));
        pen.lineTo(...this.at(j));
        pen.stroke();
      }
    }
  }

  /* The UAVs; when the map of one is shown, the others are faint. */
  team(map) {
    this.eachUav((uav, colour) => {
      this.pen.globalAlpha = map === "team" || Number(map) === uav ? 1 : 0.45;
      this.uav(uav, colour);
    });
    this.pen.globalAlpha = 1;
  }

  uav(uav, colour) {
    const { pen, radius } = this, [x, y] = this.at(uav);
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fillStyle = colour;
    pen.fill();
    pen.lineWidth = 1.5 * this.ratio;
    pen.strokeStyle = this.inks.paper;
    pen.stroke();
    if (this.flight.team === 1) return;
    pen.fillStyle = this.inks.paper;
    pen.font = `700 ${Math.round(radius * 1.3)}px system-ui, sans-serif`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText(String(uav), x, y + radius * 0.08);
  }
}

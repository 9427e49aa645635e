"use strict";
// The page: controls, drawing and painting. It keeps one episode, which every change of a setting starts anew.

const MOST = 40, LEAST = 6;
const element = (id) => document.getElementById(id);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Read a map from text; throws an Error that says what was expected and how to mend it. */
function readMap(text) {
  const rows = text.trim().split(/\r?\n/).map((row) => row.trim());
  const [height, width] = [rows.length, rows[0].length];
  const ragged = rows.findIndex((row) => row.length !== width);
  if (ragged >= 0) {
    throw new Error(`Row ${ragged + 1} has ${rows[ragged].length} cells, expected ${width} as in the first; make them equal.`);
  }
  const odd = rows.join("").match(/[^#.]/);
  if (odd) throw new Error(`Expected # for walls and . for free cells, got ${JSON.stringify(odd[0])}; replace it.`);
  if (Math.min(height, width) < LEAST || Math.max(height, width) > MOST) {
    throw new Error(`Expected ${LEAST} to ${MOST} cells a side, got ${height} x ${width}; cut or widen the map.`);
  }
  const cells = Uint8Array.from(rows.join(""), (each) => (each === "." ? FREE : OCCUPIED));
  if (!cells.includes(FREE)) throw new Error("Expected some free cells, got none; write . where UAVs may fly.");
  return new Grid(height, width, cells);
}

/** A map as text. */
function writtenMap(grid) {
  const text = Array.from(grid.cells, (cell) => (cell === FREE ? "." : "#")).join("");
  return Array.from({ length: grid.height }, (_, row) => text.slice(row * grid.width, (row + 1) * grid.width)).join("\n");
}

/** The cells that UAVs start in: those placed, then free cells next to each other. */
function startCells(grid, team, placed, random) {
  const starts = placed.filter((cell) => grid.cells[cell] === FREE).slice(0, team);
  const free = [...grid.cells.keys()].filter((cell) => grid.cells[cell] === FREE);
  const first = starts[0] ?? pick(free, random);
  const steps = stepsFrom(grid, grid.cells, [first]);
  const near = free.filter((cell) => steps[cell] >= 0 && !starts.includes(cell)).sort((a, b) => steps[a] - steps[b]);
  return [...starts, ...near].slice(0, team);
}

/** Everything that is shown and flown. */
class Playground {
  constructor() {
    this.placed = [];
    this.timer = null;
    this.grid = readMap(MAPS[element("preset").value]);
    this.restart();
  }

  get settings() {
    const number = (id) => {
      const input = element(id), value = Number(input.value);
      const whole = Number.isFinite(value) ? Math.round(value) : 1;
      input.value = Math.min(Number(input.max), Math.max(Number(input.min), whole));
      return Number(input.value);
    };
    return {
      team: Number(element("team").value),
      policy: element("policy").value,
      seed: number("seed"),
      range: number("range"),
      radio: { model: element("radio").value, range: number("reach") },
    };
  }

  restart() {
    const { team, policy, seed, range, radio } = this.settings;
    const starts = startCells(this.grid, team, this.placed, chance(seed));
    this.episode = new Episode(this.grid, starts, { range, radio, seed });
    this.pilots = starts.map((_, n) => POLICIES[policy](chance(seed * 97 + n + 1)));
    element("text").value = writtenMap(this.grid);
    this.pause();
    this.show();
  }

  advance() {
    if (this.episode.over) return this.pause();
    this.episode.advance(this.pilots.map((pilot, n) => pilot.act(this.episode, n)));
    if (this.episode.over) this.pause();
    this.show();
  }

  play() {
    if (this.episode.over) this.restart();
    element("play").textContent = "Pause";
    const tick = () => {
      this.timer = setTimeout(tick, 1000 / Number(element("speed").value));
      this.advance();
    };
    tick();
  }

  pause() {
    clearTimeout(this.timer);
    this.timer = null;
    element("play").textContent = "Play";
  }

  /** Draw into the map: a wall, a free cell, or a UAV's start. */
  paint(cell, tool) {
    if (tool === "uav") {
      if (this.grid.cells[cell] !== FREE) return;
      this.placed = [...this.placed.filter((each) => each !== cell), cell].slice(-this.settings.team);
    } else {
      const cells = this.grid.cells.slice();
      cells[cell] = tool === "wall" ? OCCUPIED : FREE;
      if (!cells.includes(FREE)) return;
      this.grid = new Grid(this.grid.height, this.grid.width, cells);
    }
    this.restart();
  }

  load(text) {
    try {
      this.grid = readMap(text);
      this.placed = [];
      element("problem").textContent = "";
      this.restart();
    } catch (error) {
      element("problem").textContent = error.message;
    }
  }

  show() {
    drawMap(element("map"), this.episode);
    drawCurve(element("curve"), this.episode);
    const { episode } = this, told = (share) => episode.firstStep(share) ?? "\u2013";
    const end = episode.over ? (episode.covered >= episode.total ? ", all explored" : ", the budget is spent") : "";
    element("status").textContent = `Step ${episode.step} of ${episode.budget}: ${(100 * episode.coverage).toFixed(1)} % of what can be reached is known, `
      + `T90 ${told(0.9)}, T99 ${told(0.99)}${end}`;
  }
}

/** A canvas's context for drawings in pixels of the page, cleared. */
function fresh(canvas, height) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth;
  canvas.style.height = `${height}px`;
  [canvas.width, canvas.height] = [width * ratio, height * ratio];
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  return context;
}

/** Pixels of a cell's side. */
const sideOf = (canvas, grid) => canvas.clientWidth / grid.width;

function drawMap(canvas, episode) {
  const { grid } = episode, side = sideOf(canvas, grid), context = fresh(canvas, side * grid.height);
  const middle = (cell) => [(cell % grid.width + 0.5) * side, (Math.floor(cell / grid.width) + 0.5) * side];
  const shades = { known: ["--free", "--wall"], hidden: ["--faint", "--faint-wall"] };
  const fills = Object.fromEntries(Object.entries(shades).map(([key, names]) => [key, names.map(colour)]));
  for (let cell = 0; cell < grid.cells.length; cell++) {
    const [x, y] = middle(cell);
    context.fillStyle = fills[episode.team[cell] === UNKNOWN ? "hidden" : "known"][grid.cells[cell] === FREE ? 0 : 1];
    context.fillRect(x - side / 2, y - side / 2, side + 0.5, side + 0.5);
  }
  drawFootprints(context, episode, middle, side);
  drawLinks(context, episode, middle);
  episode.cells.forEach((cell, n) => {
    drawTrail(context, episode.trails[n].slice(-60).map(middle), COLOURS[n % COLOURS.length]);
    const [x, y] = middle(cell);
    context.beginPath();
    context.arc(x, y, side * 0.42, 0, 2 * Math.PI);
    context.fillStyle = COLOURS[n % COLOURS.length];
    context.fill();
    context.fillStyle = "#fff";
    context.font = `bold ${side * 0.55}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(n, x, y);
  });
}

/** The cells that the UAVs see now. */
function drawFootprints(context, episode, middle, side) {
  context.globalAlpha = 0.22;
  episode.cells.forEach((cell, n) => {
    const { grid } = episode;
    context.fillStyle = COLOURS[n % COLOURS.length];
    for (const seen of visibleCells(grid, Math.floor(cell / grid.width), cell % grid.width, episode.range)) {
      const [x, y] = middle(seen);
      if (grid.cells[seen] === FREE) context.fillRect(x - side / 2, y - side / 2, side, side);
    }
  });
  context.globalAlpha = 1;
}

function drawLinks(context, episode, middle) {
  context.strokeStyle = "#d1495b";
  context.lineWidth = 2;
  context.setLineDash([4, 3]);
  for (const [i, j] of episode.contacts()) {
    context.beginPath();
    context.moveTo(...middle(episode.cells[i]));
    context.lineTo(...middle(episode.cells[j]));
    context.stroke();
  }
  context.setLineDash([]);
}

function drawTrail(context, points, stroke) {
  context.strokeStyle = stroke;
  context.lineWidth = 1.5;
  context.globalAlpha = 0.7;
  context.beginPath();
  points.forEach((point) => context.lineTo(...point));
  context.stroke();
  context.globalAlpha = 1;
}

/** Coverage by step, with lines at 90 and 99 %. */
function drawCurve(canvas, episode) {
  const height = 130, context = fresh(canvas, height), left = 44, top = 10, bottom = height - 22;
  const right = canvas.clientWidth - 10, last = Math.max(40, episode.step);
  const x = (step) => left + (right - left) * step / last, y = (share) => bottom - (bottom - top) * share;
  context.font = "12px system-ui, sans-serif";
  context.fillStyle = colour("--soft");
  context.strokeStyle = colour("--line");
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const share of [0, 0.5, 0.9]) {
    context.fillText(`${100 * share} %`, left - 6, y(share));
    context.beginPath();
    context.moveTo(left, y(share));
    context.lineTo(right, y(share));
    context.stroke();
  }
  context.textBaseline = "alphabetic";
  context.fillText(`${last} steps`, right, height - 6);
  context.strokeStyle = colour("--accent");
  context.lineWidth = 2;
  context.beginPath();
  episode.curve.forEach((share, step) => context.lineTo(x(step), y(share)));
  context.stroke();
}

/** Connect the controls. */
function connect(playground) {
  const tool = () => document.querySelector("input[name=tool]:checked").value;
  const cellAt = (event) => {
    const canvas = element("map"), box = canvas.getBoundingClientRect(), side = sideOf(canvas, playground.grid);
    const row = Math.floor((event.clientY - box.top) / side), col = Math.floor((event.clientX - box.left) / side);
    return playground.grid.inside(row, col) ? row * playground.grid.width + col : null;
  };
  let drawing = false;
  const draw = (event) => {
    const cell = cellAt(event);
    if (drawing && cell !== null) playground.paint(cell, tool());
  };
  element("map").addEventListener("pointerdown", (event) => { drawing = true; draw(event); });
  element("map").addEventListener("pointermove", (event) => { if (tool() !== "uav") draw(event); });
  window.addEventListener("pointerup", () => { drawing = false; });
  element("play").addEventListener("click", () => (playground.timer === null ? playground.play() : playground.pause()));
  element("step").addEventListener("click", () => { playground.pause(); playground.advance(); });
  element("restart").addEventListener("click", () => playground.restart());
  element("preset").addEventListener("change", (event) => playground.load(MAPS[event.target.value]));
  element("load").addEventListener("click", () => playground.load(element("text").value));
  for (const id of ["team", "policy", "seed", "range", "radio", "reach"]) {
    element(id).addEventListener("change", () => playground.restart());
  }
  window.addEventListener("resize", () => playground.show());
}

if (document.getElementById("policy")) {
  for (const name of Object.keys(POLICIES)) element("policy").add(new Option(name));
  window.playground = new Playground();
  connect(window.playground);
}

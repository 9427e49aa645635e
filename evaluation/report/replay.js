/* The episode viewer: up to four policies side by side on one map and seed, one scrubber for all. */
"use strict";
const UAV_COLOURS = {
  light: ["#0072b2", "#d55e00", "#009e73", "#b8578e", "#c98a00", "#3d9fd6", "#6f4fa0", "#8a4b2a"],
  dark: ["#56b4e9", "#f2854a", "#2fc597", "#e8a3c8", "#f0c04a", "#a9dcff", "#b9a3e0", "#d9a07c"],
};
const SPEEDS = [2, 5, 10, 20, 50, 100, 200];

/* Read one flight's stream: whole numbers of seven bits a byte, lowest first. */
function readFlight(flight, size, stride) {
  const bytes = Packed.bytes(flight.stream);
  let at = 0;
  const next = () => {
    let number = 0, scale = 1, byte;
    do { byte = bytes[at++]; number += (byte & 127) * scale; scale *= 128; } while (byte & 128);
    return number;
  };
  const signed = () => { const number = next(); return number % 2 ? -(number + 1) / 2 : number / 2; };
  const steps = [];
  for (let step = 0; step < flight.steps; step += stride) steps.push(step);
  steps.push(flight.steps);
  const cells = new Int16Array(steps.length * flight.team * 2), covered = new Int32Array(steps.length);
  const known = new Int32Array(size).fill(2147483647);
  const before = new Int32Array(flight.team * 2);
  for (let frame = 0; frame < steps.length; frame++) {
    for (let k = 0; k < before.length; k++) {
      before[k] += signed();
      cells[frame * before.length + k] = before[k];
    }
    covered[frame] = (frame ? covered[frame - 1] : 0) + next();
    let place = 0;
    for (let left = next(); left > 0; left--) {
      place += next();
      for (let run = next(); run >= 0; run--) known[place++] = frame;
    }
  }
  return { ...flight, steps, cells, covered, known, last: steps.length - 1 };
}

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in made) made[name] = value; else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}
function rgb(name) {
  const hex = Theme.colour(name);
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
}

/* One map with one policy's flight on it. */
class Panel {
  constructor(replay, place) {
    this.replay = replay;
    this.choice = element("select", { ariaLabel: `Policy of panel ${place + 1}` });
    this.choice.addEventListener("change", () => this.show(Number(this.choice.value)));
    this.chip = element("canvas", { className: "chip", width: 44, height: 20 });
    this.canvas = element("canvas", { className: "map" });
    this.readout = element("b");
    this.end = element("span", { className: "end" });
    this.box = element("div", { className: "panel" },
      element("div", { className: "head" }, this.chip, this.choice), this.canvas,
      element("div", { className: "readout" }, this.readout, this.end));
  }

  offer(flights, chosen) {
    this.choice.replaceChildren(...flights.map((flight, k) =>
      element("option", { value: k, textContent: this.replay.data.policies[flight.policy].name })));
    this.choice.value = String(chosen);
    this.flight = flights[chosen];
  }

  show(place) {
    this.flight = this.replay.flights[place];
    this.replay.draw();
  }

  get policy() { return this.replay.data.policies[this.flight.policy]; }

  draw(frame) {
    const episode = this.replay.episode, f = Math.min(frame, this.flight.last);
    const ratio = window.devicePixelRatio || 1, width = this.canvas.clientWidth || 300;
    const scale = Math.max(1, Math.round(width * ratio)) / episode.width;
    this.canvas.width = Math.round(scale * episode.width);
    this.canvas.height = Math.round(scale * episode.height);
    const pen = this.canvas.getContext("2d");
    pen.imageSmoothingEnabled = false;
    pen.drawImage(this.map(f), 0, 0, this.canvas.width, this.canvas.height);
    if (this.replay.layer("trails")) this.drawTrails(pen, f, scale);
    if (this.replay.layer("lidar")) this.drawLidar(pen, f, scale);
    this.drawTeam(pen, f, scale);
    this.drawChip();
    this.readout.textContent = `${(100 * this.flight.covered[f] / episode.total).toFixed(1)} %`;
    this.end.textContent = f === this.flight.last ? `${this.flight.end}, step ${this.flight.steps[f]}` : "flying";
    this.end.title = this.end.textContent;
  }

  map(frame) {
    const { width, height } = this.replay.episode, { walls, shades } = this.replay;
    const image = new ImageData(width, height), pixels = new Uint32Array(image.data.buffer), known = this.flight.known;
    const ghost = this.replay.layer("truth") ? [shades.ghostFree, shades.ghostWall] : [shades.unknown, shades.unknown];
    const clear = [shades.free, shades.wall];
    for (let k = 0; k < pixels.length; k++) pixels[k] = (known[k] <= frame ? clear : ghost)[walls[k]];
    const sheet = this.sheet || (this.sheet = document.createElement("canvas"));
    sheet.width = width;
    sheet.height = height;
    sheet.getContext("2d").putImageData(image, 0, 0);
    return sheet;
  }

  at(frame, uav, scale) {
    const k = 2 * (frame * this.flight.team + uav);
    return [(this.flight.cells[k + 1] + 0.5) * scale, (this.flight.cells[k] + 0.5) * scale];
  }

  colour(uav) {
    const colours = UAV_COLOURS[Theme.current];
    return colours[uav % colours.length];
  }

  drawTrails(pen, frame, scale) {
    pen.lineWidth = Math.max(1.2, Math.min(4, scale * 0.16));
    pen.lineJoin = "round";
    pen.globalAlpha = 0.7;
    for (let uav = 0; uav < this.flight.team; uav++) {
      pen.strokeStyle = this.colour(uav);
      pen.beginPath();
      for (let f = 0; f <= frame; f++) pen.lineTo(...this.at(f, uav, scale));
      pen.stroke();
    }
    pen.globalAlpha = 1;
  }

  drawLidar(pen, frame, scale) {
    for (let uav = 0; uav < this.flight.team; uav++) {
      pen.beginPath();
      pen.arc(...this.at(frame, uav, scale), this.replay.data.range * scale, 0, 2 * Math.PI);
      pen.fillStyle = pen.strokeStyle = this.colour(uav);
      pen.globalAlpha = 0.08;
      pen.fill();
      pen.globalAlpha = 0.55;
      pen.lineWidth = 1.2;
      pen.stroke();
      pen.globalAlpha = 1;
    }
  }

  drawTeam(pen, frame, scale) {
    const ratio = window.devicePixelRatio || 1, radius = Math.max(4.5 * ratio, scale * 0.42);
    for (let uav = 0; uav < this.flight.team; uav++) {
      const [x, y] = this.at(frame, uav, scale);
      pen.beginPath();
      pen.arc(x, y, radius, 0, 2 * Math.PI);
      pen.fillStyle = this.colour(uav);
      pen.fill();
      pen.lineWidth = 1.5 * ratio;
      pen.strokeStyle = Theme.colour("--paper");
      pen.stroke();
      if (this.flight.team > 1 && radius > 5 * ratio) {
        pen.fillStyle = Theme.colour("--paper");
        pen.font = `600 ${Math.round(radius * 1.25)}px system-ui, sans-serif`;
        pen.textAlign = "center";
        pen.textBaseline = "middle";
        pen.fillText(String(uav + 1), x, y + radius * 0.08);
      }
    }
  }

  drawChip() {
    const pen = this.chip.getContext("2d");
    pen.clearRect(0, 0, 44, 20);
    pen.strokeStyle = Theme.colour(`--c${this.policy.colour}`);
    pen.lineWidth = 4;
    pen.setLineDash(DASHES[this.policy.dash].map((length) => 2 * length));
    pen.beginPath();
    pen.moveTo(0, 10);
    pen.lineTo(44, 10);
    pen.stroke();
  }
}

const DASHES = [[], [7, 3], [2, 2], [9, 3, 2, 3], [4, 2]];

class Replay {
  constructor(box) {
    this.box = box;
    this.data = JSON.parse(document.getElementById(`replay-data-${box.id.slice("replay-".length)}`).textContent);
    this.frame = 0;
    this.playing = false;
    this.build();
    this.open(0);
    box.addEventListener("keydown", (event) => this.key(event));
    Theme.listeners.push(() => { this.shade(); this.draw(); });
    new ResizeObserver(() => this.draw()).observe(this.panels);
  }

  build() {
    this.episodes = element("select", { ariaLabel: "Episode" }, ...this.data.episodes.map((episode, k) =>
      element("option", { value: k, textContent: `${episode.label} · ${episode.map} · seed ${episode.seed}` })));
    this.episodes.addEventListener("change", () => this.open(Number(this.episodes.value)));
    this.layers = {};
    const layers = [["truth", "true map"], ["lidar", "lidar range"], ["trails", "trails"]].map(([key, title]) => {
      this.layers[key] = element("input", { type: "checkbox", checked: true });
      this.layers[key].addEventListener("change", () => this.draw());
      return element("label", {}, this.layers[key], title);
    });
    this.speed = element("select", { ariaLabel: "Speed" }, ...SPEEDS.map((speed) =>
      element("option", { value: speed, textContent: `${speed} steps/s` })));
    this.button = element("button", { type: "button", className: "play", textContent: "Play" });
    this.button.addEventListener("click", () => this.play(!this.playing));
    this.slider = element("input", { type: "range", min: 0, value: 0, ariaLabel: "Step" });
    this.slider.addEventListener("input", () => this.go(Number(this.slider.value)));
    this.clock = element("span", { className: "clock" });
    this.panels = element("div", { className: "panels" });
    this.timeline = element("canvas", { className: "timeline" });
    const seek = (event) => { if (event.buttons) this.go(this.frameAt(event.offsetX)); };
    this.timeline.addEventListener("pointerdown", seek);
    this.timeline.addEventListener("pointermove", seek);
    this.box.append(
      element("div", { className: "top" }, element("label", {}, "Episode", this.episodes), ...layers), this.panels,
      this.timeline, element("div", { className: "transport" }, this.button, this.slider, this.clock,
        element("label", {}, this.speed)));
  }

  open(place) {
    this.episode = this.data.episodes[place];
    const { width, height, stride } = this.episode, bits = Packed.bytes(this.episode.walls);
    this.walls = Uint8Array.from({ length: width * height }, (_, k) => (bits[k >> 3] >> (7 - (k & 7))) & 1);
    this.flights = this.episode.flights.map((flight) => readFlight(flight, width * height, stride));
    const shown = Math.min(4, this.flights.length);
    this.panes = Array.from({ length: shown }, (_, k) => new Panel(this, k));
    this.panes.forEach((pane, k) => pane.offer(this.flights, k));
    this.panels.replaceChildren(...this.panes.map((pane) => pane.box));
    this.panels.style.setProperty("--panel-width", shown > 2 && width > 1.3 * height ? "max(34%, 300px)" : "230px");
    this.panels.style.maxWidth = shown === 1 ? `${Math.min(900, 520 * width / height)}px` : "";
    const frames = Math.max(...this.flights.map((flight) => flight.last));
    this.speed.value = SPEEDS.find((speed) => speed * 20 >= this.shownLast() * stride) || SPEEDS.at(-1);
    this.play(false);
    this.shade();
    this.go(Math.min(frames, this.shownLast()));
    this.fresh = true;
  }

  shownLast() { return Math.max(...this.panes.map((pane) => pane.flight.last)); }
  layer(name) { return this.layers[name].checked; }

  shade() {
    const pack = (name) => { const [r, g, b] = rgb(name); return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0; };
    this.shades = {
      unknown: pack("--unknown"), ghostFree: pack("--ghost-free"), ghostWall: pack("--ghost-wall"),
      free: pack("--free"), wall: pack("--wall"),
    };
  }

  go(frame) {
    this.fresh = false;
    this.frame = Math.max(0, Math.min(this.shownLast(), frame));
    this.draw();
  }

  draw() {
    this.frame = Math.min(this.frame, this.shownLast());
    for (const pane of this.panes) pane.draw(this.frame);
    this.slider.max = this.shownLast();
    this.slider.value = this.frame;
    const stride = this.episode.stride, last = Math.max(...this.panes.map((pane) => pane.flight.steps.at(-1)));
    const now = Math.min(this.frame * stride, last);
    this.clock.textContent = `step ${now} of ${last}`;
    this.slider.setAttribute("aria-valuetext", this.clock.textContent);
    this.drawTimeline();
  }

  frameAt(x) { return Math.round(x / this.timeline.clientWidth * this.shownLast()); }

  drawTimeline() {
    const ratio = window.devicePixelRatio || 1;
    const width = this.timeline.clientWidth * ratio, height = this.timeline.clientHeight * ratio;
    this.timeline.width = width;
    this.timeline.height = height;
    const pen = this.timeline.getContext("2d"), last = Math.max(1, this.shownLast()), top = 6 * ratio;
    const x = (frame) => frame / last * (width - 2 * ratio) + ratio, y = (share) => height - ratio - share * (height - top - ratio);
    pen.strokeStyle = Theme.colour("--line");
    pen.lineWidth = ratio;
    for (const share of [0, 0.5, 0.9, 1]) {
      pen.beginPath();
      pen.moveTo(0, y(share));
      pen.lineTo(width, y(share));
      pen.stroke();
    }
    for (const pane of this.panes) this.drawCurve(pen, pane, x, y, ratio);
    pen.strokeStyle = Theme.colour("--ink");
    pen.lineWidth = ratio;
    pen.beginPath();
    pen.moveTo(x(this.frame), 0);
    pen.lineTo(x(this.frame), height);
    pen.stroke();
  }

  drawCurve(pen, pane, x, y, ratio) {
    const { covered, last } = pane.flight, total = this.episode.total;
    pen.strokeStyle = pen.fillStyle = Theme.colour(`--c${pane.policy.colour}`);
    pen.lineWidth = 2 * ratio;
    pen.setLineDash(DASHES[pane.policy.dash].map((length) => length * ratio));
    pen.beginPath();
    for (let f = 0; f <= last; f++) pen.lineTo(x(f), y(covered[f] / total));
    pen.stroke();
    pen.setLineDash([]);
    const now = Math.min(this.frame, last);
    pen.beginPath();
    pen.arc(x(now), y(covered[now] / total), 3.5 * ratio, 0, 2 * Math.PI);
    pen.fill();
  }

  play(on) {
    this.playing = on;
    this.button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (this.fresh || this.frame >= this.shownLast()) this.go(0);
    let before = performance.now(), owed = 0;
    const tick = (now) => {
      if (!this.playing) return;
      owed += (now - before) / 1000 * Number(this.speed.value) / this.episode.stride;
      before = now;
      const whole = Math.floor(owed);
      owed -= whole;
      if (whole) this.go(this.frame + whole);
      if (this.frame >= this.shownLast()) this.play(false); else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  key(event) {
    if (["SELECT", "BUTTON"].includes(event.target.tagName) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.type === "checkbox" && event.key === " ") return;
    const jump = event.shiftKey ? 10 : 1;
    const moves = { ArrowLeft: this.frame - jump, ArrowRight: this.frame + jump, Home: 0, End: this.shownLast() };
    if (event.key === " ") this.play(!this.playing);
    else if (event.key in moves) { this.play(false); this.go(moves[event.key]); }
    else return;
    event.preventDefault();
  }
}

for (const box of document.querySelectorAll(".replay")) new Replay(box);

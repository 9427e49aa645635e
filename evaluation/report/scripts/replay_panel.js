/* One panel of the replay: a policy's flight on the map, with coverage, steps and outcome. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in made) made[name] = value; else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}
function share(part, whole) { return `${(100 * part / whole).toFixed(1)} %`; }
function grouped(number) { return String(number).replace(/\B(?=(\d{3})+$)/g, "\u202f"); }
function byteCount(bytes) {
  if (bytes < 1000) return `${bytes} B`;
  const [size, unit] = bytes < 1e6 ? [bytes / 1e3, "kB"] : [bytes / 1e6, "MB"];
  return `${size.toFixed(size < 100 ? 1 : 0)} ${unit}`;
}

class Panel {
  constructor(replay, place) {
    this.replay = replay;
    this.choice = element("select", { ariaLabel: `Policy of panel ${place + 1}` });
    this.choice.addEventListener("change", () => replay.putPolicy(place, Number(this.choice.value)));
    this.chip = element("canvas", { className: "chip", width: 52, height: 20, ariaHidden: "true" });
    this.canvas = element("canvas", { className: "map", role: "img" });
    this.sheet = element("canvas");
    this.covered = element("b");
    this.spent = element("span", { className: "spent" });
    this.end = element("span", { className: "end" });
    this.twins = element("small", { className: "twins" });
    this.whys = element("div", { className: "whys", role: "group" });
    this.canvas.addEventListener("click", (event) => this.pick(event, this.marks));
    this.box = element("div", { className: "panel" },
      element("div", { className: "head" }, this.chip, this.choice),
      element("div", { className: "window" }, this.canvas),
      element("div", { className: "readout" }, this.covered, this.end, this.spent), this.whys, this.twins);
  }

  get policy() { return this.replay.data.policies[this.flight.policy]; }

  show(flight, flights) {
    this.flight = flight;
    this.choice.replaceChildren(...flights.map((each) =>
      element("option", { value: each.policy, textContent: this.nameOf(each) })));
    this.choice.value = String(flight.policy);
    this.box.dataset.policy = this.policy.name;
    const others = flights.filter((each) => each.same === flight.policy).map((each) => this.replay.data.policies[each.policy].name);
    this.offer();
    this.twins.textContent = others.length ? `same flights: ${others.join(", ")}` : "";
  }

  /* A button for each UAV, to explain it. */
  offer() {
    const { flight, policy } = this, alone = flight.team === 1;
    this.whys.setAttribute("aria-label", `Explain a UAV of ${policy.name}`);
    this.asks = Array.from({ length: flight.team }, (_, uav) => {
      const title = `Explain where UAV ${uav} of ${policy.name} flies`;
      return button(alone ? "Explain" : String(uav), title, () => this.replay.why.choose({ policy: flight.policy, uav }));
    });
    this.whys.replaceChildren(...(alone ? [] : [element("span", { textContent: "Explain UAV" })]), ...this.asks);
  }

  /* Explain the UAV that was clicked at, or tapped near, on a canvas with ``marks``. */
  pick(event, marks) {
    if (!marks) return;
    const { width, clientWidth } = event.currentTarget, shrunk = width / clientWidth, near = Math.max(1.5 * marks.radius, 16 * shrunk);
    const away = this.asks.map((_, uav) => {
      const [x, y] = marks.at(uav);
      return Math.hypot(x - event.offsetX * shrunk, y - event.offsetY * shrunk);
    });
    const uav = away.indexOf(Math.min(...away));
    if (away[uav] <= near) this.replay.why.choose({ policy: this.flight.policy, uav });
  }

  nameOf({ policy, same }) {
    const { policies } = this.replay.data;
    return policies[policy].name + (same === null ? "" : ` (same flights as ${policies[same].name})`);
  }

  /* Whether all that counts is covered now although cells are unknown. */
  hasPockets() {
    const { flight, replay } = this, now = Math.min(replay.frame, flight.last), { counts } = replay.data;
    return flight.covered[counts][now] === replay.episode.total && flight.maps[counts].at(now).some((frame, cell) =>
      frame > now && !replay.grid.isBetween(Math.floor(cell / replay.episode.width)));
  }

  /* Coverage of the shown map at a frame, in cells. */
  coveredAt(frame) { return this.flight.covered[this.replay.mapOf(this.flight)][Math.min(frame, this.flight.last)]; }

  draw(frame, scale, ratio) {
    const { episode, grid, inks, layers, data } = this.replay, now = Math.min(frame, this.flight.last);
    const map = this.replay.mapOf(this.flight), pen = this.canvas.getContext("2d");
    this.canvas.width = scale * grid.width;
    this.canvas.height = scale * grid.height;
    this.canvas.classList.toggle("levels", grid.levels > 1);
    this.canvas.style.width = `${Math.min(this.canvas.width / ratio, this.replay.most)}px`;
    paintCells(this.sheet, episode, grid, this.flight.maps[map].at(now), this.flight.wrong.at(now), now, layers, inks);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(this.sheet, 0, 0, this.canvas.width, this.canvas.height);
    grid.outline(pen, scale, ratio, inks);
    const marks = this.marks = new Marks(pen, this.flight, episode.base, now, scale, ratio, inks, grid);
    const { why } = this.replay, told = why.toldOn(this, now);
    if (layers.has("lidar")) marks.lidar(data.range);
    if (layers.has("trails")) marks.trails();
    if (layers.has("links")) marks.links();
    marks.pad();
    if (told) markTold(marks, why.chosen.uav, told, episode.width);
    marks.team(map);
    this.asks.forEach((ask, uav) => ask.setAttribute("aria-pressed", String(why.isChosen(this.flight.policy, uav))));
    this.drawChip();
    this.read(now);
  }

  read(now) {
    const { flight, replay } = this, over = now === flight.last, stopped = flight.stops.filter((frame) => frame <= now).length;
    this.covered.textContent = share(this.coveredAt(now), this.replay.episode.total);
    const spent = [`step ${flight.steps[now]}`, `${grouped(flight.distance[now])} cells flown`];
    if (flight.bytes[flight.last]) spent.push(`${byteCount(flight.bytes[now])} sent`);
    if (flight.covered.base) {
      const [name, covered] = replay.map === "base" ? ["team and base", "team"] : ["at the base", "base"];
      spent.unshift(`${name} ${share(flight.covered[covered][now], replay.episode.total)}`);
    }
    this.spent.textContent = spent.join(" · ");
    this.end.textContent = (over ? flight.end : "flying") + (stopped ? ` · ${stopped} of ${flight.team} stopped` : "");
    this.end.title = over ? flight.end : "";
    this.canvas.setAttribute("aria-label", `Map at step ${flight.steps[now]} of ${this.policy.name}`);
    this.canvas.title = "Click a UAV to see why it flies where it does";
  }

  get summary() { return `${this.policy.name}: ${this.covered.textContent}, ${this.end.textContent}`; }

  drawChip() {
    const pen = this.chip.getContext("2d");
    pen.clearRect(0, 0, this.chip.width, this.chip.height);
    pen.strokeStyle = this.replay.inks.policy(this.policy);
    pen.lineWidth = 4;
    pen.setLineDash(this.policy.dashes.map((length) => 2 * length));
    pen.beginPath();
    pen.moveTo(0, 10);
    pen.lineTo(this.chip.width, 10);
    pen.stroke();
  }
}

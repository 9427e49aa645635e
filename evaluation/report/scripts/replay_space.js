/* Replays of several levels also in three dimensions, beside the slices; the script is in pages with levels alone. */
const NO_WEBGL = "There is no view in three dimensions, as this browser offers no WebGL 2; the slices show the same cells.";

class Space {
  constructor(replay) {
    this.replay = replay;
    this.panels = [];
    this.view = "both";
    this.orbit = new Orbit(() => this.turned());
    this.views = element("div", { className: "choice", role: "group", ariaLabel: "View" }, ...Object.entries({
      slices: "Slices", both: "Both", space: "3D" }).map(([view, title]) => {
      const made = element("button", { type: "button", textContent: title, value: view });
      made.addEventListener("click", () => { this.view = view; replay.arrange(); });
      return made;
    }));
    this.slider = element("input", { type: "range", min: 1, ariaLabel: "Levels shown" });
    this.slider.addEventListener("input", () => this.draw());
    this.count = element("output");
    this.cut = element("label", { className: "cut" }, "Levels shown", this.slider, this.count);
    this.back = button("Reset view", "Look at the whole building from above", () => { this.reset(); this.turned(); });
    this.bar = element("div", { className: "spacebar" }, element("span", { className: "pair" }, "View", this.views), this.back, this.cut);
    this.note = element("p", { className: "said", hidden: true }, NO_WEBGL);
    replay.box.querySelector(".top").append(this.bar);
    replay.controls.note.after(this.note);
  }

  /* Whether there are levels to show, and something to show them with. */
  get isOn() { return Boolean(this.replay.episode.levels && Renderer.one); }

  colours() {
    return Object.fromEntries(["low", "high", "floor", "frontier", "border"].map((name) =>
      [name, Theme.colour(name === "frontier" ? "--frontier" : `--space-${name}`)]));
  }

  /* Whether canvases are shown now. */
  get isShown() { return this.isOn && this.view !== "slices"; }

  /* Take the panels, and where it is another one, the building. */
  arrange() {
    const { episode, box, controls } = this.replay, { isOn, isShown } = this;
    this.note.hidden = !episode.levels || isOn;
    this.bar.hidden = !isOn;
    this.back.hidden = this.cut.hidden = !isShown;
    box.classList.toggle("in-space", isShown);
    box.classList.toggle("no-slices", isShown && this.view === "space");
    for (const each of this.views.children) each.setAttribute("aria-pressed", String(each.value === this.view));
    this.seat(isShown ? this.replay.panels : []);
    if (!isShown) { controls.grid.classList.remove("beside"); return; }
    const other = this.episode !== episode;
    if (other) this.open(episode);
    this.layOut();
    for (const each of this.panels) each.resize(...this.size);
    const [width, height] = this.size;
    if (other || Math.abs(width / height - this.orbit.fitted) > 0.02) this.reset();
  }

  seat(panels) {
    if (panels.length === this.panels.length && panels.every((panel, k) => panel === this.panels[k].panel)) return;
    for (const each of this.panels) each.remove();
    this.panels = panels.map((panel) => new SpacePanel(panel, this));
  }

  open(episode) {
    this.episode = episode;
    this.voxels = new Voxels(episode, new LevelGrid(episode));
    this.slider.max = String(episode.levels);
    this.slider.value = String(this.voxels.underRoof);
    for (const each of this.panels) each.flight = null;
  }

  /* Share the page between slices and canvases: beside each other where a single panel has room for that, otherwise one
     below the other. Scales of slices are whole numbers, but on a narrow screen, as on maps of one level. */
  layOut() {
    const { replay } = this, { panels, controls } = replay, ratio = window.devicePixelRatio || 1, gap = 18;
    const columns = narrow() ? 1 : Math.min(2, panels.length), only = this.view === "space";
    const room = replay.room = controls.stage.clientWidth, share = Math.floor((room - gap * (columns - 1)) / columns);
    const high = Math.max(500, Math.min(1000, window.innerHeight - 250) / Math.ceil(panels.length / columns) - 90);
    const beside = !only && share >= 760, wide = beside ? Math.floor(share * 0.46) : share - 2;
    const { grid, scale, tall } = this.slices(wide, beside ? high : high * (narrow() ? 0.6 : 0.42), ratio);
    replay.grid = grid;
    replay.most = narrow() ? Math.min(wide, tall * grid.width / grid.height) : Infinity;
    replay.scale = narrow() ? Math.ceil(replay.most / grid.width * ratio) : scale;
    const slices = Math.floor(scale * grid.width / ratio), width = beside ? share - Math.max(slices, 300) - gap : share;
    const height = Math.round(only || beside ? Math.min(width * 0.8, high) : Math.max(320, high * 0.58));
    controls.grid.classList.toggle("beside", beside);
    controls.grid.style.width = `${columns * share + gap * (columns - 1)}px`;
    controls.grid.style.gridTemplateColumns = `repeat(${columns}, minmax(0, ${share}px))`;
    controls.grid.style.setProperty("--slices", `${Math.max(slices, 300)}px`);
    this.size = [width, Math.min(height, narrow() ? width * 0.95 : Infinity), ratio];
  }

  /* The grid of levels that shows the cells largest within some room, which is higher where they would be tiny. */
  slices(wide, tall, ratio) {
    const fit = (grid) => Math.min(wide / grid.width, tall / grid.height) * ratio;
    const grid = LevelGrid.options(this.replay.episode).reduce((one, other) => (fit(other) > fit(one) ? other : one));
    const scale = Math.max(1, Math.floor(fit(grid)));
    return scale < 3 * ratio && tall < window.innerHeight * 0.5 ? this.slices(wide, tall * 1.3, ratio) : { grid, scale, tall };
  }

  reset() {
    const { voxels, panels } = this, { canvas } = panels[0];
    this.orbit.reset([voxels.width, voxels.grid.levels, voxels.grid.high], canvas.width / canvas.height);
  }

  get levels() { return Number(this.slider.value); }

  draw() {
    if (!this.panels.length || this.episode !== this.replay.episode) return;
    this.count.textContent = `${this.levels} of ${this.slider.max}`;
    for (const each of this.panels) {
      each.load(this.voxels, this.replay.inks);
      each.draw(this.replay.frame, this.levels);
    }
  }

  /* The camera moved. */
  turned() {
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      for (const each of this.panels) each.render();
    });
  }
}

/* The constructor of a replay draws, so that its space is made when it is first asked for. */
class SpaceReplay extends Replay {
  get space() { return (this.made ??= new Space(this)); }

  arrange() {
    this.space.arrange();
    if (this.space.isShown) this.draw(); else super.arrange();
  }

  draw() {
    super.draw();
    this.space.draw();
  }

  key(event) { if (event.target.type !== "range") super.key(event); }
}
Replay = SpaceReplay;

/* The episode viewer: up to four policies side by side on one map and seed, one timeline for all. */
const SPEEDS = [2, 5, 10, 20, 50, 100, 200, 500];
const MOST_PANELS = 4;
function narrow() { return window.innerWidth <= 720; }

class Replay {
  constructor(box) {
    this.box = box;
    this.section = box.id.slice("replay-".length);
    this.data = JSON.parse(document.getElementById(`replay-data-${this.section}`).textContent);
    this.inks = new Inks();
    this.layers = new Set(LAYERS.map(([name]) => name));
    this.panels = [];
    this.frame = 0;
    this.map = this.data.counts;  // team, base, or the number of a UAV as text
    this.playing = false;
    this.wanted = [];
    this.count = narrow() ? 1 : MOST_PANELS;
    this.why = new Why(this);
    this.controls = new Controls(this);
    this.open(0);
    box.addEventListener("keydown", (event) => this.key(event));
    Theme.listeners.push(() => { this.inks = new Inks(); this.draw(); });
    new ResizeObserver(() => {
      if (this.controls.stage.clientWidth !== this.room) this.arrange();
    }).observe(this.controls.stage);
  }

  /* Show an episode where its flights differ most; playing starts from its beginning. */
  open(place) {
    this.episode = this.data.episodes[place];
    this.place = place;
    this.unpack(this.episode);
    this.play(false);
    this.controls.opened();
    this.seat();
    this.controls.pace();
    this.frame = this.widest();
    this.fresh = true;
    this.draw();
  }

  /* Whether there is anything of a layer. */
  has(layer) { return layer !== "prior" || this.data.episodes.some((episode) => episode.prior); }

  /* The frame at which the coverage of the shown flights, or of the first ones where a single one is shown, is
     furthest apart, those far behind left out; half-way where it never is. */
  widest() {
    const shown = this.panels.length > 1 ? this.panels.map((panel) => panel.flight.policy) : this.single.slice(0, MOST_PANELS);
    const near = shown.filter((policy) => !this.data.policies[policy].far);
    const flights = (near.length > 1 ? near : shown).map((policy) => this.flight(policy));
    let found = Math.round(this.last / 2), most = 0;
    for (let frame = 0; frame <= this.last; frame++) {
      const covered = flights.map((flight) => flight.covered[this.data.counts][Math.min(frame, flight.last)]);
      const apart = Math.max(...covered) - Math.min(...covered);
      if (apart > most) [found, most] = [frame, apart];
    }
    return found;
  }

  unpack(episode) {
    if (episode.walls instanceof Uint8Array) return;
    const cells = { length: episode.width * episode.height };
    for (const [from, to] of [["walls", "walls"], ["counted", "isCounted"], ["prior", "prior"]]) {
      if (!episode[from]) continue;
      const bits = Packed.bytes(episode[from]);
      episode[to] = Uint8Array.from(cells, (_, k) => (bits[k >> 3] >> (7 - (k & 7))) & 1);
    }
  }

  /* Give each panel a policy: first those the reader chose, if the episode has them; same flights have one panel. */
  seat() {
    const flights = this.episode.flights, has = (policy) => flights.some((flight) => flight.policy === policy);
    const order = [...new Set([...this.wanted.filter(has), ...this.single])];
    const seated = order.slice(0, this.count);
    if (this.panels.length !== seated.length) this.panels = seated.map((_, place) => new Panel(this, place));
    this.panels.forEach((panel, place) => panel.show(this.flight(seated[place]), flights));
    this.controls.seated();
    this.arrange();
  }

  /* The policies of the episode without those whose flights are another one's. */
  get single() { return this.episode.flights.filter((flight) => flight.same === null).map((flight) => flight.policy); }

  flight(policy) {
    const place = this.episode.flights.findIndex((flight) => flight.policy === policy);
    const flight = this.episode.flights[place];
    return flight.maps ? flight : (this.episode.flights[place] = readFlight(flight, this.episode));
  }

  /* Show a policy in a panel; if another panel shows it, the two swap. */
  putPolicy(place, policy) {
    const shown = this.panels.map((panel) => panel.flight.policy), other = shown.indexOf(policy);
    if (other >= 0) shown[other] = shown[place];
    shown[place] = policy;
    this.wanted = [...new Set([...shown, ...this.wanted])];
    this.seat();
    this.changed();
  }

  get shownLayers() { return LAYERS.map(([name]) => name).filter((name) => this.has(name) && this.layers.has(name)); }
  get last() { return Math.max(...this.panels.map((panel) => panel.flight.last)); }
  get lastStep() { return Math.max(...this.panels.map((panel) => panel.flight.steps.at(-1))); }
  get step() { return Math.min(this.frame * this.episode.stride, this.lastStep); }
  frameOf(step) { return step >= this.lastStep ? this.last : Math.round(step / this.episode.stride); }
  mapOf(flight) { return this.map in flight.maps ? this.map : "team"; }

  /* Choose the columns, of panels and of levels, that show the cells largest without filling more than a screen; scales
     are whole numbers.
     A map that is wider than the page even at one pixel a cell is scrolled in its panel. On a narrow screen maps are
     as wide as their column, whatever their scale. */
  arrange() {
    const ratio = window.devicePixelRatio || 1, panels = this.panels.length;
    const room = this.room = this.controls.stage.clientWidth, gap = 18;
    const screen = Math.min(1000, Math.max(480, window.innerHeight - 250));
    const even = Array.from({ length: panels }, (_, k) => panels - k).filter((columns) => panels % columns === 0);
    const options = even.flatMap((columns) => LevelGrid.options(this.episode).map((grid) => {
      const rows = Math.ceil(panels / columns), tallest = screen / rows - 90;
      const wide = (room - gap * (columns - 1)) / columns - 2;
      const widest = Math.floor(wide / grid.width * ratio), highest = Math.floor(Math.max(tallest, 120) / grid.height * ratio);
      return { columns, grid, scale: Math.min(widest, Math.max(1, highest)), wide, tallest: Math.max(tallest, 120) };
    }));
    const best = options.reduce((one, other) => (other.scale > one.scale ? other : one)), { width, height } = best.grid;
    this.grid = best.grid;
    this.most = narrow() ? Math.min(best.wide, best.tallest * width / height) : Infinity;
    this.scale = narrow() ? Math.ceil(this.most / width * ratio) : Math.max(1, best.scale);
    const taken = Math.min(best.wide, Math.max(210, this.scale * width / ratio + 2));
    this.controls.grid.style.width = `${best.columns * taken + gap * (best.columns - 1)}px`;
    this.controls.grid.style.gridTemplateColumns = `repeat(${best.columns}, minmax(0, ${taken}px))`;
    this.draw();
  }

  seek(frame) {
    this.play(false);
    this.go(frame);
  }

  go(frame) {
    this.fresh = false;
    this.frame = Math.max(0, Math.min(this.last, frame));
    this.changed();
  }

  changed() {
    this.draw();
    if (!this.playing) Address.write(this);
  }

  draw() {
    this.frame = Math.min(this.frame, this.last);
    const ratio = window.devicePixelRatio || 1;
    for (const panel of this.panels) panel.draw(this.frame, this.scale, ratio);
    this.why.draw(this.frame);
    this.controls.timeline.draw();
    this.controls.drawn();
  }

  play(on) {
    const was = this.playing;
    this.playing = on;
    this.controls.playing(on);
    if (was && !on) Address.write(this);
    if (on && !was) this.run();
  }

  run() {
    if (this.fresh || this.frame >= this.last) this.go(0);
    let before = performance.now(), owed = 0;
    const tick = (now) => {
      if (!this.playing) return;
      owed += (now - before) / 1000 * this.controls.stepsPerSecond / this.episode.stride;
      before = now;
      const whole = Math.floor(owed);
      owed -= whole;
      if (whole > 0) this.go(this.frame + whole);
      if (this.frame >= this.last) this.play(false); else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  key(event) {
    const { tagName, type } = event.target;
    if (tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
    if ((tagName === "BUTTON" || type === "checkbox") && event.key === " ") return;
    const jump = event.shiftKey ? 10 : 1;
    const moves = {
      ArrowLeft: this.frame - jump, ArrowRight: this.frame + jump, Home: 0, End: this.last,
      PageDown: this.frame - 10, PageUp: this.frame + 10,
    };
    if (event.key === " ") this.play(!this.playing);
    else if (event.key === "Escape" && this.why.panel) this.why.choose(null);
    else if (event.key in moves) this.seek(moves[event.key]);
    else return;
    event.preventDefault();
  }

  say(words) { this.controls.note.textContent = words; }

  /* Return the place of a task, or of the nearest one in the page, with a message. */
  find(task) {
    const { episodes } = this.data, same = (k) => (episode) => episode.task[k] === task[k];
    this.say("");
    if (!task) return 0;
    const exact = episodes.findIndex((episode) => same(0)(episode) && same(1)(episode));
    if (exact >= 0) return exact;
    const near = Math.max(0, episodes.findIndex(same(0)));
    this.say(`The episode with seed ${task[1]} on map ${task[0]} is not embedded in this page; this is the nearest one, ${
      episodes[near].label}. To embed all: indoor-explorers report DIR --out FILE.html --replays ${this.data.tasks}`);
    return near;
  }

  /* Open what openReplay() asks for and bring it into view. */
  reveal(name, task, step) {
    const policy = this.data.policies.findIndex((each) => each.name === name);
    this.open(this.find(task));
    if (policy >= 0 && this.episode.flights.some((flight) => flight.policy === policy)) {
      if (!this.panels.some((panel) => panel.flight.policy === policy)) this.putPolicy(0, policy);
    } else if (name !== null) this.say(`${this.controls.note.textContent} ${name} is not embedded in this episode.`);
    if (step !== null) this.go(this.frameOf(step));
    this.changed();
    this.box.scrollIntoView({ block: "start" });
    this.box.focus({ preventScroll: true });
  }

  /* Open what an address names. */
  restore({ task, step, panels, map, layers, why }) {
    const named = (panels || []).map((name) => this.data.policies.findIndex((policy) => policy.name === name));
    const policies = [...new Set(named.filter((policy) => policy >= 0))].slice(0, MOST_PANELS);
    if (policies.length) [this.wanted, this.count] = [policies, policies.length];
    if (map !== null) this.map = map;
    const explained = why ? this.data.policies.findIndex((policy) => policy.name === why[0]) : -1;
    this.why.chosen = explained >= 0 ? { policy: explained, uav: Number(why[1]) } : null;
    if (layers) this.layers = new Set(LAYERS.map(([name]) => name).filter((name) => layers.includes(name)));
    this.open(this.find(task));
    if (step !== null) this.go(this.frameOf(step));
    this.box.scrollIntoView({ block: "start", behavior: "instant" });
  }
}

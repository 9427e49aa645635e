/* The controls of a replay: choices above the panels, playback below them. */
function choose(title, options, chosen) {
  const select = element("select", { ariaLabel: title });
  select.addEventListener("change", () => chosen(select.value));
  fill(select, options);
  return select;
}
function fill(select, options) {
  select.replaceChildren(...options.map(([value, textContent]) => element("option", { value, textContent })));
}
function button(textContent, title, pressed) {
  const made = element("button", { type: "button", className: "quiet", textContent, title, ariaLabel: title });
  made.addEventListener("click", pressed);
  return made;
}

const POCKETS = "100 % is all that counts as coverage: cells that are still unknown are walls, or cannot be reached.";

class Controls {
  constructor(replay) {
    this.replay = replay;
    this.timeline = new Timeline(replay);
    this.grid = element("div", { className: "panels" });
    this.stage = element("div", { className: "stage" }, this.grid, replay.why.box);
    this.note = element("p", { className: "said", role: "status" });
    this.spoken = element("p", { className: "unseen", ariaLive: "polite" });
    this.pockets = element("p", { className: "pockets", hidden: true }, POCKETS);
    const deck = element("div", { className: "deck" }, this.timeline.box, this.transport());
    replay.box.append(this.choices(), this.note, this.stage, this.pockets, deck, this.spoken);
  }

  choices() {
    const { data } = this.replay;
    this.episodes = choose("Episode", data.episodes.map(({ label, map, task }, place) =>
      [place, `${label} · ${map} · seed ${task[1]}`]), (place) => {
      this.replay.say("");
      this.replay.open(Number(place));
      this.replay.changed();
    });
    this.maps = choose("Map of", [], (map) => { this.replay.map = map; this.replay.changed(); });
    this.mapLabel = element("label", {}, "Map of", this.maps);
    this.counts = element("div", { className: "choice", role: "group", ariaLabel: "Panels" });
    return element("div", { className: "top" }, element("label", {}, "Episode", this.episodes), this.mapLabel,
      element("span", { className: "pair" }, "Panels", this.counts), this.toggles());
  }

  toggles() {
    this.boxes = LAYERS.filter(([name]) => this.replay.has(name)).map(([name, title]) => {
      const box = element("input", { type: "checkbox", name });
      box.addEventListener("change", () => {
        if (box.checked) this.replay.layers.add(name); else this.replay.layers.delete(name);
        this.replay.changed();
      });
      return element("label", { className: `layer ${name}` }, box, title);
    });
    return element("div", { className: "layers", role: "group", ariaLabel: "Layers" }, ...this.boxes);
  }

  transport() {
    const { replay } = this;
    this.play = element("button", { type: "button", className: "play" });
    this.play.addEventListener("click", () => replay.play(!replay.playing));
    this.clock = element("span", { className: "clock" });
    this.speed = choose("Speed", SPEEDS.map((speed) => [speed, `${speed} steps/s`]),
      () => { this.paced = true; });
    return element("div", { className: "transport" }, this.play,
      button("|‹", "To the start", () => replay.seek(0)), button("‹", "One step back", () => replay.seek(replay.frame - 1)),
      button("›", "One step on", () => replay.seek(replay.frame + 1)),
      button("›|", "To the end", () => replay.seek(replay.last)), this.clock, this.speed,
      button("Copy link", "Copy a link to this moment", () => Address.copy(replay)));
  }

  get stepsPerSecond() { return Number(this.speed.value); }

  /* An episode was opened. */
  opened() {
    const { episode, place } = this.replay, team = Math.max(...episode.flights.map((flight) => flight.team));
    this.episodes.value = String(place);
    const uavs = Array.from({ length: team }, (_, uav) => [uav, `UAV ${uav}`]);
    const base = episode.base ? [["base", "home base"]] : [];
    fill(this.maps, [["team", base.length ? "team and base" : "team"], ...base, ...(episode.own ? uavs : [])]);
    if (![...this.maps.options].some(({ value }) => value === this.replay.map)) this.replay.map = this.replay.data.counts;
    this.maps.value = this.replay.map;
    this.mapLabel.hidden = team === 1 && !episode.base;
    this.maps.title = episode.own || episode.revised ? "" : "This page has no room for the maps of single UAVs";
    const most = Math.min(MOST_PANELS, this.replay.single.length);
    this.counts.replaceChildren(...Array.from({ length: most }, (_, k) => {
      const made = element("button", { type: "button", textContent: k + 1 });
      made.addEventListener("click", () => { this.replay.count = k + 1; this.replay.seat(); this.replay.changed(); });
      return made;
    }));
    this.counts.parentElement.hidden = most === 1;
    for (const label of this.boxes) label.firstChild.checked = this.replay.layers.has(label.firstChild.name);
  }

  /* The panels were filled. */
  seated() {
    const { panels } = this.replay;
    this.grid.replaceChildren(...panels.map((panel) => panel.box));
    [...this.counts.children].forEach((each, k) => each.setAttribute("aria-pressed", String(k + 1 === panels.length)));
  }

  /* Choose a speed that takes some seconds, unless the reader has chosen one. */
  pace() {
    if (!this.paced) this.speed.value = SPEEDS.find((speed) => speed * 8 >= this.replay.lastStep) || SPEEDS.at(-1);
  }

  playing(on) { this.play.textContent = on ? "Pause" : "Play"; }

  /* A frame was drawn; announce it to screen readers once playing stops. */
  drawn() {
    const { step, lastStep, episode } = this.replay;
    this.clock.textContent = `step ${step} of ${lastStep}${episode.stride > 1 ? `, every ${episode.stride}` : ""}`;
    this.pockets.hidden = !this.replay.panels.some((panel) => panel.hasPockets());
    clearTimeout(this.resting);
    if (!this.replay.playing) this.resting = setTimeout(() => this.speak(), 700);
  }

  speak() {
    const { step, panels, fresh, why } = this.replay;
    if (!fresh) this.spoken.textContent = `Step ${step}. ${panels.map((panel) => panel.summary).join("; ")}${why.summary}`;
  }
}

const viewers = new Map();
/* Opens a replay at a step: from the address, openReplay(), or elements with a data-replay attribute. */
const Address = {
  /* Read ``replay=s1;task=0,7;step=57;panels=pso,dddqn;map=uav-1;layers=truth,trails;why=pso,1``, which explains UAV 1
     of pso; unknown parts are left out. */
  read(hash) {
    const found = {};
    for (const part of hash.replace(/^#/, "").split(";")) {
      const [key, ...rest] = part.split("=");
      found[key] = rest.join("=").split(",").map(this.decoded);
    }
    const whole = (text) => (/^\d+$/.test(text) ? Number(text) : null);
    if (!found.replay) return null;
    return {
      section: found.replay[0],
      task: found.task?.length === 2 && found.task.every((text) => whole(text) !== null) ? found.task.map(whole) : null,
      step: found.step ? whole(found.step[0]) : null,
      panels: found.panels || null,
      map: found.map ? this.mapNamed(found.map[0]) : null,
      layers: found.layers || null,
      why: found.why?.length === 2 && whole(found.why[1]) !== null ? found.why : null,
    };
  },

  /* ``team``, ``base`` or ``uav-0``; in links of older pages 0 is the team, and UAVs count from 1. */
  mapNamed(text) {
    if (text === "base") return text;
    const [, uav, older] = text.match(/^(?:uav-(\d+)|(\d+))$/) || [];
    if (uav) return String(Number(uav));
    return Number(older) > 0 ? String(Number(older) - 1) : "team";
  },

  decoded(text) {
    try { return decodeURIComponent(text); } catch { return text; }
  },

  of(replay) {
    const names = replay.panels.map((panel) => encodeURIComponent(panel.policy.name));
    const parts = {
      replay: replay.section, task: replay.episode.task.join(","), step: replay.step, panels: names.join(","),
      map: /^\d+$/.test(replay.map) ? `uav-${replay.map}` : replay.map, layers: replay.shownLayers.join(","),
    };
    if (replay.why.address) parts.why = replay.why.address;
    const theme = location.hash.slice(1).split(";").filter((part) => part === "dark" || part === "light");
    return `#${[...Object.entries(parts).map((part) => part.join("=")), ...theme].join(";")}`;
  },

  /* Browsers limit how often the address may change, so only the last change is written. */
  write(replay) {
    this.waiting = replay;
    this.timer ??= setTimeout(() => this.flush(), 300);
  },

  flush() {
    clearTimeout(this.timer);
    this.timer = null;
    try { history.replaceState(history.state, "", this.of(this.waiting)); } catch { /* a sandbox may forbid it */ }
  },

  async copy(replay) {
    this.waiting = replay;
    this.flush();
    try {
      await navigator.clipboard.writeText(location.href);
      replay.say("Link copied.");
    } catch {
      replay.say("The link could not be copied; it is now the address of this page.");
    }
  },

  /* Go where an address leads; a write of the moment before, still waiting, would lead back. */
  follow(hash) {
    clearTimeout(this.timer);
    this.timer = null;
    const asked = this.read(hash);
    if (asked) withReplay(asked.section, (replay) => replay.restore(asked));
  },
};

/* Do something with the replay of a section, at once where it is there. */
function withReplay(section, act) {
  if (viewers.has(section)) act(viewers.get(section));
  else if (document.getElementById(section)?.dataset.part) Parts.load(section).then(() => viewers.has(section) && act(viewers.get(section)));
}
window.openReplay = (section, { policy = null, task = null, step = null } = {}) => {
  withReplay(section, (replay) => replay.reveal(policy, task, step));
};

function openFrom(source) {
  let asked;
  try { asked = JSON.parse(source.dataset.replay); } catch { return; }
  window.openReplay(asked.section || source.closest("section")?.id, asked);
}
document.addEventListener("click", (event) => {
  const source = event.target.closest("[data-replay]");
  if (source) openFrom(source);
});
document.addEventListener("keydown", (event) => {
  const source = event.target.closest("[data-replay]");
  if (event.key === "Enter" && source && !["BUTTON", "A"].includes(event.target.tagName)) openFrom(source);
});
window.addEventListener("hashchange", (event) => Address.follow(new URL(event.newURL).hash));

Parts.each((part) => {
  for (const box of part.querySelectorAll(".replay")) {
    const replay = new Replay(box);
    viewers.set(replay.section, replay);
  }
});
Address.follow(location.hash);

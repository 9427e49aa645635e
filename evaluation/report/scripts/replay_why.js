/* Why a UAV flies where it does: unpacks what its pilot told, says it beside the maps, and marks it on its map. */
const CHANGED = { choice: 1, candidates: 2, way: 4, nothing: 8 };

/* What one UAV told: entries that hold from a step on, each with all that holds then; null for nothing. */
function readTold(stream, texts, width) {
  const numbers = new Numbers(stream), entries = [], place = () => numbers.next() - 1;
  const value = () => {
    const exponent = numbers.signed(), mantissa = numbers.signed();
    return exponent === 127 ? NaN : Number(`${mantissa}e${exponent}`);
  };
  const moves = [width, -1, -width, 1];  // down, left, up, right
  const readWay = () => {
    const runs = numbers.next(), first = place(), way = first < 0 ? [] : [first];
    for (let run = 0; run < runs; run++) {
      const code = numbers.next();
      if (code % 5 === 4) way.push(place());
      else for (let left = Math.floor(code / 5); left > 0; left--) way.push(way.at(-1) + moves[code % 5]);
    }
    return way;
  };
  const readCandidates = (now) => {
    [now.score, now.names] = [texts[numbers.next()], texts[numbers.next()]];
    now.candidates = Array.from({ length: numbers.next() }, () =>
      ({ cell: place(), score: value(), parts: now.names.map(value) }));
  };
  let step = 0, now = null;
  while (numbers.at < numbers.bytes.length) {
    step += numbers.next();
    const changed = numbers.next();
    if (changed & CHANGED.nothing) { entries.push({ step, told: now = null }); continue; }
    now = { candidates: [], names: [], score: "", way: [], ...now };
    if (changed & CHANGED.choice) {
      now.chosen = step - numbers.next();
      [now.goal, now.note] = [place(), texts[numbers.next()]];
    }
    if (changed & CHANGED.candidates) readCandidates(now);
    if (changed & CHANGED.way) now.way = readWay();
    entries.push({ step, told: now });
  }
  return entries;
}

/* What a UAV of a flight tells at a frame, with the rest of its way; null for nothing. */
function toldAt(flight, uav, frame, width) {
  if (flight.why.none !== undefined) return null;
  flight.told ??= flight.why.uavs.map((stream) => readTold(stream, flight.why.texts, width));
  const step = flight.steps[frame], told = flight.told[uav].findLast((entry) => entry.step <= step)?.told;
  if (!told) return null;
  const k = 2 * (frame * flight.team + uav), at = told.way.indexOf(flight.cells[k] * width + flight.cells[k + 1]);
  return { ...told, way: at < 0 ? told.way : told.way.slice(at) };
}

/* A number as people write it, with three digits. */
function brief(number) {
  return Number.isNaN(number) ? "–" : String(Number(number.toPrecision(3))).replace("-", "−");
}

/* The box that says why the chosen UAV flies where it does. */
class Why {
  constructor(replay) {
    this.replay = replay;
    this.chosen = null;  // policy, by its number, and uav
    this.head = element("b");
    this.sentence = element("p");
    this.among = element("p", { className: "among" });
    this.table = element("table");
    const close = button("×", "Close the explanation", () => this.choose(null));
    this.box = element("div", { className: "why", role: "region", ariaLabel: "Explanation", hidden: true },
      element("div", { className: "words" },
        element("div", { className: "title" }, close, this.head), this.sentence, this.among),
      element("div", { className: "scroll", tabIndex: 0, role: "group", ariaLabel: "Candidates" }, this.table));
  }

  /* Explain a UAV; if it is explained already, or for null, explain none. */
  choose(chosen) {
    const again = chosen && this.isChosen(chosen.policy, chosen.uav);
    this.chosen = again ? null : chosen;
    this.replay.changed();
    if (this.chosen) this.box.scrollIntoView({ block: "nearest", behavior: "instant" });
  }

  isChosen(policy, uav) { return this.chosen?.policy === policy && this.chosen.uav === uav; }

  /* The panel of the chosen UAV, if its flight is shown. */
  get panel() { return this.chosen && this.replay.panels.find((panel) => panel.flight.policy === this.chosen.policy && this.chosen.uav < panel.flight.team); }

  /* What is told about the chosen UAV on a panel; null for nothing. */
  toldOn(panel, frame) {
    return panel === this.panel ? toldAt(panel.flight, this.chosen.uav, frame, this.replay.episode.width) : null;
  }

  draw(frame) {
    const { panel } = this;
    this.box.hidden = !panel;
    if (!panel) return;
    const { flight } = panel, now = Math.min(frame, flight.last), told = this.toldOn(panel, now);
    this.head.textContent = `${panel.policy.name}${flight.team > 1 ? ` · UAV ${this.chosen.uav}` : ""} · step ${flight.steps[now]}`;
    this.box.style.setProperty("--uav", this.replay.inks.uav(this.chosen.uav));
    this.sentence.textContent = told ? this.sayGoal(told) : this.sayNothing(flight, now);
    const some = told?.candidates.length;
    this.among.textContent = some ? `The best of its candidates, by ${told.score}:` : "";
    this.table.parentElement.hidden = !some;
    if (some) this.fill(told);
  }

  sayGoal({ goal, way, chosen, note }) {
    const steps = way.length - 1, away = steps > 0 ? `, ${steps} ${steps === 1 ? "step" : "steps"} away` : "";
    const flies = steps === 0 && way[0] === goal ? "Has reached its goal" : "Flies to";
    const said = goal < 0 ? "No goal" : `${flies} ${this.cell(goal)}${away}, chosen at step ${chosen}`;
    return note ? `${said}; ${note}.` : `${said}.`;
  }

  sayNothing(flight, frame) {
    if (flight.why.none !== undefined) return `No explanation: ${flight.why.none}.`;
    return frame === 0 ? "It has not moved yet." : "It tells nothing at this step.";
  }

  /* A cell as its row and column, after its level where there are several. */
  cell(place) {
    const { grid, episode } = this.replay;
    return grid.text(Math.floor(place / episode.width), place % episode.width);
  }

  fill({ goal, names, candidates }) {
    const row = (tag, texts) => element("tr", {}, ...texts.map((text) => element(tag, { textContent: text })));
    const body = candidates.map(({ cell, score, parts }, k) => {
      const made = row("td", [k + 1, this.cell(cell), brief(score), ...parts.map(brief)]);
      if (cell === goal) made.className = "goal";
      if (cell === goal) made.firstChild.setAttribute("aria-label", `${k + 1}, the goal`);
      return made;
    });
    this.table.replaceChildren(element("thead", {}, row("th", ["", "cell", "score", ...names])), element("tbody", {}, ...body));
  }

  get summary() { return this.panel ? `; ${this.head.textContent}: ${this.sentence.textContent}` : ""; }

  /* The chosen UAV in an address. */
  get address() { return this.panel ? `${encodeURIComponent(this.panel.policy.name)},${this.chosen.uav}` : null; }
}

/* Draw the way, the candidates by rank, and the goal of a UAV. */
function markTold(marks, uav, { way, goal, candidates }, width) {
  const { pen, inks, ratio } = marks, colour = inks.uav(uav), half = marks.radius * 0.9;
  const centre = (cell) => marks.centre(Math.floor(cell / width), cell % width);
  pen.lineJoin = "round";
  for (const [line, ink] of [[6, inks.paper], [3, colour]]) {
    pen.strokeStyle = ink;
    pen.lineWidth = line * ratio;
    pen.beginPath();
    marks.line(way.map((cell) => [Math.floor(cell / width), cell % width]));
    pen.stroke();
  }
  const box = (cell, fill, edge, text) => {
    const [x, y] = centre(cell);
    pen.fillStyle = fill;
    pen.strokeStyle = edge;
    pen.lineWidth = 1.5 * ratio;
    pen.fillRect(x - half, y - half, 2 * half, 2 * half);
    pen.strokeRect(x - half, y - half, 2 * half, 2 * half);
    marks.write(text, [x, y], half, edge);
  };
  candidates.map(({ cell }, k) => [cell, String(k + 1)]).reverse().forEach(([cell, rank]) => {
    if (cell !== goal) box(cell, inks.paper, colour, rank);
  });
  const rank = candidates.findIndex(({ cell }) => cell === goal);
  if (rank >= 0) box(goal, colour, inks.paper, String(rank + 1));
  else if (goal >= 0) marks.disc(centre(goal), half * 0.8, inks.paper, colour);
}

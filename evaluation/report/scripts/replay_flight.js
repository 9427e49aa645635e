/* Unpacks an episode: moves, radio contacts and discoveries, and from these what each UAV knew at each step. */
const NEVER = 65535;

/* The whole numbers of a stream: seven bits a byte, lowest first. */
class Numbers {
  constructor(text) { this.bytes = Packed.bytes(text); this.at = 0; }

  next() {
    let number = 0, scale = 1, byte;
    do { byte = this.bytes[this.at++]; number += (byte & 127) * scale; scale *= 128; } while (byte & 128);
    return number;
  }

  signed() { const number = this.next(); return number % 2 ? -(number + 1) / 2 : number / 2; }

  /* Call ``each`` with every place of a list of runs. */
  places(each) {
    let place = 0;
    for (let left = this.next(); left > 0; left--) {
      place += this.next();
      for (let run = this.next(); run >= 0; run--) each(place++);
    }
  }
}

/* What each UAV, and the home base, knows; those linked merge their discoveries, as in the simulation. */
class Minds {
  constructor(count, size) {
    this.known = Array.from({ length: count }, () => new Uint16Array(size).fill(NEVER));
    this.journals = Array.from({ length: count }, () => []);
    this.read = Array.from({ length: count }, () => new Array(count).fill(0));
  }

  learn(mind, cell, frame) {
    if (this.known[mind][cell] !== NEVER) return;
    this.known[mind][cell] = frame;
    this.journals[mind].push(cell);
  }

  merge(group, frame) {
    for (const reader of group) {
      for (const teller of group) {
        const journal = this.journals[teller], end = reader === teller ? 0 : journal.length;
        for (let k = this.read[reader][teller]; k < end; k++) this.learn(reader, journal[k], frame);
        this.read[reader][teller] = Math.max(end, this.read[reader][teller]);
      }
    }
  }
}

/* The groups that contacts [i, j] connect, by their first UAV. */
function groupsOf(contacts, team) {
  const first = Array.from({ length: team }, (_, uav) => uav);
  for (const [i, j] of contacts) {
    const [low, high] = [Math.min(first[i], first[j]), Math.max(first[i], first[j])];
    for (let uav = 0; uav < team; uav++) if (first[uav] === high) first[uav] = low;
  }
  const groups = new Map();
  first.forEach((uav, member) => groups.set(uav, [...(groups.get(uav) || []), member]));
  return [...groups.keys()].sort((a, b) => a - b).map((uav) => groups.get(uav));
}

/* The radio contacts, kept up to date by those that begin or end. */
class Contacts {
  constructor(team) {
    this.team = team;
    this.pairs = [];
    for (let i = 0; i < team; i++) for (let j = i + 1; j < team; j++) this.pairs.push([i, j]);
    this.on = new Set();
    this.refresh();
  }

  refresh() {
    this.now = [...this.on].sort((a, b) => a - b).map((pair) => this.pairs[pair]);
    this.groups = groupsOf(this.now, this.team);
  }

  read(numbers) {
    let changed = false;
    numbers.places((pair) => { changed = true; if (!this.on.delete(pair)) this.on.add(pair); });
    if (changed) this.refresh();
  }
}

/* A map over time. Each part holds from a frame on, until the next one: the frame from which each cell is known. */
class KnownMap {
  constructor(known) { this.parts = [{ from: 0, known }]; }

  get latest() { return this.parts.at(-1).known; }

  add(from, known) { this.parts.push({ from, known }); }

  at(frame) { return this.parts.findLast((part) => part.from <= frame).known; }

  /* Covered cells by frame. */
  coverage(counted, frames) {
    const covered = new Int32Array(frames);
    this.parts.forEach(({ from, known }, place) => {
      const end = this.parts[place + 1]?.from ?? frames;
      for (let cell = 0; cell < known.length; cell++) {
        if (counted[cell] && known[cell] < end) covered[Math.max(known[cell], from)]++;
      }
      for (let frame = from + 1; frame < end; frame++) covered[frame] += covered[frame - 1];
    });
    return covered;
  }
}

/* What those know together that have not stopped, by frame. */
function unionOf(minds, stops, size) {
  const together = (frame) => {
    const union = new Uint16Array(size).fill(NEVER);
    minds.known.forEach((known, mind) => {
      if (stops[mind] <= frame) return;
      for (let cell = 0; cell < size; cell++) if (known[cell] < union[cell]) union[cell] = known[cell];
    });
    return union;
  };
  const union = new KnownMap(together(0));
  const frames = [...new Set(stops)].filter((frame) => frame < NEVER).sort((one, other) => one - other);
  for (const frame of frames) union.add(frame, together(frame));
  return union;
}

/* What the team knows together where the maps of single UAVs are left out. */
class TeamMap extends KnownMap {
  constructor(size) { super(new Uint16Array(size).fill(NEVER)); }

  lose(numbers, frame) {
    this.add(frame, this.latest.slice());
    numbers.places((cell) => { this.latest[cell] = NEVER; });
  }

  learn(numbers, frame) { numbers.places((cell) => { this.latest[cell] = frame; }); }

  /* Where maps can be wrong: the cells that begin, or cease, to be what this map is about. */
  revise(numbers, frame) {
    const cells = [];
    numbers.places((cell) => cells.push(cell));
    if (cells.some((cell) => this.latest[cell] !== NEVER)) this.add(frame, this.latest.slice());
    for (const cell of cells) this.latest[cell] = this.latest[cell] === NEVER ? frame : NEVER;
  }
}

/* Unpack a flight. Its maps are the team's, the home base's, and where the page has them each UAV's by its number. */
function readFlight(flight, episode) {
  const numbers = new Numbers(flight.stream), team = flight.team, size = episode.width * episode.height;
  const steps = [];
  for (let step = 0; step < flight.steps; step += episode.stride) steps.push(step);
  steps.push(flight.steps);
  const stops = new Array(team).fill(NEVER);
  for (const [uav, step] of flight.stops) stops[uav] = steps.findIndex((shown) => shown >= step);
  const frames = steps.length, cells = new Int16Array(frames * team * 2), before = new Int32Array(team * 2);
  const distance = new Float64Array(frames), bytes = new Float64Array(frames), links = [];
  const count = team + (episode.base ? 1 : 0), contacts = new Contacts(count), minds = new Minds(count, size);
  const together = new TeamMap(size), atBase = new TeamMap(size), wrong = new TeamMap(size);
  for (let frame = 0; frame < frames; frame++) {
    for (let k = 0; k < before.length; k++) cells[frame * before.length + k] = before[k] += numbers.signed();
    distance[frame] = (distance[frame - 1] || 0) + numbers.next();
    bytes[frame] = (bytes[frame - 1] || 0) + numbers.next();
    contacts.read(numbers);
    links.push(contacts.now);
    for (const group of episode.own ? contacts.groups : []) {
      numbers.places((cell) => minds.learn(group[0], cell, frame));
      minds.merge(group, frame);
    }
    if (episode.revised) {
      for (const map of [together, wrong, ...(episode.base ? [atBase] : [])]) map.revise(numbers, frame);
      continue;
    }
    if (episode.own) continue;
    if (stops.includes(frame)) together.lose(numbers, frame);
    together.learn(numbers, frame);
    if (episode.base) atBase.learn(numbers, frame);
  }
  const maps = { team: episode.own ? unionOf(minds, stops, size) : together }, covered = {};
  if (episode.base) maps.base = episode.own ? new KnownMap(minds.known[team]) : atBase;
  if (episode.own && count > 1) for (let uav = 0; uav < team; uav++) maps[uav] = new KnownMap(minds.known[uav]);
  for (const [name, map] of Object.entries(maps)) covered[name] = map.coverage(episode.isCounted, frames);
  return { ...flight, stops, steps, cells, distance, bytes, links, maps, covered, wrong, last: frames - 1 };
}

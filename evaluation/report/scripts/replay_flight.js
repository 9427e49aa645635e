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

/* What each UAV knows; linked UAVs merge their discoveries, as in the simulation. */
class Minds {
  constructor(count, size) {
    this.team = new Uint16Array(size).fill(NEVER);
    this.known = Array.from({ length: count }, () => new Uint16Array(size).fill(NEVER));
    this.journals = Array.from({ length: count }, () => []);
    this.read = Array.from({ length: count }, () => new Array(count).fill(0));
  }

  learn(mind, cell, frame) {
    if (this.known[mind][cell] !== NEVER) return;
    this.known[mind][cell] = frame;
    this.journals[mind].push(cell);
    if (this.team[cell] === NEVER) this.team[cell] = frame;
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

/* Covered cells by frame, given the frame at which each cell became known. */
function coverage(known, counted, frames) {
  const covered = new Int32Array(frames);
  for (let cell = 0; cell < known.length; cell++) if (counted[cell] && known[cell] !== NEVER) covered[known[cell]]++;
  for (let frame = 1; frame < frames; frame++) covered[frame] += covered[frame - 1];
  return covered;
}

/* Unpack a flight. Its maps are the team's and, where the page has them, each UAV's by its number. */
function readFlight(flight, episode) {
  const numbers = new Numbers(flight.stream), team = flight.team, size = episode.width * episode.height;
  const steps = [];
  for (let step = 0; step < flight.steps; step += episode.stride) steps.push(step);
  steps.push(flight.steps);
  const frames = steps.length, cells = new Int16Array(frames * team * 2), before = new Int32Array(team * 2);
  const distance = new Float64Array(frames), bytes = new Float64Array(frames), links = [];
  const minds = new Minds(episode.own ? team : 1, size), contacts = new Contacts(team);
  for (let frame = 0; frame < frames; frame++) {
    for (let k = 0; k < before.length; k++) cells[frame * before.length + k] = before[k] += numbers.signed();
    distance[frame] = (distance[frame - 1] || 0) + numbers.next();
    bytes[frame] = (bytes[frame - 1] || 0) + numbers.next();
    contacts.read(numbers);
    links.push(contacts.now);
    for (const group of episode.own ? contacts.groups : [[0]]) {
      numbers.places((cell) => minds.learn(group[0], cell, frame));
      minds.merge(group, frame);
    }
  }
  const maps = { ...(episode.own && team > 1 ? minds.known : []), team: minds.team }, covered = {};
  for (const [name, known] of Object.entries(maps)) covered[name] = coverage(known, episode.isCounted, frames);
  return { ...flight, steps, cells, distance, bytes, links, maps, covered, last: frames - 1 };
}

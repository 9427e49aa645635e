/* The view in three dimensions in one panel: its scene, and over it what the slices mark, too. */

/* Marks at the places to which a camera projects their cells. */
class SpaceMarks extends Marks {
  constructor(pen, flight, base, frame, ratio, inks, view) {
    super(pen, flight, base, frame, 0, ratio, inks, view.voxels.grid);
    this.view = view;
  }

  centre(row, column) { return this.view.project(this.view.voxels.place(row, column)); }

  line(cells) { cells.forEach(([row, column], k) => this.pen[k ? "lineTo" : "moveTo"](...this.centre(row, column))); }

  /* A line from each UAV to the floor below it. */
  plumbs() {
    const { pen, view: { voxels } } = this;
    pen.lineWidth = this.ratio;
    this.eachUav((uav, colour) => {
      const [row, column] = this.cell(uav);
      let below = row * voxels.width + column;
      while (below >= voxels.rise && !voxels.walls[below - voxels.rise]) below -= voxels.rise;
      const [x, floor, z] = voxels.placeOf(below), foot = this.view.project([x, floor - 0.48, z]);
      pen.strokeStyle = pen.fillStyle = colour;
      pen.setLineDash([3 * this.ratio, 2 * this.ratio]);
      pen.beginPath();
      pen.moveTo(...this.at(uav));
      pen.lineTo(...foot);
      pen.stroke();
      pen.setLineDash([]);
      pen.beginPath();
      pen.ellipse(...foot, 4 * this.ratio, 2 * this.ratio, 0, 0, 2 * Math.PI);
      pen.fill();
    });
  }

  /* The numbers of the levels, where there is room, at the corner of the building furthest to the left. */
  levels(levels) {
    const { pen, view } = this, { wide, high } = this.grid, corners = [[0, 0], [wide, 0], [0, high], [wide, high]];
    const left = ([x, z]) => view.project([x, 0, z])[0];
    const [x, z] = corners.reduce((one, other) => (left(other) < left(one) ? other : one));
    const at = (level) => view.project([x, level + 0.5, z]), room = 13 * this.ratio;
    const every = Math.max(1, Math.ceil(room / Math.max(1, Math.hypot(at(1)[0] - at(0)[0], at(1)[1] - at(0)[1]))));
    pen.font = `${11 * this.ratio}px system-ui, sans-serif`;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.fillStyle = this.inks.soft;
    for (let level = 0; level < levels; level += every) {
      const [across, down] = at(level);
      const text = level ? String(level) : "level 0";
      pen.fillText(text, Math.max(across - 5 * this.ratio, pen.measureText(text).width + 3 * this.ratio), down);
    }
  }
}

/* Pixels within which a pressed pointer has not been dragged. */
const STILL = 5;

class SpacePanel {
  constructor(panel, space) {
    Object.assign(this, { panel, space });
    this.canvas = element("canvas", { className: "space", role: "img", tabIndex: 0,
      title: "Click a UAV to explain it; drag to turn the building; drag with the right button or two fingers to move it; pinch, or after a click the wheel, to zoom" });
    panel.box.querySelector(".window").after(this.canvas);
    this.controls = space.orbit.attach(this.canvas);
    this.canvas.addEventListener("pointerdown", (event) => { this.pressed = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("click", (event) => this.pick(event));
    this.building = new BuildingScene(space.colours());
  }

  /* Explain the UAV that was clicked at, unless the click ends a drag. */
  pick(event) {
    const [x, y] = this.pressed || [event.clientX, event.clientY];
    if (Math.hypot(event.clientX - x, event.clientY - y) < STILL) this.panel.pick(event, this.canvas.marks);
  }

  remove() {
    this.controls.dispose();
    this.canvas.remove();
  }

  resize(width, height, ratio) {
    Object.assign(this.canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    this.canvas.style.width = `${width}px`;
    this.canvas.style.height = `${height}px`;
  }

  /* Take a flight with its trails, where it or the colours are others than before. */
  load(voxels, inks) {
    const { flight } = this.panel;
    if (this.flight === flight && this.inks === inks) return;
    Object.assign(this, { flight, inks, voxels });
    this.building.paint(this.space.colours());
    this.building.frame([voxels.width, voxels.grid.levels, voxels.grid.high]);
    this.building.trails.load(flight, voxels, inks);
  }

  /* Show a frame, as far as the lowest ``levels`` go. */
  draw(frame, levels) {
    const { replay } = this.space, { layers } = replay, now = this.now = Math.min(frame, this.flight.last);
    const known = this.flight.maps[replay.mapOf(this.flight)].at(now);
    this.canvas.cells = this.voxels.at(known, now, levels);
    this.building.show(this.voxels, this.canvas.cells, layers);
    this.building.trails.show(layers.has("trails") ? now : 0, levels);
    this.canvas.setAttribute("aria-label", `Levels 0 to ${levels - 1} at step ${this.flight.steps[now]} of ${this.panel.policy.name}, in three dimensions`);
    this.render();
  }

  /* Draw what is shown from where the camera is. */
  render() {
    const { width, height } = this.canvas, { camera } = this.space.orbit, pen = this.canvas.getContext("2d"), { one } = Renderer;
    one.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    one.render(this.building.scene, camera);
    pen.clearRect(0, 0, width, height);
    pen.drawImage(one.domElement, 0, 0);
    this.mark(pen);
  }

  mark(pen) {
    const { replay } = this.space, { layers, why, episode, inks } = replay, ratio = window.devicePixelRatio || 1;
    const marks = this.canvas.marks = new SpaceMarks(pen, this.flight, episode.base, this.now, ratio, inks, this);
    const told = why.toldOn(this.panel, this.now);
    marks.levels(this.voxels.grid.levels);
    marks.plumbs();
    if (layers.has("links")) marks.links();
    marks.pad();
    if (told) markTold(marks, why.chosen.uav, told, episode.width);
    marks.team(replay.mapOf(this.flight));
  }

  /* Where a place [x, y, z] is on the canvas. */
  project(place) {
    const { x, y } = new THREE.Vector3(...place).project(this.space.orbit.camera);
    return [(x + 1) / 2 * this.canvas.width, (1 - y) / 2 * this.canvas.height];
  }
}

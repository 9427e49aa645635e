/* What is drawn of a flight over several levels in three dimensions: cells, trails, and the frame of the building. */

/* Boxes, or other bodies, of one kind, as many as needed. */
class Bodies {
  constructor(group, geometry, material) {
    Object.assign(this, { group, geometry, material, room: 0, mesh: null });
    this.matrix = new THREE.Matrix4();
  }

  /* Have room for ``count`` bodies. */
  reserve(count) {
    if (count <= this.room) return;
    if (this.mesh) { this.group.remove(this.mesh); this.mesh.dispose(); }
    this.room = Math.max(64, Math.ceil(1.5 * count));
    this.mesh = new THREE.InstancedMesh(this.geometry, this.material, this.room);
    this.mesh.frustumCulled = false;
    this.group.add(this.mesh);
  }

  /* Put a body at each of some places [x, y, z]; colours have no alpha. */
  put(places, colourOf = null) {
    this.reserve(places.length);
    if (!this.mesh) return;
    places.forEach(([x, y, z], k) => {
      this.mesh.setMatrixAt(k, this.matrix.makeTranslation(x, y, z));
      if (colourOf) this.mesh.setColorAt(k, colourOf(y));
    });
    this.show(places.length);
  }

  show(count) {
    this.mesh.count = count;
    this.mesh.instanceMatrix.needsUpdate = true;
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }
}

/* The faces of obstacles: light, with an edge. */
function edgedTexture() {
  const sheet = element("canvas", { width: 64, height: 64 }), pen = sheet.getContext("2d");
  pen.fillStyle = "#c4c4c4";
  pen.fillRect(0, 0, 64, 64);
  pen.fillStyle = "#ffffff";
  pen.fillRect(3, 3, 58, 58);
  const texture = new THREE.CanvasTexture(sheet);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.anisotropy = 8;
  return texture;
}

/* The scene of one panel. */
class BuildingScene {
  constructor(colours) {
    this.scene = new THREE.Scene();
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(0.45, 1, 0.8);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8890a0, 1.6), sun);
    const plain = (options) => new THREE.MeshBasicMaterial({ transparent: true, depthWrite: false, ...options });
    const box = new THREE.BoxGeometry(1, 1, 1), spot = new THREE.BoxGeometry(0.36, 0.36, 0.36);
    const tile = new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2).translate(0, -0.48, 0);
    this.walls = new Bodies(this.scene, box, new THREE.MeshLambertMaterial({ map: edgedTexture() }));
    this.floors = new Bodies(this.scene, tile, plain({ opacity: 0.6, side: 2 }));
    this.frontier = new Bodies(this.scene, spot, plain({ opacity: 0.8 }));
    this.trails = new TrailBodies(this.scene);
    this.border = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
    this.border.frustumCulled = false;
    this.scene.add(this.border);
    this.paint(colours);
  }

  /* Take the colours of a theme. */
  paint(colours) {
    this.colours = colours;
    this.floors.material.color.set(colours.floor);
    this.frontier.material.color.set(colours.frontier);
    this.border.material.color.set(colours.border);
  }

  /* Show the sets of cells of a map. */
  show(voxels, sets, layers) {
    const places = (cells, layer) => (layers.has(layer) ? cells.map((cell) => voxels.placeOf(cell)) : []);
    const top = Math.max(1, voxels.grid.levels - 1), low = new THREE.Color(this.colours.low), shade = new THREE.Color();
    const high = new THREE.Color(this.colours.high);
    this.walls.put(places(sets.walls, "known"), (y) => shade.lerpColors(low, high, (y - 0.5) / top));
    this.floors.put(places(sets.floors, "known"));
    this.frontier.put(places(sets.frontier, "frontier"));
  }

  /* Draw the edges of a building of so many columns, levels and rows. */
  frame(size) {
    const points = [];
    for (let axis = 0; axis < 3; axis++) {
      for (let corner = 0; corner < 4; corner++) {
        const from = [0, 0, 0];
        from[(axis + 1) % 3] = (corner & 1) * size[(axis + 1) % 3];
        from[(axis + 2) % 3] = (corner >> 1) * size[(axis + 2) % 3];
        const to = [...from];
        to[axis] = size[axis];
        points.push(new THREE.Vector3(...from), new THREE.Vector3(...to));
      }
    }
    this.border.geometry.dispose();
    this.border.geometry = new THREE.BufferGeometry().setFromPoints(points);
  }
}

/* The trails of a team as thin rods, one for each move, in the order of the frames; faint where obstacles hide them, and
   above the levels that are shown. */
class TrailBodies {
  constructor(group) {
    const rod = new THREE.CylinderGeometry(0.1, 0.1, 1, 6);
    const faint = { transparent: true, opacity: 0.3, depthTest: false, depthWrite: false };
    this.top = new THREE.Plane(new THREE.Vector3(0, -1, 0));
    this.bodies = [{ transparent: true, clippingPlanes: [this.top] }, faint].map((look) => new Bodies(group, rod, new THREE.MeshBasicMaterial(look)));
  }

  /* Take the whole flight; UAVs fly a little beside each other, so that each is seen where ways coincide. */
  load(flight, voxels, inks) {
    const rods = [];
    this.ends = new Int32Array(flight.last + 1);
    for (let frame = 1; frame <= flight.last; frame++) {
      for (let uav = 0; uav < flight.team; uav++) {
        const [from, to] = [frame - 1, frame].map((when) => TrailBodies.at(flight, voxels, uav, when));
        if (from.distanceToSquared(to) > 0) rods.push([from, to, inks.uav(uav)]);
      }
      this.ends[frame] = rods.length;
    }
    for (const bodies of this.bodies) this.fill(bodies, rods);
  }

  static at(flight, voxels, uav, frame) {
    const k = 2 * (frame * flight.team + uav), aside = (uav - (flight.team - 1) / 2) * Math.min(0.24, 0.8 / flight.team);
    return new THREE.Vector3(...voxels.place(flight.cells[k], flight.cells[k + 1])).addScalar(aside);
  }

  fill(bodies, rods) {
    const up = new THREE.Vector3(0, 1, 0), turn = new THREE.Quaternion(), size = new THREE.Vector3(1, 1, 1), colour = new THREE.Color();
    bodies.reserve(Math.max(1, rods.length));
    rods.forEach(([from, to, ink], k) => {
      const along = to.clone().sub(from);
      size.y = along.length() + 0.1;
      turn.setFromUnitVectors(up, along.normalize());
      bodies.mesh.setMatrixAt(k, bodies.matrix.compose(from.clone().add(to).multiplyScalar(0.5), turn, size));
      bodies.mesh.setColorAt(k, colour.set(ink));
    });
    bodies.show(0);
  }

  /* Show the trails up to a frame. */
  show(frame, levels) {
    this.top.constant = levels;
    for (const { mesh } of this.bodies) mesh.count = this.ends[frame];
  }
}

/* The camera of a replay in three dimensions, and what draws its scenes. */

/* Draws the scenes of all replays of the page, as browsers limit how many may do so; null where there is no WebGL. */
const Renderer = {
  get one() { return (this.made === undefined ? this.made = this.make() : this.made); },

  make() {
    const canvas = element("canvas"), context = canvas.getContext("webgl2", { alpha: true, antialias: true });
    if (!context) return null;
    const made = new THREE.WebGLRenderer({ canvas, context });
    made.localClippingEnabled = true;
    return made;
  },
};

/* A camera that turns around a building; all panels of a replay look from the same place. */
class Orbit {
  constructor(moved) {
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.1, 10000);
    this.target = new THREE.Vector3();
    this.moved = moved;
  }

  /* Look at a building of some size [columns, levels, rows] from above, so that it fills a canvas of some aspect. */
  reset(size, aspect) {
    const half = new THREE.Vector3(...size).multiplyScalar(0.5), { camera } = this, away = new THREE.Vector3(0.42, 1.3, 0.8).normalize();
    const right = new THREE.Vector3(0, 1, 0).cross(away).normalize(), up = away.clone().cross(right);
    const high = Math.tan(camera.fov * Math.PI / 360) * 0.97;
    let distance = 0;
    for (let k = 0; k < 8; k++) {
      const corner = half.clone().multiply(new THREE.Vector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
      const across = Math.max(Math.abs(corner.dot(up)), Math.abs(corner.dot(right)) / aspect / 0.93);
      distance = Math.max(distance, across / high + corner.dot(away));
    }
    this.target.copy(half);
    camera.position.copy(away).multiplyScalar(distance).add(half);
    camera.lookAt(half);
    this.fitted = aspect;
  }

  /* Turn with what happens on a canvas. A wheel zooms once the canvas was clicked, so that it does not stop the page. */
  attach(canvas) {
    const place = this.camera.position.clone(), controls = new THREE.OrbitControls(this.camera, canvas);
    Object.assign(controls, { target: this.target, maxPolarAngle: Math.PI * 0.94, enableZoom: false, zoomToCursor: false });
    this.camera.position.copy(place);
    this.camera.lookAt(this.target);
    canvas.addEventListener("pointerdown", () => canvas.focus({ preventScroll: true }));
    canvas.addEventListener("focus", () => { controls.enableZoom = true; });
    canvas.addEventListener("blur", () => { controls.enableZoom = false; });
    controls.addEventListener("change", () => this.moved());
    return controls;
  }
}

/* The timeline: the coverage curves of the shown flights, and a handle that is dragged along them. */
class Timeline {
  constructor(replay) {
    this.replay = replay;
    this.canvas = element("canvas");
    this.box = element("div", {
      className: "timeline", role: "slider", tabIndex: 0, ariaLabel: "Step", ariaValueMin: "0",
    }, this.canvas);
    const seek = (event) => {
      const left = this.box.getBoundingClientRect().left + INSET.left;
      replay.seek(Math.round((event.clientX - left) / this.inner * replay.last));
    };
    this.box.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      this.box.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.box.addEventListener("pointermove", (event) => {
      if (this.box.hasPointerCapture(event.pointerId)) seek(event);
    });
  }

  get inner() { return Math.max(1, this.box.clientWidth - INSET.left - INSET.right); }

  draw() {
    const ratio = window.devicePixelRatio || 1, { clientWidth, clientHeight } = this.box;
    this.canvas.width = clientWidth * ratio;
    this.canvas.height = clientHeight * ratio;
    const pen = this.pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const low = clientHeight - INSET.bottom, last = Math.max(1, this.replay.last);
    this.x = (frame) => INSET.left + frame / last * this.inner;
    this.y = (part) => low - part * (low - INSET.top);
    this.drawGrid();
    for (const panel of this.replay.panels) this.drawCurve(panel);
    this.drawHand(low);
    this.tell();
  }

  drawGrid() {
    const { pen } = this, { inks } = this.replay;
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.lineWidth = 1;
    for (const part of [0, 0.5, 0.9]) {
      const y = Math.round(this.y(part)) + 0.5;
      pen.strokeStyle = inks.line;
      pen.beginPath();
      pen.moveTo(INSET.left, y);
      pen.lineTo(INSET.left + this.inner, y);
      pen.stroke();
      pen.fillStyle = inks.soft;
      pen.fillText(`${100 * part} %`, INSET.left - 6, y);
    }
  }

  drawCurve(panel) {
    const { pen } = this, { total } = this.replay.episode, { last } = panel.flight;
    pen.strokeStyle = pen.fillStyle = this.replay.inks.policy(panel.policy);
    pen.lineWidth = 2;
    pen.setLineDash(panel.policy.dashes);
    pen.beginPath();
    for (let frame = 0; frame <= last; frame++) pen.lineTo(this.x(frame), this.y(panel.coveredAt(frame) / total));
    pen.stroke();
    pen.setLineDash([]);
    const now = Math.min(this.replay.frame, last);
    pen.beginPath();
    pen.arc(this.x(now), this.y(panel.coveredAt(now) / total), 3.5, 0, 2 * Math.PI);
    pen.fill();
  }

  drawHand(low) {
    const { pen } = this, { inks, frame } = this.replay, x = this.x(frame);
    pen.strokeStyle = pen.fillStyle = inks.ink;
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(x, INSET.top - 4);
    pen.lineTo(x, low);
    pen.stroke();
    pen.beginPath();
    pen.arc(x, low + 6, 6, 0, 2 * Math.PI);
    pen.fill();
  }

  tell() {
    this.box.setAttribute("aria-valuemax", this.replay.lastStep);
    this.box.setAttribute("aria-valuenow", this.replay.step);
    this.box.setAttribute("aria-valuetext", `step ${this.replay.step} of ${this.replay.lastStep}`);
  }
}

/* Room around the curves in CSS pixels. */
const INSET = { left: 44, right: 10, top: 10, bottom: 14 };

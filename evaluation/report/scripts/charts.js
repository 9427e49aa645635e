/* Coverage charts: mean curves with bands against steps, distance, thinking time or bytes sent. */
"use strict";
const UNITS = { steps: "", distance: " cells", seconds: " s", bytes: " bytes" };

class CoverageChart extends Chart {
  constructor(id) {
    super("chart", id);
    this.axisKey = this.data.axes[0].key;
    this.who = this.data.who[0];
    this.span = "focus";
    this.from = "zero";
    this.bands = this.data.bands;
    this.draw();
    this.box.on("plotly_click", (event) => this.open(event));
  }

  get along() { return this.data.axes.find((axis) => axis.key === this.axisKey); }

  /* Open the replay where the curve nearest to the pointer was clicked. */
  open(event) {
    if (!window.openReplay) return;
    const top = this.box.getBoundingClientRect().top;
    const means = event.points.filter((point) => point.data.meta !== undefined);
    if (!means.length) return;
    const away = (point) => Math.abs(point.yaxis._offset + point.yaxis.l2p(point.y) - (event.event.clientY - top));
    const nearest = means.reduce((best, point) => (away(point) < away(best) ? point : best));
    const step = this.axisKey === "steps" ? nearest.x : null;
    window.openReplay(this.id, { policy: nearest.data.meta, step, task: null });
  }

  traces(policy) {
    const curves = policy.curves[this.axisKey][this.who], style = this.style(policy), x = this.along.amounts;
    const mean = Packed.shares(curves.mean);
    const common = { x, visible: this.visibility.shows(policy.name) };
    const text = mean.map((value) => percent(value));
    const extra = [];
    if (curves.low) {
      const low = Packed.shares(curves.low), high = Packed.shares(curves.high);
      low.forEach((value, k) => { text[k] += `  [${percent(value)}, ${percent(high[k])}]`; });
      if (this.bands === "shown") extra.push({
        ...common, x: x.concat(x.slice().reverse()), y: low.concat(high.reverse()), fill: "toself",
        fillcolor: faded(style.color, 0.15), line: { width: 0 }, mode: "lines", hoverinfo: "skip",
      });
    }
    for (const each of curves.each || []) {
      extra.push({
        ...common, y: Packed.shares(each), mode: "lines", opacity: 0.45, hoverinfo: "skip", line: { color: style.color, width: 1 },
      });
    }
    const line = {
      ...common, y: mean, text, meta: policy.name, name: this.name(policy), mode: "lines+markers", line: style.line,
      marker: { ...style.marker, maxdisplayed: 9 }, hovertemplate: "%{text}",
    };
    return { extra, line };
  }

  xaxis() {
    const along = this.along, most = along.amounts[along.amounts.length - 1];
    const limit = this.span === "focus" ? along.focus : most;
    const unit = along.key === "steps" ? "" : ` [${along.unit}]`;
    const shape = along.log
      ? { type: "log", range: [along.amounts[0], most].map((amount) => Math.log10(amount)), dtick: 1, exponentformat: "power" }
      : { range: [0, limit] };
    const hover = along.key === "steps" ? "step %{x}" : `%{x:.4~g}${UNITS[along.key]}`;
    return this.axis(along.title + unit, { ...shape, ticks: "outside", ticklen: 4, showline: true, unifiedhovertitle: { text: hover }, ...spikes() });
  }

  yaxis() {
    const top = this.from === "top";
    const ticks = top ? [0.8, 0.85, 0.9, 0.95, 0.99, 1] : [0, 0.25, 0.5, 0.75, 0.9, 0.99];
    return this.axis(this.narrow ? "" : "coverage", {
      range: top ? [0.8, 1.004] : [0, 1.02], tickvals: ticks, ticktext: ticks.map((share) => `${Math.round(100 * share)} %`),
    });
  }

  draw() {
    const along = this.along;
    const most = along.amounts[along.amounts.length - 1];
    this.offerSpan(along.log ? most : along.focus, most);
    const parts = this.data.policies.map((policy) => this.traces(policy));
    const guides = [0.9, 0.99].map((y) => ({
      type: "line", xref: "paper", x0: 0, x1: 1, y0: y, y1: y, layer: "below",
      line: { color: Theme.colour("--soft"), width: 1, dash: "dot" },
    }));
    const layout = this.layout({ xaxis: this.xaxis(), yaxis: this.yaxis(), shapes: guides });
    this.plot([...parts.flatMap((part) => part.extra), ...parts.map((part) => part.line)], layout, "coverage");
  }
}

Parts.each((part) => {
  for (const box of part.querySelectorAll(".chart[id^='chart-']")) new CoverageChart(box.id.slice("chart-".length));
});

/* Coverage charts: drawn by Plotly from the page's data, redrawn when theme, span or UAV choice change. */
"use strict";
const Packed = {
  bytes(text) { return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)); },
  shares(text) {
    const bytes = this.bytes(text), out = new Array(bytes.length / 2);
    for (let k = 0; k < out.length; k++) out[k] = (bytes[2 * k] + 256 * bytes[2 * k + 1]) / 65535;
    return out;
  },
};

class CoverageChart {
  constructor(id) {
    this.box = document.getElementById(`chart-${id}`);
    this.data = JSON.parse(document.getElementById(`chart-data-${id}`).textContent);
    this.who = this.data.who[0];
    this.span = "focus";
    this.hidden = new Map();
    const controls = document.querySelector(`[data-chart-controls="${id}"]`);
    if (this.data.focus >= this.data.budget) controls.querySelector("[data-span]").parentElement.remove();
    controls.addEventListener("click", (event) => this.choose(controls, event.target));
    Theme.listeners.push(() => this.draw());
    this.narrow = this.isNarrow();
    window.addEventListener("resize", () => {
      if (this.narrow !== this.isNarrow()) { this.narrow = this.isNarrow(); this.draw(); }
    });
    this.draw();
  }

  isNarrow() { return this.box.clientWidth < 720; }

  choose(controls, button) {
    const kind = ["who", "span"].find((name) => button.dataset[name]);
    if (!kind) return;
    this[kind] = button.dataset[kind];
    for (const other of controls.querySelectorAll(`[data-${kind}]`)) {
      other.setAttribute("aria-pressed", String(other === button));
    }
    this.draw();
  }

  remember() {
    for (const trace of this.box.data || []) {
      if (trace.meta === "mean") this.hidden.set(trace.legendgroup, trace.visible);
    }
  }

  traces(policy) {
    const curves = policy.curves[this.who], colour = Theme.colour(`--c${policy.colour}`);
    const mean = Packed.shares(curves.mean), steps = this.data.steps;
    const common = { x: steps, legendgroup: policy.name, visible: this.hidden.get(policy.name) ?? true };
    const text = mean.map((value) => percent(value));
    const extra = [];
    if (curves.low) {
      const low = Packed.shares(curves.low), high = Packed.shares(curves.high);
      low.forEach((value, k) => { text[k] += `  [${percent(value)}, ${percent(high[k])}]`; });
      extra.push({
        ...common, x: steps.concat(steps.slice().reverse()), y: low.concat(high.reverse()), fill: "toself",
        fillcolor: faded(colour, 0.16), line: { width: 0 }, mode: "lines", hoverinfo: "skip", showlegend: false,
      });
    }
    for (const each of curves.each || []) {
      extra.push({
        ...common, y: Packed.shares(each), mode: "lines", opacity: 0.45, hoverinfo: "skip", showlegend: false,
        line: { color: colour, width: 1 },
      });
    }
    const name = escaped(policy.name) + (policy.privileged ? " (knows the map)" : "");
    const line = {
      ...common, y: mean, text, meta: "mean", name, mode: "lines+markers",
      line: { color: colour, width: 2, dash: policy.pattern },
      marker: { symbol: SYMBOLS[policy.marker], size: 7, color: colour, maxdisplayed: 9 },
      hovertemplate: "%{text}",
    };
    return { extra, line };
  }

  layout() {
    const ink = Theme.colour("--ink"), soft = Theme.colour("--soft"), line = Theme.colour("--line");
    const limit = this.span === "focus" ? this.data.focus : this.data.budget;
    const guides = [0.9, 0.99];
    const ticks = [0, 0.25, 0.5, 0.75, 0.9, 0.99];
    return {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hovermode: "x unified",
      font: { family: getComputedStyle(document.body).fontFamily, size: 12, color: soft },
      margin: this.narrow ? { l: 44, r: 12, t: 12, b: 44 } : { l: 52, r: 16, t: 14, b: 46 },
      xaxis: {
        title: { text: "step", standoff: 8 }, range: [0, limit], gridcolor: line, zeroline: false, linecolor: soft,
        ticks: "outside", tickcolor: soft, ticklen: 4, showline: true, unifiedhovertitle: { text: "step %{x}" }, spikecolor: soft, spikethickness: 1, spikedash: "dot",
      },
      yaxis: {
        title: this.narrow ? undefined : { text: "coverage", standoff: 8 }, range: [0, 1.02],
        tickvals: ticks, ticktext: ticks.map((share) => `${Math.round(100 * share)} %`), gridcolor: line, zeroline: false,
      },
      shapes: guides.map((y) => ({
        type: "line", xref: "paper", x0: 0, x1: 1, y0: y, y1: y, layer: "below",
        line: { color: soft, width: 1, dash: "dot" },
      })),
      modebar: { bgcolor: "rgba(0,0,0,0)", color: soft, activecolor: ink },
      legend: this.narrow
        ? { orientation: "h", x: 0, y: -0.2, yanchor: "top", font: { color: ink, size: 11 } }
        : { x: 1.02, y: 0.93, font: { color: ink, size: 12 } },
      hoverlabel: { bgcolor: Theme.colour("--paper"), bordercolor: line, font: { color: ink, size: 12 } },
      showlegend: true,
    };
  }

  draw() {
    this.remember();
    const names = this.data.policies.length;
    this.box.style.height = `${this.narrow ? 360 + 18 * names : Math.min(640, Math.max(430, 60 + 20 * names))}px`;
    const parts = this.data.policies.map((policy) => this.traces(policy));
    const traces = [...parts.flatMap((part) => part.extra), ...parts.map((part) => part.line)];
    Plotly.react(this.box, traces, this.layout(), {
      responsive: true, displaylogo: false, displayModeBar: this.narrow ? false : "hover", modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
      toImageButtonOptions: { format: "svg", filename: "coverage" },
    });
  }
}

const SYMBOLS = ["circle", "square", "diamond", "triangle-up", "cross", "x", "triangle-down", "star"];
function percent(share) { return `${(100 * share).toFixed(1)} %`; }
function faded(hex, alpha) {
  const [r, g, b] = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
  return `rgba(${r},${g},${b},${alpha})`;
}
/* Plotly reads a little markup and mathematics in names; show them as written. */
function escaped(name) {
  const entities = { "&": "&amp;", "<": "&lt;", ">": "&gt;", $: "&#36;" };
  return name.replace(/[&<>$]/g, (letter) => entities[letter]);
}

for (const box of document.querySelectorAll(".chart")) new CoverageChart(box.id.slice("chart-".length));
window.addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) details.open = true;
});

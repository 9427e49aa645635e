/* What all charts share: packed numbers, colours, which policies are shown, and the style of axes. */
"use strict";
/* No chart of the page, of plug-ins neither, offers to upload itself. */
Plotly.setPlotConfig({ showSendToCloud: false, showEditInChartStudio: false, plotlyServerURL: "" });
const Packed = {
  bytes(text) { return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)); },
  shares(text) {
    const bytes = this.bytes(text), out = new Array(bytes.length / 2);
    for (let k = 0; k < out.length; k++) out[k] = (bytes[2 * k] + 256 * bytes[2 * k + 1]) / 65535;
    return out;
  },
};
const SYMBOLS = ["circle", "square", "diamond", "triangle-up", "cross", "x", "triangle-down", "star"];
function percent(share) { return `${(100 * share).toFixed(1)} %`; }
function faded(hex, alpha) {
  const [r, g, b] = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
  return `rgba(${r},${g},${b},${alpha})`;
}
/* Escape names, since Plotly interprets some markup and mathematics. */
function escaped(name) {
  const entities = { "&": "&amp;", "<": "&lt;", ">": "&gt;", $: "&#36;" };
  return name.replace(/[&<>$]/g, (letter) => entities[letter]);
}

/* Which policies of a section are shown, in all its charts at once; chosen by the buttons of its legends. */
class Visibility {
  static sections = new Map();
  static of(id) {
    if (!this.sections.has(id)) this.sections.set(id, new Visibility(document.getElementById(id)));
    return this.sections.get(id);
  }

  constructor(section) {
    this.section = section;
    this.hidden = new Set();
    this.listeners = [];
    this.buttons = [...section.querySelectorAll(".legend button[data-name]")];
    this.names = [...new Set(this.buttons.map((button) => button.dataset.name))];
    for (const button of this.buttons) {
      button.addEventListener("click", (event) => this.choose(button.dataset.name, event.shiftKey));
      button.addEventListener("dblclick", () => this.choose(button.dataset.name, true));
    }
    for (const button of section.querySelectorAll(".legend button.all")) {
      button.addEventListener("click", () => { this.hidden.clear(); this.apply(); });
    }
    this.apply();
  }

  choose(name, alone) {
    if (alone) this.hidden = new Set(this.names.filter((other) => other !== name));
    else if (!this.hidden.delete(name)) this.hidden.add(name);
    this.apply();
  }

  shows(name) { return !this.hidden.has(name); }

  apply() {
    for (const button of this.buttons) button.setAttribute("aria-pressed", String(this.shows(button.dataset.name)));
    for (const button of this.section.querySelectorAll(".legend button.all")) button.disabled = !this.hidden.size;
    for (const line of this.section.querySelectorAll(".multiple [data-name]")) {
      line.style.display = this.shows(line.dataset.name) ? "" : "none";
    }
    for (const listener of this.listeners) listener();
  }
}

/* A chart in a section with groups of buttons that choose what it shows. */
class Chart {
  constructor(kind, id) {
    this.id = id;
    this.box = document.getElementById(`${kind}-${id}`);
    this.data = JSON.parse(document.getElementById(`${kind}-data-${id}`).textContent);
    this.controls = document.querySelector(`[data-${kind}-controls="${id}"]`);
    this.visibility = Visibility.of(id);
    this.visibility.listeners.push(() => this.draw());
    Theme.listeners.push(() => this.draw());
    this.controls.addEventListener("click", (event) => this.choose(event.target.closest("button")));
    this.narrow = this.isNarrow();
    window.addEventListener("resize", () => {
      if (this.narrow !== this.isNarrow()) { this.narrow = this.isNarrow(); this.draw(); }
    });
  }

  isNarrow() { return this.box.clientWidth < 620; }

  /* The buttons carry data-choice="what" and data-value. */
  choose(button) {
    if (!button || !button.dataset.choice) return;
    this[button.dataset.choice] = button.dataset.value;
    for (const other of this.controls.querySelectorAll(`[data-choice="${button.dataset.choice}"]`)) {
      other.setAttribute("aria-pressed", String(other === button));
    }
    this.draw();
  }

  /* Say how far the whole axis goes; disable the choice of a span where both show the same. */
  offerSpan(focus, most) {
    for (const button of this.controls.querySelectorAll('[data-choice="span"]')) {
      button.disabled = focus >= most;
      if (button.dataset.value === "whole") button.textContent = `All ${Number(most.toPrecision(4))}`;
    }
  }

  name(policy) { return escaped(policy.name) + (policy.privileged ? " (knows the map)" : ""); }

  style(policy) {
    const color = Theme.colour(`--c${policy.colour}`);
    return { color, line: { color, width: 2, dash: policy.pattern }, marker: { symbol: SYMBOLS[policy.marker], size: 7, color } };
  }

  axis(title, more) {
    const soft = Theme.colour("--soft");
    return {
      title: { text: title, standoff: 8 }, gridcolor: Theme.colour("--line"), zeroline: false, linecolor: soft,
      tickcolor: soft, ...more,
    };
  }

  layout(more) {
    const ink = Theme.colour("--ink"), soft = Theme.colour("--soft");
    return {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hovermode: "x unified", showlegend: false,
      font: { family: getComputedStyle(document.body).fontFamily, size: 12, color: soft },
      margin: this.narrow ? { l: 50, r: 10, t: 12, b: 44 } : { l: 56, r: 14, t: 28, b: 46 },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: soft, activecolor: ink },
      hoverlabel: { bgcolor: Theme.colour("--paper"), bordercolor: Theme.colour("--line"), font: { color: ink, size: 12 } },
      ...more,
    };
  }

  plot(traces, layout, filename) {
    Plotly.react(this.box, traces, layout, {
      responsive: true, displaylogo: false, displayModeBar: this.narrow ? false : "hover",
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], toImageButtonOptions: { format: "svg", filename },
    });
  }
}

function spikes() {
  return { showspikes: true, spikecolor: Theme.colour("--soft"), spikethickness: 1, spikedash: "dot", spikemode: "across" };
}

/* What was folded away when it was drawn had no width. */
document.addEventListener("toggle", (event) => {
  if (event.target.open) for (const box of event.target.querySelectorAll(".js-plotly-plot")) Plotly.Plots.resize(box);
}, true);

/* On paper everything is open, and charts are as wide as the sheet. */
let openedForPrint = [];
window.addEventListener("beforeprint", () => {
  openedForPrint = [...document.querySelectorAll("details:not([open])")];
  for (const details of openedForPrint) details.open = true;
  for (const box of document.querySelectorAll(".js-plotly-plot")) Plotly.relayout(box, { width: Number(box.dataset.printed || 680) });
});
window.addEventListener("afterprint", () => {
  for (const details of openedForPrint) details.open = false;
  for (const box of document.querySelectorAll(".js-plotly-plot")) Plotly.relayout(box, { width: undefined, autosize: true });
});

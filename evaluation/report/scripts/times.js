/* Charts of the share of episodes that reached a threshold by each step, and on the right of those that never did. */
"use strict";
class TimesChart extends Chart {
  constructor(id) {
    super("times", id);
    this.level = this.data.levels[0].key;
    this.span = "focus";
    this.draw();
  }

  get title() { return this.data.levels.find((level) => level.key === this.level).title; }

  /* Steps at which every policy has a point, so that the pointer finds one: all corners, and some between them. */
  grid() {
    const { focus, budget, policies } = this.data, steps = new Set();
    for (let k = 0; k <= 150; k++) steps.add(Math.round(focus * k / 150)).add(Math.round(focus + (budget - focus) * k / 150));
    for (const policy of policies) policy.times[this.level].steps.forEach((step) => steps.add(step));
    return [...steps].sort((one, other) => one - other);
  }

  reached(policy, grid) {
    const times = policy.times[this.level], style = this.style(policy);
    let corner = 0;
    const share = grid.map((step) => {
      while (corner + 1 < times.steps.length && times.steps[corner + 1] <= step) corner++;
      return times.share[corner];
    });
    return {
      x: grid, y: share, visible: this.visibility.shows(policy.name), name: this.name(policy), mode: "lines+markers",
      line: { ...style.line, shape: "hv" }, marker: { ...style.marker, maxdisplayed: 9 },
      hovertemplate: share.map((value) => `${percent(value)} there (${Math.round(value * policy.episodes)}/${policy.episodes})`),
    };
  }

  never(policy, place) {
    const share = policy.times[this.level].share, style = this.style(policy);
    const missed = 1 - share[share.length - 1];
    return {
      x: [place, place], y: [0, missed], xaxis: "x2", visible: this.visibility.shows(policy.name), name: this.name(policy),
      mode: "lines+markers", line: { color: style.color, width: 3 }, marker: { ...style.marker, size: [0, 9], opacity: 1 },
      hovertemplate: ["", `${percent(missed)} never (${Math.round(missed * policy.episodes)}/${policy.episodes})`],
    };
  }

  draw() {
    const { focus, budget, policies } = this.data;
    this.offerSpan(focus, budget);
    const cut = this.narrow ? 0.76 : 0.84;
    const ticks = [0, 0.25, 0.5, 0.75, 1], grid = this.grid();
    const layout = this.layout({
      xaxis: this.axis("step", {
        domain: [0, cut], range: [0, this.span === "focus" ? focus : budget], ticks: "outside", ticklen: 4, showline: true,
        unifiedhovertitle: { text: `${this.title} within %{x} steps` }, ...spikes(),
      }),
      xaxis2: this.axis("never", {
        domain: [cut + 0.02, 1], range: [-0.7, policies.length - 0.3], showticklabels: false, showgrid: false, showline: true,
        unifiedhovertitle: { text: "within the budget" },
      }),
      yaxis: this.axis(this.narrow ? "" : "share of episodes", {
        range: [-0.02, 1.04], tickvals: ticks, ticktext: ticks.map((share) => `${Math.round(100 * share)} %`),
      }),
      shapes: [{
        type: "rect", xref: "paper", yref: "paper", x0: cut + 0.02, x1: 1, y0: 0, y1: 1, layer: "below",
        fillcolor: Theme.colour("--panel"), line: { width: 0 },
      }],
    });
    const traces = [...policies.map((policy) => this.reached(policy, grid)), ...policies.map((policy, k) => this.never(policy, k))];
    this.plot(traces, layout, "times");
  }
}

Parts.each((part) => {
  for (const box of part.querySelectorAll(".chart[id^='times-']")) new TimesChart(box.id.slice("times-".length));
});
